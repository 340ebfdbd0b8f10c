"""Ouster's sensors and scans: metadata, JSON with the beams of one unit, flat up to firmware 2 and in groups since, and
packet captures (.pcap) beside them, which its SDK reads."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, extra
from lidardraft.files import expecting, named, read_text, regular_size
from lidardraft.json_fields import are_numbers, is_number, parse_object
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.sensor_model import MODELS

_MOST_COLUMNS = 4096  # as many as any of their modes has
_TABLES = ("beam_altitude_angles", "beam_azimuth_angles")
_VALID = 1  # the bit of a column's status: it was measured


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
        if not are_numbers(window, 2) or not all(0 <= number < columns for number in window):
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
    count = (last - first) % columns + 1  # the window may go over the seam, as from column 900 to 100
    return replace(
        PRESETS[preset],
        name=product.lower(),
        elevations=tuple(elevations[order].tolist()),
        azimuth_offsets=tuple((-azimuths[order]).tolist()),  # they count clockwise
        origin_forwards=(forward / 1000,) * len(order),
        columns=count,
        azimuth_start=math.pi - (first - 0.5) * step,  # column w looks to pi - w * step, the middle of its pixel
        azimuth_span=count * step,
        sweep_time=count / columns / rate,
        model=MODELS[preset],
    )


def read_ouster_capture(path: str | os.PathLike[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The returns f32 [N, 3] of the first whole frame [m], row by row, and of each `ring` and `column` i64 [N], where
    it lies in an image of `read_ouster_metadata`, and `intensity` [N], its reflectivity, 0 to 255. Of two returns of a
    firing, the first.

    Raises `FormatError` where the capture has no whole frame of the sensor of `metadata_beside`, `MissingExtraError`
    where ouster-sdk is not installed."""
    regular_size(path)
    metadata = metadata_beside(path)
    sensor = read_ouster_metadata(metadata)  # it says clearly what is wrong with one, where the SDK does not
    with extra():
        from ouster.sdk.core import SensorInfo, XYZLut
    text = read_text(metadata)
    with named(metadata), expecting("metadata that Ouster's SDK reads"):
        info = SensorInfo(text)
        points_of = XYZLut(info)
        first, turn = info.format.column_window[0], info.format.columns_per_frame
        lifted = info.lidar_to_sensor_transform[:3, 3] / 1000  # SDK's origin is the foot of the sensor, ours its optics
    with named(path):
        frame = _first_whole_frame(path, metadata)
        with expecting("a capture of Ouster packets"):
            order = np.argsort(-np.asarray(info.beam_altitude_angles), kind="stable")  # row 0 is the highest
            window = (first + np.arange(sensor.columns)) % turn
            ranges, reflectivity = (frame.field(name)[order][:, window] for name in ("RANGE", "REFLECTIVITY"))
            points = (points_of(frame)[order][:, window] - lifted).astype(np.float32)
    ring, column = np.nonzero(ranges)
    return points[ring, column], {"ring": ring, "column": column, "intensity": reflectivity[ring, column]}


def metadata_beside(path: str | os.PathLike[str]) -> Path:
    """The metadata of a capture: NAME.json beside NAME.pcap, else the only metadata of an Ouster in its folder. Raises
    `FormatError` where neither is there."""
    same = Path(path).with_suffix(".json")
    if same.exists():
        return same
    others = (file for file in sorted(same.parent.glob("*.json")) if file.is_file())
    found = [file for file in others if is_ouster_metadata(read_text(file))]
    if len(found) != 1:
        none = f"{len(found)} others of Ousters are" if found else "no other of an Ouster is"
        raise FormatError(f"{os.fspath(path)}: its metadata {same.name} is not beside it, and {none} in its folder")
    return found[0]


def _first_whole_frame(path: str | os.PathLike[str], metadata: Path) -> Any:
    from ouster.sdk.pcap import PcapFrameSetSource

    most = 0
    with expecting("a capture of Ouster packets"):
        source = PcapFrameSetSource(os.fspath(path), meta=[os.fspath(metadata)], index=False)
        try:
            for (frame,) in source:
                if frame.complete():
                    return frame
                most = max(most, int(np.count_nonzero(frame.status & _VALID)))
        finally:
            source.close()
    if most:
        raise FormatError(f"no frame is whole: the fullest has {most} columns; record a full turn, or it was cut")
    raise FormatError(f"it has no packet of the sensor of {metadata.name}")
