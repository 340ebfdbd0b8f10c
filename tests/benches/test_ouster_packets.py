"""Captures of Ouster packets, written by hand."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from lidardraft.errors import FormatError
from ouster_packets import read_sweep

RANGES = np.arange(64).reshape(2, 32) * 1000  # mm


def capture(folder: Path, payloads: list[bytes], profile: str | None) -> Path:
    data = b"\0" * 24
    for payload in payloads:
        data += struct.pack("<IIII", 0, 0, 42 + len(payload), 42 + len(payload)) + b"\0" * 42 + payload
    path = folder / "capture.pcap"
    path.write_bytes(data)
    layout = {"pixels_per_column": 2, "columns_per_frame": 32}
    meta = {"data_format": layout, "beam_altitude_angles": [10.0, -10.0], "beam_azimuth_angles": [0.0, 0.0]}
    if profile:
        layout["udp_profile_lidar"] = profile
    path.with_suffix(".json").write_text(json.dumps(meta))
    return path


def legacy(first: int) -> bytes:
    columns = b""
    for number in range(first, first + 16):
        pixels = b"".join(struct.pack("<IHHHH", RANGES[row, number] | 0xA << 28, 40 * row, 9, 9, 9) for row in (0, 1))
        columns += struct.pack("<QHHI", 0, number, 0, 0) + pixels + struct.pack("<I", 0xFFFFFFFF)
    return columns


def short(first: int) -> bytes:
    columns = b""
    for number in range(first, first + 16):
        pixels = b"".join(struct.pack("<HBB", RANGES[row, number] // 8 | 0x8000, 40 * row, 9) for row in (0, 1))
        columns += struct.pack("<QHH", 0, number, 1) + pixels
    return b"\1" * 32 + columns + b"\2" * 32


@pytest.mark.parametrize(("packet", "profile"), [(legacy, None), (short, "RNG15_RFL8_NIR8")])
def test_a_revolution(packet, profile: str | None, tmp_path: Path) -> None:
    sweep = read_sweep(capture(tmp_path, [packet(16), b"\0" * 48, packet(0)], profile))
    np.testing.assert_allclose(sweep.depth, RANGES / 1000, rtol=1e-5)
    assert sweep.intensity is not None
    np.testing.assert_allclose(sweep.intensity[1], np.full(32, 40 / 255), rtol=1e-5)
    ahead = sweep.points[1, 15:17].mean(axis=0)
    assert ahead[0] == pytest.approx(RANGES[1, 15:17].mean() / 1000 * np.cos(np.deg2rad(10)), rel=0.01)
    assert ahead[2] < 0
    assert sweep.points[1, 8, 1] > 0 > sweep.points[1, 24, 1]  # from left to right


def test_other_packets_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="packets are RNG19_RFL8_SIG16_NIR16"):
        read_sweep(capture(tmp_path, [], "RNG19_RFL8_SIG16_NIR16"))
