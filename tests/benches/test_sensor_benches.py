"""Fits of sensors give back what made the data; captures of Ouster packets, written by hand."""

import json
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fit_sensor import fit_noise, fit_roughness, report_edges
from foliage_steps import steps
from lidardraft import Layout, Primitive, raycast
from lidardraft.calibration.street_casts import StreetCasts
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.materials import Material, diffuse_response
from lidardraft.scene.sensor import PRESETS
from lidardraft.scene.sensor_model import MODELS
from ouster_packets import read_sweep


def test_roughness_and_scale_come_back():
    rng = np.random.default_rng(0)
    cosine = rng.uniform(0.03, 1.0, 20_000)
    shape = diffuse_response(Material("", 1.0, roughness=0.6), cosine)
    facing, roughness = fit_roughness(cosine, 30.0 * shape * np.exp(rng.normal(0, 0.1, len(cosine))))
    assert facing == pytest.approx(30.0, rel=0.03)
    assert roughness == pytest.approx(0.6, abs=0.1)


def test_the_two_parts_of_noise_come_back():
    rng = np.random.default_rng(2)
    power = np.exp(rng.uniform(np.log(11), np.log(90_000), 60_000))
    sigma = np.sqrt(0.01**2 + 0.1**2 / power)
    noise = sigma * np.abs(rng.standard_normal(len(power)))
    floor, jitter, rows = fit_noise(power, noise)
    assert floor == pytest.approx(0.01, rel=0.1)
    assert jitter == pytest.approx(0.1, rel=0.1)
    assert len(rows) == 6


def test_what_edges_lose_comes_back(capsys):
    sensor, model = PRESETS["vlp16"], MODELS["vlp16"]
    casts = StreetCasts.from_sensor(sensor, model, 16, seed=6)
    report_edges({"a place": casts.observed(replace(model, edge_drop=0.4), sensor.range_sigma)}, sensor, model)
    (row,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("| a place"))
    assert float(row.split("|")[3]) == pytest.approx(0.4, rel=0.3)


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


RANGES = np.arange(64).reshape(2, 32) * 1000  # mm


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


def test_steps_in_a_hedge_grow_with_how_far_apart_rays_are():
    hedge = Primitive(shape="box", center=(10, 0, 1), size=(2, 30, 6), label="vegetation", id="hedge", extinction=2.0)
    scans = [Sweep.by_azimuth(raycast(Layout([hedge]), PRESETS["pandar64"], seed=seed)) for seed in range(4)]
    median = [float(np.median(found)) for found in steps(scans) if len(found) > 1000]
    assert len(median) >= 4
    assert median == sorted(median)
    assert median[-1] > 2 * median[0]
