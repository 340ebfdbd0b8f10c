"""Packet captures of a small Ouster, written by its SDK."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

COLUMNS, BEAMS = 512, 16
METADATA = {
    "prod_line": "OS-1-16",
    "prod_sn": "1",
    "lidar_mode": "512x10",
    "beam_altitude_angles": np.linspace(-15, 15, BEAMS).tolist(),  # from the lowest: the rows of ours are turned over
    "beam_azimuth_angles": [3.0, 1.0, -1.0, -3.0] * (BEAMS // 4),
    "lidar_origin_to_beam_origin_mm": 15.8,
    "lidar_to_sensor_transform": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1],
    "data_format": {
        "columns_per_frame": COLUMNS,
        "columns_per_packet": 16,
        "pixels_per_column": BEAMS,
        "column_window": [0, COLUMNS - 1],
        "pixel_shift_by_row": [0] * BEAMS,
        "udp_profile_lidar": "RNG19_RFL8_SIG16_NIR16",
    },
}


def write_capture(
    path: Path, millimetres: list[np.ndarray], reflectivity: int = 51, window: tuple[int, int] = (0, COLUMNS - 1)
) -> None:
    """A capture of frames of ranges u32 [BEAMS, COLUMNS], the lowest beam first, and the metadata beside it; the sensor
    measures the columns of a `window`."""
    from ouster.sdk.core import LidarFrame, PacketFormat, SensorInfo, frame_to_packets
    from ouster.sdk.pcap import record

    text = json.dumps(METADATA | {"data_format": METADATA["data_format"] | {"column_window": list(window)}})
    path.with_suffix(".json").write_text(text)
    info = SensorInfo(text)
    packets = []
    for number, ranges in enumerate(millimetres):
        frame = LidarFrame(info)
        frame.frame_id = number + 1
        frame.field("RANGE")[:] = ranges
        frame.field("REFLECTIVITY")[:] = reflectivity
        turned = (np.arange(COLUMNS) - window[0]) % COLUMNS
        frame.status[:] = turned <= (window[1] - window[0]) % COLUMNS
        frame.measurement_id[:] = np.arange(COLUMNS)
        frame.timestamp[:] = 1 + np.arange(COLUMNS) + number * COLUMNS
        packets += frame_to_packets(frame, PacketFormat(info), 0, 1)
    record(packets, str(path))
