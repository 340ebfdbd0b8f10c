"""Intrinsics of a camera in a file: JSON, or a calibration of KITTI (object, odometry or raw data)."""

from __future__ import annotations

import os

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_text
from lidardraft.formats.kitti import calibration_of, numbers_of
from lidardraft.json_fields import are_numbers, parse_json

_LARGEST = 2**20  # bytes
_JSON_NAMES = ("K", "intrinsics", "camera_matrix")
_KITTI_NAMES = ("P2", "P_rect_02", "P0", "K_02", "K", "P")  # the left colour camera before others


def read_intrinsics(path: str | os.PathLike[str]) -> np.ndarray:
    """(fx, fy, cx, cy) [4] in pixels.

    A .json file holds a matrix [3, 3] or four numbers, alone or as "K", "intrinsics" or "camera_matrix", or an object
    with fx, fy, cx and cy. Any other file is a calibration of KITTI, with P2, else P_rect_02, P0 or K. Raises
    `FormatError`.
    """
    text = read_text(path, _LARGEST)
    with named(path):
        return _from_json(text) if os.fspath(path).lower().endswith(".json") else _from_kitti(text)


def _from_json(text: str) -> np.ndarray:
    found = parse_json(text)
    if isinstance(found, dict):
        if {"fx", "fy", "cx", "cy"} <= set(found):
            found = [found[name] for name in ("fx", "fy", "cx", "cy")]
        else:
            found = next((found[name] for name in _JSON_NAMES if name in found), None)
    if isinstance(found, dict):  # OpenCV's, with its rows, columns and data
        found = found.get("data")
    rows = found if isinstance(found, list) else []
    flat = [value for row in rows for value in (row if isinstance(row, list) else [row])]
    if len(flat) not in (4, 9, 12) or not are_numbers(flat, len(flat)):
        raise FormatError("it holds no intrinsics: fx, fy, cx and cy, or a matrix K [3, 3]")
    return _four(flat)


def _from_kitti(text: str) -> np.ndarray:
    lines = calibration_of(text)
    name = next((name for name in _KITTI_NAMES if name in lines), None)
    if name is None:
        raise FormatError(
            f"not a calibration of KITTI: it has no line {', '.join(_KITTI_NAMES[:-1])} or {_KITTI_NAMES[-1]}"
        )
    with named(name):
        return _four(numbers_of(lines[name], 9, 12))


def _four(flat: list[float]) -> np.ndarray:
    width = {4: 0, 9: 3, 12: 4}[len(flat)]
    at = (0, 1, 2, 3) if not width else (0, width + 1, 2, width + 2)
    return np.array([flat[index] for index in at], dtype=np.float64)
