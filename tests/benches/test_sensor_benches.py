"""Fits of sensors give back what made the data."""

import numpy as np
import pytest

from fit_sensor import fit_noise, fit_roughness
from lidardraft.scene.materials import Material, diffuse_response


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
