"""boxes.json: the boxes around the objects of one scan, in the frame of the sensor."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_text, write_text
from lidardraft.json_fields import check_fields, check_object, parse_object
from lidardraft.scene.box import Box

_MOST_BOXES = 65_535  # as many as there are instances
# Keys that reveal files of other tools.
_TOOLS = {"<tracklets": "KITTI tracklets", '"figures"': "Supervisely", '"centroid"': "labelCloud", '"psr"': "SUSTech"}
_OF_WEBDATASET = ("pose", "sensor", "provenance", "intent", "notes")
_OPTIONAL = ("velocity",)
_FIELDS = (*(field.name for field in dataclasses.fields(Box) if field.name not in _OPTIONAL), "num_points")


def write_boxes(path: str | os.PathLike[str], boxes: Sequence[Box], num_points: Sequence[int]) -> None:
    """Write sensor-frame boxes, `size` as [length, width, height], each with the number of points on its object."""
    if len(boxes) != len(num_points):
        raise FormatError(f"{os.fspath(path)}: {len(num_points)} point counts for {len(boxes)} boxes")
    for index, count in enumerate(num_points):
        with named(f"{os.fspath(path)}: box {index}"):
            _check_count(count)
    rows = [{**fields_of(box), "num_points": int(count)} for box, count in zip(boxes, num_points, strict=True)]
    text = ",\n  ".join(json.dumps(row) for row in rows)
    write_text(path, '{"frame": "sensor", "boxes": [\n  ' + text + "\n]}\n")


def read_boxes(path: str | os.PathLike[str]) -> tuple[list[Box], list[int]]:
    """The sensor-frame boxes and the number of points on each.

    Raises `FormatError` if the file is of another form, `LayoutError` for an invalid box; both name it.
    """
    text = read_text(path)
    boxes, counts = [], []
    with named(path):
        if '"boxes"' not in text and (mark := next((mark for mark in _TOOLS if mark in text), None)):
            how = "write its boxes in the sensor's frame, a line each of x y z length width height yaw class, as .txt"
            raise FormatError(f"a file of {_TOOLS[mark]}, which is not read; {how}")
        document = parse_object(text)
        check_fields(document, ("boxes",), ("frame", *_OF_WEBDATASET))
        if document.get("frame", "sensor") != "sensor":
            raise FormatError(f"frame is {document['frame']!r}; it must be 'sensor'")
        if not isinstance(document["boxes"], list):
            raise FormatError(f"boxes is {document['boxes']!r:.80}; it must be a list")
        if len(document["boxes"]) > _MOST_BOXES:
            raise FormatError(f"{len(document['boxes'])} boxes; up to {_MOST_BOXES} are read")
        for index, row in enumerate(document["boxes"]):
            with named(f"box {index}"):
                box, count = _box(check_object(row))
            boxes.append(box)
            counts.append(count)
    return boxes, counts


def fields_of(box: Box) -> dict[str, Any]:
    """A box as JSON types."""
    return {name: value for name, value in dataclasses.asdict(box).items() if value is not None}


def _box(row: dict[str, Any]) -> tuple[Box, int]:
    check_fields(row, _FIELDS, _OPTIONAL)
    count = row.pop("num_points")
    _check_count(count)
    return Box(**row), count


def _check_count(count: Any) -> None:
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 0:
        raise FormatError(f"num_points is {count!r}; it must be a whole number >= 0")
