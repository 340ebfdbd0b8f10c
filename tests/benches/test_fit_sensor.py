"""The fits give back what made the data."""

import numpy as np
import pytest

from fit_sensor import COLUMNS, LONGEST, fit_noise, fit_roughness, holes, images, planes, read_pcd
from lidardraft.scene.materials import Material, diffuse_response


def test_roughness_and_scale_come_back():
    rng = np.random.default_rng(0)
    cosine = rng.uniform(0.03, 1.0, 20_000)
    shape = diffuse_response(Material("", 1.0, roughness=0.6), cosine)
    facing, roughness = fit_roughness(cosine, 30.0 * shape * np.exp(rng.normal(0, 0.1, len(cosine))))
    assert facing == pytest.approx(30.0, rel=0.03)
    assert roughness == pytest.approx(0.6, abs=0.1)


def test_noise_of_planes_comes_back():
    rng = np.random.default_rng(1)
    across, up = rng.uniform(-4, 4, (2, 30_000))
    # a wall 10 m ahead, seen along rays; noise along the rays
    points = np.stack([np.full_like(across, 10.0), across, up], axis=1)
    distance = np.linalg.norm(points, axis=1)
    power = np.exp(rng.uniform(np.log(15), np.log(50_000), 1))[0] * np.ones(len(points))
    sigma = np.sqrt(0.01**2 + 0.1**2 / power)
    near, cosine, noise = planes(points * (1 + sigma * rng.standard_normal(len(points)) / distance)[:, None], 5)
    assert near.shape[1] == 20
    assert np.sqrt(np.square(noise).mean()) == pytest.approx(sigma[0], rel=0.1)
    np.testing.assert_allclose(cosine, 10.0 / distance[near[:, 0]], atol=0.1)


def test_the_two_parts_of_noise_come_back():
    rng = np.random.default_rng(2)
    power = np.exp(rng.uniform(np.log(11), np.log(90_000), 60_000))
    sigma = np.sqrt(0.01**2 + 0.1**2 / power)
    noise = sigma * np.sqrt(rng.chisquare(17, len(power)) / 17)
    floor, jitter, rows = fit_noise(power, noise)
    assert floor == pytest.approx(0.01, rel=0.1)
    assert jitter == pytest.approx(0.1, rel=0.1)
    assert len(rows) == 6


def test_holes_in_the_ground_are_counted_and_gaps_between_things_are_not():
    ranges, ground = np.full((2, 64), 20.0), np.ones((2, 64), bool)
    ranges[0, [5, 6, 30]] = 0.0
    ranges[1, 10 : 10 + LONGEST + 1] = 0.0
    ranges[1, 40:] = 35.0
    ranges[0, 50], ground[0, 51] = 0.0, False
    before, lost = holes(ranges, ground)
    assert lost.sum() == 3
    assert sorted(lost[lost > 0].tolist()) == [1, 2]
    assert set(before.tolist()) == {20.0, 35.0}


def test_a_compressed_pcd_is_read_and_put_in_its_columns(tmp_path):
    azimuth = np.radians((np.arange(4) - 2) * 360 / COLUMNS)
    columns = {"x": 8 * np.cos(azimuth), "y": 8 * np.sin(azimuth), "z": np.full(4, -2.0)}
    raw = b"".join(values.astype("<f4").tobytes() for values in columns.values()) + np.arange(4, dtype="<u2").tobytes()
    # literals of 16 bytes, but for z: one value, and a reference back to it
    packed = b"".join(bytes([15]) + raw[i : i + 16] for i in (0, 16))
    packed += bytes([3]) + raw[32:36] + bytes([7 << 5, 12 - 9, 3]) + bytes([7]) + raw[48:56]
    header = (
        "VERSION 0.7\nFIELDS x y z ring\nSIZE 4 4 4 2\nTYPE F F F U\nCOUNT 1 1 1 1\nPOINTS 4\nDATA binary_compressed\n"
    )
    sizes = np.array([len(packed), len(raw)], "<u4").tobytes()
    (tmp_path / "a.pcd").write_bytes(header.encode() + sizes + packed)
    read = read_pcd(tmp_path / "a.pcd")
    np.testing.assert_allclose(read["x"], columns["x"], rtol=1e-6)
    np.testing.assert_array_equal(read["z"], -2.0)
    np.testing.assert_array_equal(read["ring"], range(4))
    ranges, ground = images(read)
    assert (ranges > 0).sum() == 4
    np.testing.assert_allclose(ranges[ranges > 0], np.sqrt(68), rtol=1e-6)
    assert ground[ranges > 0].all()
