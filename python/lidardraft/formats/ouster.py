"""Ouster's sensors and scans. Metadata is JSON with the beams of one unit, flat up to firmware 2 and in groups since;
packet captures (.pcap) have it beside them. .osf files are read by Ouster's SDK."""

from __future__ import annotations

import itertools
import math
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, extra
from lidardraft.files import expecting, named, read_text, regular_size
from lidardraft.formats.ouster_packets import Packets
from lidardraft.json_fields import are_numbers, is_number, parse_object
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.sensor_model import MODELS

_MOST_COLUMNS = 4096  # the most of any of their modes
_TABLES = ("beam_altitude_angles", "beam_azimuth_angles")
_LARGEST = 2**44  # bytes of a log; only a frame of it is read
_NO_MODE = "columns_per_frame and lidar_mode name no mode such as 1024x10"


def is_ouster_metadata(text: str) -> bool:
    """Whether the text of a JSON file has Ouster's table of beams."""
    return '"beam_altitude_angles"' in text


def read_ouster_metadata(path: str | os.PathLike[str]) -> Sensor:
    """The sensor of a metadata file: its own beams and mode, with the range and the model of its family (OS0, OS1 or
    OS2), 1.8 m over the road. Raises `FormatError` if the file is something else."""
    text = read_text(path)
    with named(path):
        return sensor_of_metadata(text)


def sensor_of_metadata(text: str) -> Sensor:
    """As `read_ouster_metadata`, from its text."""
    fields = _fields(text)
    columns = fields["columns_per_frame"]
    mode = re.fullmatch(r"(\d+)x(\d+)", str(fields.get("lidar_mode")))
    if mode is None or int(mode[2]) < 1:
        raise FormatError(_NO_MODE)
    window: Any = fields.get("column_window", [0, columns - 1])
    if not are_numbers(window, 2) or not all(0 <= number < columns for number in window):
        raise FormatError(f"column_window is {window!r:.50}; it must be two of {columns} columns")
    forward = fields.get("lidar_origin_to_beam_origin_mm", 0.0)
    if not is_number(forward):
        raise FormatError(f"lidar_origin_to_beam_origin_mm is {forward!r:.50}; it must be a number")
    return _sensor(fields, (int(window[0]), int(window[1]), columns), float(forward), float(mode[2]))


def _fields(text: str) -> dict[str, Any]:
    """All fields of metadata, without their groups; the tables and the number of columns are checked."""
    document = parse_object(text)
    groups = [value for value in document.values() if isinstance(value, dict)]
    fields: dict[str, Any] = {name: value for group in (*groups, document) for name, value in group.items()}
    beams = fields.get(_TABLES[0])
    count = len(beams) if isinstance(beams, list) else 0
    if not count or not all(are_numbers(fields.get(table), count) for table in _TABLES):
        raise FormatError(f"{' and '.join(_TABLES)} must be lists of degrees, one for each beam")
    columns = fields.get("columns_per_frame")
    if type(columns) is not int or not 1 <= columns <= _MOST_COLUMNS:
        raise FormatError(_NO_MODE)
    return fields


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
        azimuth_offsets=tuple((-azimuths[order]).tolist()),  # Ouster counts clockwise
        origin_forwards=(forward / 1000,) * len(order),
        columns=count,
        azimuth_start=math.pi - (first - 0.5) * step,  # column w is at pi - w * step, the middle of its pixel
        azimuth_span=count * step,
        sweep_time=count / columns / rate,
        model=MODELS[preset],
    )


