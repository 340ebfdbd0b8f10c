"""LAZ, the packed form of LAS 1.4: point format 6, with ring, label and instance as extra bytes.

Coordinates are whole millimetres. Classification is that of the ASPRS, with classes from 64 on, which it leaves to
users: 64 and our id.
"""

from __future__ import annotations

import os

import numpy as np

from lidardraft.errors import extra
from lidardraft.files import new_folder
from lidardraft.formats.frame import Drives, Frame, numbered
from lidardraft.semantics import CLASSES

_ASPRS = {"none": 1, "terrain": 2, "vegetation": 5, "trunk": 5, "building": 6, "road": 11, "sidewalk": 11}
CLASSIFICATION = np.array([_ASPRS.get(row.name, 64 + row.id) for row in CLASSES], np.uint8)
_MILLIMETRE = 0.001


def write_laz(output: str | os.PathLike[str], drives: Drives) -> None:
    """Write a .laz file for each frame. Raises `FormatError` where `output` is there already or cannot be written,
    `MissingExtraError` where laspy is not installed."""
    with extra("export"):
        import laspy
    with new_folder(output) as folder:
        for name, frame in numbered(drives):
            header = laspy.LasHeader(point_format=6, version="1.4")
            header.scales = np.full(3, _MILLIMETRE)
            header.add_extra_dims([laspy.ExtraBytesParams(field, kind) for field, kind in _EXTRA.items()])
            points = laspy.LasData(header)
            for field, values in _columns(frame).items():
                points[field] = values
            with (folder / f"{name}.laz").open("wb") as file:
                points.write(file, do_compress=True)


_EXTRA = {"ring": "u2", "label": "u1", "instance": "u4"}


def _columns(frame: Frame) -> dict[str, np.ndarray]:
    return {
        **dict(zip("xyz", frame.points.T.astype(np.float64), strict=True)),
        "intensity": np.round(frame.intensity * 65535).astype(np.uint16),
        "classification": CLASSIFICATION[frame.label],
        "gps_time": frame.time.astype(np.float64),
        "return_number": np.ones(len(frame.points), np.uint8),
        "number_of_returns": np.ones(len(frame.points), np.uint8),
        **{field: getattr(frame, field) for field in _EXTRA},
    }
