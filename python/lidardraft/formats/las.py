"""LAZ, the packed form of LAS 1.4: point format 6, with ring, label and instance as extra bytes.

Coordinates are whole millimetres. Classification is that of the ASPRS, with classes from 64 on, which it leaves to
users: 64 and our id.
"""

from __future__ import annotations

import os

import numpy as np

from lidardraft.errors import FormatError, extra
from lidardraft.files import expecting, named, new_folder, regular_size
from lidardraft.formats.frame import Drives, Frame, numbered
from lidardraft.semantics import BY_NAME, CLASSES

_ASPRS = {"none": 1, "terrain": 2, "vegetation": 5, "trunk": 5, "building": 6, "road": 11, "sidewalk": 11}
CLASSIFICATION = np.array([_ASPRS.get(row.name, 64 + row.id) for row in CLASSES], np.uint8)
_MILLIMETRE = 0.001
_MOST_POINTS = 2**22  # that are read; the largest sensors have half a million
_OURS_FROM = 64  # classifications; below it those of the ASPRS
_CLASS_OF_ASPRS = {
    **{1: "none", 2: "terrain", 3: "vegetation", 4: "vegetation", 5: "vegetation", 6: "building", 11: "road"},
    **{10: "road", 14: "pole", 15: "pole", 17: "road"},  # rail, wire, tower, bridge deck
}


def read_las(path: str | os.PathLike[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Points f64 [N, 3] of a .las or .laz file, and its intensity f32 [N] in 0 to 1, `label` u8 [N], and `ring` and
    `instance` where it has such fields.

    Raises `FormatError` where the file is broken or has more than 4,194,304 points, `MissingExtraError` where laspy is
    not installed."""
    with extra("export"):
        import laspy
    regular_size(path)
    with named(path), expecting("a whole LAS or LAZ file"), laspy.open(os.fspath(path)) as file:
        if file.header.point_count > _MOST_POINTS:
            raise FormatError(f"{file.header.point_count} points; scans of up to {_MOST_POINTS} are read")
        points = file.read()
        names = set(points.point_format.dimension_names)
        label = np.array([BY_NAME[_CLASS_OF_ASPRS.get(k, "none")].id for k in range(256)], np.uint8)
        label[_OURS_FROM : _OURS_FROM + len(CLASSES)] = range(len(CLASSES))
        fields = {name: np.array(points[name]) for name in ("ring", "label", "instance") if name in names}
        if not {"ring", "label", "instance"} <= names:  # classes of others' extra bytes are not ours
            fields |= {"label": label[np.array(points.classification)]}
        intensity = np.array(points.intensity, np.float32)
        fields["intensity"] = intensity / np.float32(65535 if intensity.max(initial=0) > 255 else 255)
        return np.array(points.xyz), fields


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
