"""Ouster's packet captures (.pcap), read by its SDK; the metadata of the sensor lies beside them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, extra
from lidardraft.files import expecting, named, read_text, regular_size
from lidardraft.formats.ouster import is_ouster_metadata, read_ouster_metadata

_BRIGHTEST = 255  # of reflectivities; 100 and less is diffuse, more is retroreflective (firmware user manual)
_VALID = 1  # the bit of a column's status: it was measured


def read_ouster_capture(path: str | os.PathLike[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The returns f32 [N, 3] of the first whole frame [m], row by row, and of each `ring` and `column` i64 [N], where
    it lies in an image of `read_ouster_metadata`, and `intensity` f32 [N], its reflectivity in 0 to 1. Of two returns
    of a firing, the first.

    Raises `FormatError` where the capture has no whole frame of the sensor of `metadata_beside`, `MissingExtraError`
    where ouster-sdk is not installed."""
    regular_size(path)
    metadata = metadata_beside(path)
    sensor = read_ouster_metadata(metadata)  # it says clearly what is wrong with one, where the SDK does not
    with extra("ouster"):
        from ouster.sdk.core import SensorInfo, XYZLut
    text = read_text(metadata)
    with named(metadata), expecting("metadata that Ouster's SDK reads"):
        info = SensorInfo(text)
        points_of = XYZLut(info)
        first = info.format.column_window[0]
        lifted = info.lidar_to_sensor_transform[:3, 3] / 1000  # SDK's origin is the foot of the sensor, ours its optics
    with named(path):
        frame = _first_whole_frame(path, metadata)
        with expecting("a capture of Ouster packets"):
            order = np.argsort(-np.asarray(info.beam_altitude_angles), kind="stable")  # row 0 is the highest
            window = slice(first, first + sensor.columns)
            ranges, reflectivity = (frame.field(name)[order, window] for name in ("RANGE", "REFLECTIVITY"))
            points = (points_of(frame)[order, window] - lifted).astype(np.float32)
    ring, column = np.nonzero(ranges)
    intensity = np.minimum(reflectivity[ring, column], _BRIGHTEST).astype(np.float32) / np.float32(_BRIGHTEST)
    return points[ring, column], {"ring": ring, "column": column, "intensity": intensity}


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
