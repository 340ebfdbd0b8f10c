"""Packet captures of a small Ouster, laid out as its sensor documentation says."""

from __future__ import annotations

import json
import struct
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
    path: Path,
    millimetres: list[np.ndarray],
    reflectivity: int = 51,
    window: tuple[int, int] = (0, COLUMNS - 1),
    largest: int = 2**16,
) -> None:
    """A capture of frames of ranges u32 [BEAMS, COLUMNS], the lowest beam first, and the metadata beside it; the sensor
    measures the columns of a `window`. Datagrams come in fragments of the `largest` size."""
    text = json.dumps(METADATA | {"data_format": METADATA["data_format"] | {"column_window": list(window)}})
    path.with_suffix(".json").write_text(text)
    pixel = np.dtype({"names": ["range", "reflectivity"], "formats": ["<u4", "u1"], "offsets": [0, 4], "itemsize": 12})
    column = np.dtype([("time", "<u8"), ("number", "<u2"), ("status", "<u2"), ("pixels", pixel, BEAMS)])
    packets = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 2**18, 1)]
    for number, ranges in enumerate(millimetres, 1):
        columns = np.zeros(COLUMNS, column)
        columns["number"] = np.arange(COLUMNS)
        columns["status"] = (columns["number"] - window[0]) % COLUMNS <= (window[1] - window[0]) % COLUMNS
        columns["pixels"]["range"], columns["pixels"]["reflectivity"] = ranges.T, reflectivity
        for first in range(0, COLUMNS, 16):
            payload = struct.pack("<HH28x", 1, number) + columns[first : first + 16].tobytes() + bytes(32)
            datagram = struct.pack(">HHHH", 7502, 7502, 8 + len(payload), 0) + payload
            parts = range(0, len(datagram), largest)
            packets += [_ethernet(datagram, start, largest, number * COLUMNS + first) for start in parts]
    path.write_bytes(b"".join(packets))


def _ethernet(datagram: bytes, start: int, largest: int, number: int) -> bytes:
    part = datagram[start : start + largest]
    cut = (0x2000 if start + largest < len(datagram) else 0) | start // 8
    head = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(part), number, cut, 64, 17, 0, b"\1\1\1\1", b"\2\2\2\2")
    packet = bytes(12) + b"\x08\x00" + head + part
    return struct.pack("<IIII", 0, 0, len(packet), len(packet)) + packet
