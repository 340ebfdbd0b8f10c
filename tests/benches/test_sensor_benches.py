"""Fits of sensors give back what made the data."""

import numpy as np
import pytest

from car_holes import gaps
from fit_sensor import fit_noise, fit_roughness
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.materials import Material, diffuse_response
from lidardraft.semantics import BY_NAME


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


def test_lost_firings_on_a_car_are_counted_where_they_are():
    azimuth = -2 * np.pi * np.arange(2083) / 2083
    ring = 8.0 * np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(2083)], axis=1)
    points = np.stack([ring + np.array([0.0, 0.0, z]) for z in (-0.6, -0.9, -1.2, -1.7)])
    label = np.full(points.shape[:2], BY_NAME["road"].id, np.uint8)
    label[:3, 1000:1100] = BY_NAME["car"].id
    points[:3, :1000], points[:3, 1100:] = 0.0, 0.0
    points[1, 1040:1045] = 0.0
    points[1, 1042] = 1.5 * ring[1042]  # through the window
    label[1, 1042] = BY_NAME["building"].id
    lost, height, depth, laser, _, _ = gaps(Sweep(points.astype(np.float32), label)).T
    assert len(lost) == 3 * 99 - 5
    assert lost.sum() == lost.max() == 4
    hole = lost == 4
    assert (height[hole], depth[hole], laser[hole]) == (pytest.approx(0.8), pytest.approx(8.05, abs=0.01), 1)
