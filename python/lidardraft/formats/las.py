"""LAS 1.4: point format 6, with ring, label and instance as extra bytes.

Coordinates are whole millimetres. Classification is that of the ASPRS; its classes from 64 on are for users, and hold
64 plus the class id. Packed files (LAZ) are refused: a damaged one may claim any time and memory to unpack.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from lidardraft.errors import FormatError, extra
from lidardraft.files import expecting, named, regular_size
from lidardraft.formats.frame import Drives, Frame, numbered
from lidardraft.formats.point_fields import named_fields
from lidardraft.semantics import BY_NAME, CLASSES

_ASPRS = {"none": 1, "terrain": 2, "vegetation": 5, "trunk": 5, "building": 6, "road": 11, "sidewalk": 11}
CLASSIFICATION = np.array([_ASPRS.get(row.name, 64 + row.id) for row in CLASSES], np.uint8)
_MILLIMETRE = 0.001
_MOST_POINTS = 2**22  # of a file; the largest sensors have half a million
_RECORDS_AT, _RECORD = (
    100,
    54,
)  # where a header counts its variable length records; the least bytes of one
_OURS_FROM = 64  # the first classification with a class id; those below are of the ASPRS
_CLASS_OF_ASPRS = {
    **{1: "none", 2: "terrain", 3: "vegetation", 4: "vegetation", 5: "vegetation", 6: "building", 11: "road"},
    **{10: "road", 14: "pole", 15: "pole", 17: "road"},  # rail, wire, tower, bridge deck
}


def read_las(path: str | os.PathLike[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Points f64 [N, 3] of a .las file, and its intensity u16 [N], `label` u8 [N], and `ring` and `instance` if it has
    such fields.

    Raises `FormatError` if the file is broken, packed or has more than 4,194,304 points, `MissingExtraError` if laspy
    is not installed."""
    with extra():
        import laspy
    size = regular_size(path)
    with named(path), expecting("a whole LAS file"), Path(path).open("rb") as stream:
        records = int.from_bytes(stream.read(_RECORDS_AT + 4)[_RECORDS_AT:], "little")
        if records * _RECORD > size:  # laspy would read past the end of the file
            raise FormatError(f"{records} records in {size} bytes")
        stream.seek(0)
        file = laspy.open(stream, closefd=False, read_evlrs=False)
        if file.header.are_points_compressed:
            raise FormatError("it is packed (LAZ); unpack it first, for example with `laszip` or `pdal translate`")
        if file.header.point_count > _MOST_POINTS:
            raise FormatError(f"{file.header.point_count} points; scans of up to {_MOST_POINTS} are read")
        points = file.read()
        names = set(points.point_format.dimension_names)
        label = np.array([BY_NAME[_CLASS_OF_ASPRS.get(k, "none")].id for k in range(256)], np.uint8)
        label[_OURS_FROM : _OURS_FROM + len(CLASSES)] = range(len(CLASSES))
        fields = {name: np.array(points[name]) for name in ("label", "instance") if name in names}
        if ring := named_fields(list(names)).get("ring"):
            fields["ring"] = np.array(points[ring])
        if not {"ring", "label", "instance"} <= names:  # extra bytes of other tools hold other classes
            fields |= {"label": label[np.array(points.classification)]}
        fields["intensity"] = np.array(points.intensity)
        return np.array(points.xyz), fields


def write_las(folder: Path, drives: Drives, first: int) -> None:
    """Write a .las file for each frame. Raises `MissingExtraError` if laspy is not installed."""
    with extra():
        import laspy
    for name, frame in numbered(drives, first):
        header = laspy.LasHeader(point_format=6, version="1.4")
        header.scales = np.full(3, _MILLIMETRE)
        header.add_extra_dims([laspy.ExtraBytesParams(field, kind) for field, kind in _EXTRA.items()])
        points = laspy.LasData(header)
        for field, values in _columns(frame).items():
            points[field] = values
        with (folder / f"{name}.las").open("wb") as file:
            points.write(file)


_EXTRA = {"ring": "u2", "label": "u1", "instance": "u4"}


def _columns(frame: Frame) -> dict[str, np.ndarray]:
    return {
        **dict(zip("xyz", frame.points.T.astype(np.float64), strict=True)),
        "intensity": np.round(frame.intensity * 65535).astype(np.uint16),
        "classification": CLASSIFICATION[frame.label],
        "return_number": np.ones(len(frame.points), np.uint8),
        "number_of_returns": np.ones(len(frame.points), np.uint8),
        **{{"time": "gps_time"}.get(field, field): values for field, values in frame.fields().items()},
    }
