"""boxes.json: the boxes around the things of one scan, in the frame of the sensor."""

from __future__ import annotations

import dataclasses
import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lidardraft.errors import FormatError, one_of
from lidardraft.files import written_whole
from lidardraft.scene.layout import Box
from lidardraft.semantics import BY_NAME

_FIELDS = {field.name for field in dataclasses.fields(Box)} | {"num_points"}


def write_boxes(path: str | os.PathLike[str], boxes: Sequence[Box], num_points: Sequence[int]) -> None:
    """Write sensor-frame boxes, `size` as [length, width, height], each with the number of points on its thing."""
    if len(boxes) != len(num_points):
        raise FormatError(f"{os.fspath(path)}: {len(num_points)} point counts for {len(boxes)} boxes")
    rows = [{**dataclasses.asdict(box), "num_points": int(count)} for box, count in zip(boxes, num_points, strict=True)]
    for index, row in enumerate(rows):
        _check(f"{os.fspath(path)}: box {index}", row)
    text = ",\n  ".join(json.dumps(row) for row in rows)
    with written_whole(path) as temporary:
        temporary.write_text('{"frame": "sensor", "boxes": [\n  ' + text + "\n]}\n")


def read_boxes(path: str | os.PathLike[str]) -> tuple[list[Box], list[int]]:
    """The sensor-frame boxes and the number of points on each; raises `FormatError` naming the box and the field."""
    name = os.fspath(path)
    try:
        document = json.loads(Path(path).read_text())
    except OSError as error:
        raise FormatError(f"{name}: {error.strerror}") from None
    except ValueError as error:
        raise FormatError(f"{name} is not JSON: {error}") from None
    if not isinstance(document, dict) or not isinstance(document.get("boxes"), list):
        raise FormatError(f"{name}: 'boxes' must be a list")
    if document.get("frame") != "sensor":
        raise FormatError(f"{name}: frame is {document.get('frame')!r}; it must be 'sensor'")
    boxes, counts = [], []
    for index, row in enumerate(document["boxes"]):
        _check(f"{name}: box {index}", row)
        fields: dict[str, Any] = dict(row, center=tuple(row["center"]), size=tuple(row["size"]))
        counts.append(fields.pop("num_points"))
        boxes.append(Box(**fields))
    return boxes, counts


def _check(name: str, row: Any) -> None:
    if not isinstance(row, dict) or set(row) != _FIELDS:
        wrong = sorted(_FIELDS.symmetric_difference(row))[0] if isinstance(row, dict) else "every field"
        raise FormatError(f"{name}: {wrong!r} is missing or unknown")
    if row["label"] not in BY_NAME:
        raise FormatError(f"{name}: label is {row['label']!r}; it must be {one_of(BY_NAME, row['label'])}")
    for key in ("center", "size"):
        if not isinstance(row[key], list | tuple) or len(row[key]) != 3 or not all(map(_is_finite, row[key])):
            raise FormatError(f"{name}: {key} is {row[key]!r}; it must be 3 finite numbers")
    if min(row["size"]) < 0:
        raise FormatError(f"{name}: size is {list(row['size'])}; no extent may be negative")
    if not _is_finite(row["yaw"]):
        raise FormatError(f"{name}: yaw is {row['yaw']!r}; it must be a finite number of radians")
    for key in ("instance", "num_points"):
        if not isinstance(row[key], int) or row[key] < 0:
            raise FormatError(f"{name}: {key} is {row[key]!r}; it must be a whole number >= 0")


def _is_finite(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
