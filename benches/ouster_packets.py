"""One revolution of an Ouster sensor from a capture of its packets (pcap) and its metadata (JSON).

Layouts after Ouster's sensor documentation: the packets of firmware 2.1 ("LEGACY") and those of low data rate
("RNG15_RFL8_NIR8"). Captures whose packets are whole UDP datagrams over Ethernet and IPv4 only.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.metrics.sweep import Sweep

_HEADERS = 14 + 20 + 8  # bytes of Ethernet, IPv4 and UDP
_COLUMNS = 16  # of a packet


def read_sweep(path: Path) -> Sweep:
    """The returns of the capture `path`; its metadata stand beside it as .json. Columns are firings, from behind."""
    meta = json.loads(path.with_suffix(".json").read_text())
    height, width = meta["data_format"]["pixels_per_column"], meta["data_format"]["columns_per_frame"]
    profile = meta["data_format"].get("udp_profile_lidar", "LEGACY")
    if profile not in ("LEGACY", "RNG15_RFL8_NIR8"):
        raise FormatError(f"{path.name}: packets are {profile}; only LEGACY and RNG15_RFL8_NIR8 are read")
    column = _legacy_column(height) if profile == "LEGACY" else _short_column(height)
    head = 0 if profile == "LEGACY" else 32
    size = head + _COLUMNS * column.itemsize + head
    depth, intensity = np.zeros((height, width)), np.zeros((height, width))
    for payload in _payloads(path.read_bytes()):
        if len(payload) != size:
            continue  # of the inertial unit
        columns = np.frombuffer(payload, dtype=column, count=_COLUMNS, offset=head)
        at = columns["number"] % width
        if profile == "LEGACY":
            depth[:, at] = (columns["pixels"]["range"] & 0xFFFFF).T * 1e-3
        else:
            depth[:, at] = (columns["pixels"]["range"] & 0x7FFF).T * 8e-3
        intensity[:, at] = np.minimum(columns["pixels"]["reflectivity"], 255).T / 255
    return Sweep(_points(depth, meta), None, np.where(depth > 0, intensity, 0.0).astype(np.float32))


def _payloads(capture: bytes) -> Iterator[bytes]:
    at = 24
    while at + 16 <= len(capture):
        (length,) = struct.unpack_from("<I", capture, at + 8)
        yield capture[at + 16 + _HEADERS : at + 16 + length]
        at += 16 + length


def _legacy_column(height: int) -> np.dtype:
    pixel = np.dtype([("range", "<u4"), ("reflectivity", "<u2"), ("signal", "<u2"), ("nir", "<u2"), ("unused", "<u2")])
    return np.dtype(
        [
            ("time", "<u8"),
            ("number", "<u2"),
            ("frame", "<u2"),
            ("encoder", "<u4"),
            ("pixels", pixel, height),
            ("status", "<u4"),
        ]
    )


def _short_column(height: int) -> np.dtype:
    pixel = np.dtype([("range", "<u2"), ("reflectivity", "u1"), ("nir", "u1")])
    return np.dtype([("time", "<u8"), ("number", "<u2"), ("status", "<u2"), ("pixels", pixel, height)])


def _points(depth: np.ndarray, meta: dict) -> np.ndarray:
    """Points in the sensor's frame turned so that the middle column looks ahead; beams leave the head's rim."""
    offset = meta.get("lidar_origin_to_beam_origin_mm", 0.0) * 1e-3
    altitude = np.deg2rad(np.array(meta["beam_altitude_angles"]))[:, None]
    head = np.pi - (np.arange(depth.shape[1]) + 0.5) / depth.shape[1] * 2 * np.pi
    azimuth = head - np.deg2rad(np.array(meta["beam_azimuth_angles"]))[:, None]
    along = np.maximum(depth - offset, 0.0)
    flat = along * np.cos(altitude)
    points = np.stack(
        [
            flat * np.cos(azimuth) + offset * np.cos(head),
            flat * np.sin(azimuth) + offset * np.sin(head),
            along * np.sin(altitude),
        ],
        axis=2,
    )
    return np.where(depth[..., None] > 0, points, 0.0).astype(np.float32)