def read_ouster_capture(path: str | os.PathLike[str], frame: int = 0) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The returns f32 [N, 3] [m] of a whole frame, numbered among those, row by row. Each has `ring` and `column` i64
    [N], its pixel in an image of `read_ouster_metadata`, and `intensity` [N], its reflectivity, 0 to 255. Of two
    returns of a firing, the first counts.

    Raises `FormatError` if the capture has no such frame of the sensor of `metadata_beside`."""
    (sensor, fields), packets, wanted = _packets(path)
    with named(path):
        whole, most = -1, 0
        for ranges, reflectivity, measured in packets.frames(path):
            most = max(most, int(np.count_nonzero(measured)))
            whole += bool(measured[wanted].all())
            if whole == frame and measured[wanted].all():
                return _returns(sensor, fields, ranges[:, wanted], reflectivity[:, wanted])
        raise FormatError(_missing(frame, whole + 1, most, metadata_beside(path)))


def _packets(path: str | os.PathLike[str]) -> tuple[tuple[Sensor, dict[str, Any]], Packets, np.ndarray]:
    """The sensor of a capture with its fields, its packets, and the columns that it measures."""
    regular_size(path, _LARGEST)
    metadata = metadata_beside(path)
    sensor, text = read_ouster_metadata(metadata), read_text(metadata)
    with named(metadata):
        fields = _fields(text)
        profile, packed = fields.get("udp_profile_lidar", "LEGACY"), fields.get("columns_per_packet", 16)
        if type(packed) is not int or not 1 <= packed <= _MOST_COLUMNS:
            raise FormatError(f"columns_per_packet is {packed!r:.50}; it must be a number of columns")
        packets = Packets(len(sensor.elevations), fields["columns_per_frame"], packed, str(profile))
    return (sensor, fields), packets, _columns(fields, sensor)


def count_frames(path: str | os.PathLike[str]) -> int:
    """The number of whole frames of a capture, or of frames of an .osf file."""
    if Path(path).suffix == ".osf":
        with _opened(path) as (source, _):
            return sum(1 for group in source if group[0] is not None)
    _, packets, wanted = _packets(path)
    with named(path):
        return sum(bool(measured[wanted].all()) for *_, measured in packets.frames(path))


def _columns(fields: dict[str, Any], sensor: Sensor) -> np.ndarray:
    """The columns of a turn that the sensor measures, in the order of its image."""
    first = fields.get("column_window", [0])[0]
    return (int(first) + np.arange(sensor.columns)) % int(fields["columns_per_frame"])


def _returns(
    sensor: Sensor, fields: dict[str, Any], ranges: np.ndarray, reflectivity: np.ndarray
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The returns of images [H, W] with rows in the order of the tables. Ranges are millimetres from the sensor's axis
    along the beam, which leaves at the head's rim."""
    order = np.argsort(-np.array(fields[_TABLES[0]], np.float64), kind="stable")  # row 0 is the highest
    ranges, reflectivity = ranges[order], reflectivity[order]
    ring, column = np.nonzero(ranges)
    forward = float(fields.get("lidar_origin_to_beam_origin_mm", 0.0)) / 1000
    along = ranges[ring, column] / 1000 - forward
    step = sensor.azimuth_span / sensor.columns
    head = sensor.azimuth_start - (column + 0.5) * step
    azimuth = head + np.array(sensor.azimuth_offsets)[ring]
    elevation = np.array(sensor.elevations)[ring]
    flat = along * np.cos(elevation)
    x = flat * np.cos(azimuth) + forward * np.cos(head)
    y = flat * np.sin(azimuth) + forward * np.sin(head)
    points = np.stack([x, y, along * np.sin(elevation)], axis=1).astype(np.float32)
    return points, {"ring": ring, "column": column, "intensity": np.minimum(reflectivity[ring, column], 255)}


def _missing(frame: int, whole: int, most: int, metadata: Path) -> str:
    """The message for a capture without a frame of that number."""
    if whole:
        return f"there is no whole frame {frame}; it has {whole}, from 0 on"
    if most:
        return f"no frame is whole: the fullest has {most} columns; record a full turn, or it was cut"
    return f"it has no packet of the sensor of {metadata.name}"


def osf_frame(path: str | os.PathLike[str], frame: int = 0) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """As `read_ouster_capture`, from a frame of an Ouster .osf file; of several sensors, the first.

    Raises `FormatError` if it has no such frame, `MissingExtraError` if ouster-sdk, which reads it, is not installed.
    """
    with _opened(path) as (source, text):
        sensor, fields = sensor_of_metadata(text), _fields(text)
        scans = (found for group in source if (found := group[0]) is not None)
        found = next(itertools.islice(scans, frame, None), None)
        if found is None:
            raise FormatError(f"there is no frame {frame}")
        wanted = _columns(fields, sensor)
        images = (np.asarray(found.field(name))[:, wanted] for name in ("RANGE", "REFLECTIVITY"))
        return _returns(sensor, fields, *(image.astype(np.int64) for image in images))


def sensor_of_osf(path: str | os.PathLike[str]) -> Sensor:
    """The sensor of an .osf file, the first of several; raises as `osf_frame`."""
    with _opened(path) as (_, text):
        return sensor_of_metadata(text)


@contextmanager
def _opened(path: str | os.PathLike[str]) -> Iterator[tuple[Any, str]]:
    """The frames of an .osf file, as Ouster's SDK reads them, and the metadata of its first sensor."""
    regular_size(path, _LARGEST)
    with extra():
        from ouster.sdk import open_source
    with named(path), expecting("an .osf file that Ouster's SDK reads"):
        source = open_source(os.fspath(path))
        try:
            yield source, source.sensor_info[0].to_json_string()
        finally:
            source.close()


def metadata_beside(path: str | os.PathLike[str]) -> Path:
    """The metadata of a capture: NAME.json beside NAME.pcap, else the only metadata of an Ouster in its folder. Raises
    `FormatError` if there is neither."""
    same = Path(path).with_suffix(".json")
    if same.exists():
        return same
    others = (file for file in sorted(same.parent.glob("*.json")) if file.is_file())
    found = [file for file in others if is_ouster_metadata(read_text(file))]
    if len(found) != 1:
        none = f"{len(found)} others of Ousters are" if found else "no other of an Ouster is"
        raise FormatError(f"{os.fspath(path)}: its metadata {same.name} is not beside it, and {none} in its folder")
    return found[0]
