"""Streets that are cast once and observed often."""

import math
from dataclasses import replace

import numpy as np
import pytest
from recorded_streets import SENSOR

from lidardraft import Sensor
from lidardraft.calibration.street_casts import StreetCasts, with_rays_that_fit
from lidardraft.scene.sensor_model import SensorModel


@pytest.fixture(scope="module")
def casts() -> StreetCasts:
    return StreetCasts.from_sensor(SENSOR, SENSOR.model, 2, seed=5)


def test_the_model_and_the_noise_are_those_that_are_given(casts):
    exact = SensorModel.ideal()
    exact = replace(exact, rays_per_beam=SENSOR.model.rays_per_beam)
    clean, noisy = casts.observed(exact, 0.0)[0], casts.observed(exact, 0.05)[0]
    both = clean.valid & noisy.valid
    assert (noisy.depth - clean.depth)[both].std() == pytest.approx(0.05, rel=0.05)
    again = casts.observed(exact, 0.0)[0]
    np.testing.assert_array_equal(again.points, clean.points)


def test_responses_are_readings_of_a_sensor_without_limits(casts):
    linear = replace(SENSOR.model, full_scale=1.0, knee=1.0, levels=0, compensation_range=math.inf)
    read, responses = casts.observed(linear, 0.01)[1], casts.responses(SENSOR.model, 0.01)[1]
    np.testing.assert_array_equal(read.points, responses.points)
    below = responses.intensity < 0.99
    np.testing.assert_allclose(read.intensity[below], responses.intensity[below], rtol=1e-4)
    assert responses.intensity.max() > 2.0  # a sign


def test_beams_that_are_too_close_for_sub_rays_get_one_each():
    close = Sensor(name="close", elevations=(0.001, 0.0), columns=8)
    assert with_rays_that_fit(close, SensorModel(divergence_v=3e-3)).rays_per_beam == 1
    assert with_rays_that_fit(SENSOR, SENSOR.model) == SENSOR.model
