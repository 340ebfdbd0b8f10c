"""A receiver that is known is found again, from other streets than it was recorded in."""

from dataclasses import replace

import numpy as np
import pytest
from recorded_streets import SENSOR, sweeps, with_model

from lidardraft.calibration.receiver import at_limits, bisected, fit_receiver, fit_speckle, fit_texture
from lidardraft.calibration.street_casts import StreetCasts
from lidardraft.scene.sensor_model import SensorModel

STREETS = 24
TYPICAL = SensorModel(tilt_spread=0.0, gain_spread=0.0)


@pytest.fixture(scope="module")
def casts() -> StreetCasts:
    return StreetCasts.from_sensor(SENSOR, TYPICAL, STREETS, seed=77)


@pytest.mark.parametrize("target", [0.003, 1.0, 70.0])
def test_bisection_finds_the_value_of_a_monotone_figure(target):
    assert bisected(lambda value: value**2, target**2, (1e-3, 1e2), rising=True) == pytest.approx(target, rel=0.03)
    assert bisected(lambda value: -value, -target, (1e-3, 1e2), rising=False) == pytest.approx(target, rel=0.03)


def test_what_no_value_reaches_gets_the_nearest_limit():
    assert bisected(lambda value: value, 7.0, (0.1, 1.0), rising=True) == pytest.approx(1.0, rel=0.02)
    assert bisected(lambda value: -value, 7.0, (0.1, 1.0), rising=False) == pytest.approx(0.1, rel=0.02)


@pytest.mark.parametrize(
    ("threshold", "drop", "sigma", "jitter"),
    [(0.10 / 40.0**2, 0.002, 0.004, 0.03), (0.10 / 120.0**2, 0.03, 0.02, 0.15)],
    ids=["short and exact", "long and noisy"],
)
def test_drop_and_noise_are_found(casts, threshold, drop, sigma, jitter):
    truth = with_model(detection_threshold=threshold, drop_exponent=drop, jitter=jitter)
    model, found = fit_receiver(sweeps(replace(truth, range_sigma=sigma), STREETS, seed=6), casts, TYPICAL)
    assert model.detection_threshold == pytest.approx(threshold, rel=0.5)  # a quarter in range
    assert model.drop_exponent == pytest.approx(drop, rel=0.2, abs=0.004)
    assert found == pytest.approx(sigma, rel=0.25)
    assert 0.5 * jitter < model.jitter < 2.0 * jitter
    assert model.offset_spread == TYPICAL.offset_spread  # lasers 2 degrees apart do not tell


@pytest.mark.parametrize("spread", [0.003, 0.03])
def test_how_lasers_differ_in_range_is_found_where_they_are_close(spread):
    close = replace(SENSOR, elevations=tuple(np.deg2rad(np.linspace(-6, -22, 33)).tolist()), origin_heights=())
    truth = replace(close, model=replace(SENSOR.model, offset_spread=spread))
    casts = StreetCasts.from_sensor(close, TYPICAL, 6, seed=77)
    model, _ = fit_receiver(sweeps(truth, 6, seed=6), casts, TYPICAL)
    assert spread / 2.5 - 0.01 < model.offset_spread < 2.5 * spread + 0.01


def test_what_edges_lose_is_found(casts):
    truth = with_model(edge_drop=0.4)
    model, _ = fit_receiver(sweeps(truth, STREETS, seed=6), casts, TYPICAL)
    assert model.edge_drop == pytest.approx(0.4, rel=0.5)  # the length of the pulse moves it, too


def test_texture_is_found(casts):
    truth = sweeps(with_model(texture=0.4), STREETS, seed=6)

    def with_texture(texture):
        return replace(TYPICAL, texture=texture)

    found = fit_texture(truth, casts, with_texture, SENSOR.range_sigma, otherwise=0.1)
    assert found.texture == pytest.approx(0.4, rel=0.25)


def test_speckle_is_found(casts):
    truth = with_model(speckle=0.3)
    found = fit_speckle(sweeps(truth, STREETS, seed=6), casts, replace(TYPICAL, speckle=0.05), SENSOR.range_sigma)
    assert found.speckle == pytest.approx(0.3, rel=0.25)


def test_constants_at_a_limit_of_their_search_are_named():
    assert at_limits(TYPICAL, 0.01) == {}
    assert at_limits(replace(TYPICAL, edge_drop=0.0, texture=0.0), 0.01) == {}  # which are off, not found
    assert at_limits(replace(TYPICAL, pulse_duration=4.9e-8, edge_drop=1.01e-3), 2.01e-4) == {
        "pulse_duration": 5e-8,
        "edge_drop": 1e-3,
        "range_sigma": 2e-4,
    }
