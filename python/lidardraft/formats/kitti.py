"""KITTI: scans, .bin files of float32 x y z intensity in the sensor frame, and calibrations (Geiger, IJRR 2013)."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Sequence

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_bytes, written_whole
from lidardraft.formats.point_fields import unit_intensity

_POINT_BYTES = 16
_FURTHEST, _FLAT = 1000.0, 0.5  # m; relative to the width of a scan: its height is less
_TEXT, _PRINTED = 32, {*range(32, 127), *b"\t\r\n"}  # this many printable characters in a row are not coordinates

# First bytes of files other than scans of KITTI; as numbers these would be kilometres or less than an atom.
_OTHERS = {
    b"\x89PNG": "PNG",
    b"\xff\xd8\xff": "JPEG",
    b"glTF": "binary glTF",
    b"ply\n": "PLY",
    b"ply\r": "PLY",
    b"LASF": "LAS",
    b"# .P": "PCD",
    b"\x93NUM": "NumPy",
    b"PK\x03\x04": "a zip",
}


def read_bin(path: str | os.PathLike[str], intensity_scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Points f32 [N, 3] in metres and intensity f32 [N] in [0, 1], that of the file over `intensity_scale`.

    Raises `FormatError` on a missing, empty or truncated file, and on a value that is not finite. Of the intensities at
    most 1 % may be out of range, and are clipped; more are an error. The error says if the file looks like points of
    other columns.
    """
    name, data = os.fspath(path), read_bytes(path)
    if not data:
        raise FormatError(f"{name} is empty: a scan without returns")
    if other := next((kind for start, kind in _OTHERS.items() if data.startswith(start)), None):
        raise FormatError(f"{name} is {other}; a KITTI scan is float32 x y z and intensity, and nothing before them")
    if looks_like_text(data):
        raise FormatError(f"{name} is text; a KITTI scan is float32 x y z and intensity")
    try:
        if len(data) % _POINT_BYTES:
            raise FormatError(
                f"{name} has {len(data)} bytes; a KITTI scan has {_POINT_BYTES} a point, so it is truncated"
            )
        scan = np.frombuffer(data, dtype="<f4").reshape(-1, 4).astype(np.float32)
        _check(name, scan, math.inf)
        with named(path):
            return scan[:, :3].copy(), unit_intensity(scan[:, 3], intensity_scale, of=path)
    except FormatError:
        if other := _other_columns(data):
            raise FormatError(f"{name} looks like {other}; a KITTI scan is float32 x y z and intensity") from None
        raise


def _other_columns(data: bytes) -> str:
    """The likely columns of a file that is not a scan; "" for float32 x y z and intensity, or if there is no guess.
    Points are near and spread less in height than in width; further columns are not less than 0."""
    for kind, columns in itertools.product(("<f4", "<f8"), (4, 5, 6, 7, 8, 3)):
        if len(data) % (columns * int(kind[2])):
            continue
        points = np.frombuffer(data, kind).reshape(-1, columns)
        if (np.abs(points[:, :3]) < _FURTHEST).all() and (points[:, 3:] >= 0).all():
            if columns == 4 and kind == "<f4":
                return ""
            if points[:, 2].std() < _FLAT * points[:, :2].std():
                found = f"{columns} columns of float{8 * int(kind[2])}"
                return f"{found} (nuScenes' .pcd.bin?)" if found.startswith("5 columns of float32") else found
    return ""


def calibration_of(text: str) -> dict[str, list[str]]:
    """The words of each line `name: words` of a calibration; some files lack the colon."""
    lines = (line.replace(":", " ", 1).split() for line in text.splitlines())
    return {words[0]: words[1:] for words in lines if words}


def numbers_of(words: Sequence[str], *counts: int) -> list[float]:
    """The numbers of some words; raises `FormatError` unless they are as many finite numbers as one of `counts`."""
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) not in counts or not np.isfinite(values).all():
        raise FormatError(f"{' '.join(words)!r:.80} is not {' or '.join(map(str, counts))} finite numbers")
    return values


def looks_like_text(data: bytes) -> bool:
    """Whether a file begins with printable characters only, which coordinates of a scan hardly ever do."""
    return len(data) >= _TEXT and all(byte in _PRINTED for byte in data[:_TEXT])


def write_bin(path: str | os.PathLike[str], points: np.ndarray, intensity: np.ndarray) -> None:
    """Write points [N, 3] in metres and intensity [N] in [0, 1]. The inverse of `read_bin`, with the same limits; but a
    scan without points becomes an empty file."""
    name = os.fspath(path)
    if points.ndim != 2 or points.shape[1] != 3 or intensity.shape != points.shape[:1]:
        raise FormatError(f"{name}: points {points.shape} and intensity {intensity.shape} must be [N, 3] and [N]")
    scan = np.column_stack([points, intensity]).astype("<f4")
    _check(name, scan)
    with written_whole(path) as temporary:
        temporary.write_bytes(scan.tobytes())


def _check(name: str, scan: np.ndarray, most: float = 1.0) -> None:
    broken = np.flatnonzero(~np.isfinite(scan).all(axis=1))
    if len(broken):
        raise FormatError(f"{name}: point {broken[0]} is {scan[broken[0]].tolist()}; every value must be finite")
    outside = np.flatnonzero((scan[:, 3] < 0) | (scan[:, 3] > most))
    if len(outside):
        raise FormatError(f"{name}: point {outside[0]} has intensity {scan[outside[0], 3]}; KITTI has 0 to 1")
