"""Ouster's sensor metadata: JSON with the beams of one unit, flat up to firmware 2 and in groups since."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from typing import Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_text
from lidardraft.json_fields import are_numbers, is_number, parse_object
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.sensor_model import MODELS

_MOST_COLUMNS = 4096  # as many as any of their modes has
_TABLES = ("beam_altitude_angles", "beam_azimuth_angles")


def is_ouster_metadata(text: str) -> bool:
    """Whether the text of a JSON file has beams as Ouster's metadata does."""
    return '"beam_altitude_angles"' in text


def read_ouster_metadata(path: str | os.PathLike[str]) -> Sensor:
    """The sensor of a metadata file: its own beams and mode, with the range and the model of its family (OS0, OS1 or
    OS2), 1.8 m over the road. Raises `FormatError` where the file is something else."""
    text = read_text(path)
    with named(path):
        document = parse_object(text)
        groups = [value for value in document.values() if isinstance(value, dict)]
        fields: dict[str, Any] = {name: value for group in (*groups, document) for name, value in group.items()}
        beams = fields.get(_TABLES[0])
        count = len(beams) if isinstance(beams, list) else 0
        if not count or not all(are_numbers(fields.get(table), count) for table in _TABLES):
            raise FormatError(f"{' and '.join(_TABLES)} must be lists of degrees, one for each beam")
        columns = fields.get("columns_per_frame")
        mode = re.fullmatch(r"(\d+)x(\d+)", str(fields.get("lidar_mode")))
        if type(columns) is not int or not 1 <= columns <= _MOST_COLUMNS or mode is None or int(mode[2]) < 1:
            raise FormatError("columns_per_frame and lidar_mode say no mode such as 1024x10")
        window: Any = fields.get("column_window", [0, columns - 1])
        if not are_numbers(window, 2) or not 0 <= window[0] <= window[1] < columns:
            raise FormatError(f"column_window is {window!r:.50}; it must be two of {columns} columns")
        forward = fields.get("lidar_origin_to_beam_origin_mm", 0.0)
        if not is_number(forward):
            raise FormatError(f"lidar_origin_to_beam_origin_mm is {forward!r:.50}; it must be a number")
        return _sensor(fields, (int(window[0]), int(window[1]), columns), float(forward), float(mode[2]))


def _sensor(fields: dict[str, Any], window: tuple[int, int, int], forward: float, rate: float) -> Sensor:
    product = str(fields.get("prod_line") or "OS1")
    family = re.match(r"OS-?([012])", product)
    preset = f"os{family[1] if family else 1}-128"
    elevations, azimuths = (np.deg2rad(np.array(fields[table], np.float64)) for table in _TABLES)
    order = np.argsort(-elevations, kind="stable")  # row 0 is the highest
    first, last, columns = window
    step = 2 * math.pi / columns
    return replace(
        PRESETS[preset],
        name=product.lower(),
        elevations=tuple(elevations[order].tolist()),
        azimuth_offsets=tuple((-azimuths[order]).tolist()),  # they count clockwise
        origin_forwards=(forward / 1000,) * len(order),
        columns=last - first + 1,
        azimuth_start=math.pi - (first - 0.5) * step,  # column w looks to pi - w * step, the middle of its pixel
        azimuth_span=(last - first + 1) * step,
        sweep_time=(last - first + 1) / columns / rate,
        model=MODELS[preset],
    )
