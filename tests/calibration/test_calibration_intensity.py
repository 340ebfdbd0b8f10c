"""A curve of intensity that is known is found again, from other streets than it was recorded in."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from recorded_streets import SENSOR, sweeps, with_model

from lidardraft.calibration.intensity import fit_intensity
from lidardraft.calibration.street_casts import StreetCasts
from lidardraft.scene.sensor_model import IntensityCurve

STREETS = 16
BEAMS = len(SENSOR.elevations)


@pytest.fixture(scope="module")
def casts() -> StreetCasts:
    return StreetCasts.from_sensor(SENSOR, SENSOR.model, STREETS, seed=77)


@pytest.fixture(scope="module")
def others() -> StreetCasts:
    return StreetCasts.from_sensor(SENSOR, SENSOR.model, 6, seed=5)


@st.composite
def curves(draw: st.DrawFn) -> IntensityCurve:
    """Curves that rise, each beam's a little different, dimmer beyond a focus, with a cut-off."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    steepness, focus = draw(st.floats(0.3, 1.0)), draw(st.floats(8.0, 30.0))
    responses = np.geomspace(0.005, 3.0, 9)
    gains = np.exp(0.3 * rng.standard_normal((BEAMS, 1)))
    readings = np.clip(0.5 * (gains * responses / 0.4) ** steepness + 0.03 * rng.standard_normal((BEAMS, 1)), 0, 1)
    distances = np.array([3.0, focus, 3 * focus])
    return IntensityCurve(
        responses=tuple(responses.tolist()),
        readings=tuple(map(tuple, readings.tolist())),
        distances=tuple(distances.tolist()),
        distance_gains=((draw(st.floats(0.7, 1.0)), 1.0, draw(st.floats(0.15, 0.7))),),
        cutoffs=tuple((draw(st.floats(0.0, 0.08)) + 0.02 * rng.random(BEAMS)).tolist()),
    )


@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(curves())
def test_readings_come_out_as_the_known_curve_has_them(casts, others, truth):
    model = replace(SENSOR.model, intensity_curve=truth)
    recorded = sweeps(replace(SENSOR, model=model), STREETS, seed=6)
    fit = fit_intensity(recorded, casts.responses(SENSOR.model, SENSOR.range_sigma))
    assert fit.residual < 0.08
    expected = others.observed(model, SENSOR.range_sigma)
    found = others.observed(replace(SENSOR.model, intensity_curve=fit.curve), SENSOR.range_sigma)
    wanted, read = (np.concatenate([s.intensity[s.valid] for s in some]) for some in (expected, found))
    assert np.abs(read - wanted).mean() < 0.035
    assert (read == 0).mean() == pytest.approx((wanted == 0).mean(), abs=0.03)
    for row in range(BEAMS):
        wanted, read = (np.concatenate([s.intensity[row][s.valid[row]] for s in some]) for some in (expected, found))
        assert read.mean() == pytest.approx(wanted.mean(), abs=0.06)


def test_classes_are_used_where_there_are_some(casts, others):
    model = replace(SENSOR.model, full_scale=0.5)
    recorded = sweeps(replace(SENSOR, model=model), STREETS, seed=6)
    assert all(sweep.label is not None for sweep in recorded)
    for labelled in (recorded, [replace(sweep, label=None) for sweep in recorded]):
        fit = fit_intensity(labelled, casts.responses(SENSOR.model, SENSOR.range_sigma))
        wanted = others.observed(model, SENSOR.range_sigma)
        found = others.observed(replace(SENSOR.model, intensity_curve=fit.curve), SENSOR.range_sigma)
        both = zip(wanted, found, strict=True)
        assert np.mean([np.abs(a.intensity - b.intensity)[a.valid].mean() for a, b in both]) < 0.04


def test_a_sensor_that_never_reads_0_has_no_cutoff(casts):
    curve = IntensityCurve(responses=(1e-4, 10.0), readings=((0.2, 0.9),))
    recorded = sweeps(with_model(intensity_curve=curve), 4, seed=6)
    fit = fit_intensity(recorded, casts.responses(SENSOR.model, SENSOR.range_sigma))
    assert set(fit.curve.cutoffs) == {0.0}
    assert len(fit.curve.readings) == BEAMS
    assert (np.diff(fit.curve.readings, axis=1) >= 0).all()


def test_retroreflectors_read_as_the_brightest_recorded_returns(casts):
    curve = IntensityCurve(responses=(0.01, 1.0, 3.0), readings=((0.1, 0.5, 0.95),))
    recorded = sweeps(with_model(intensity_curve=curve), STREETS, seed=6)
    fitted = fit_intensity(recorded, casts.responses(SENSOR.model, SENSOR.range_sigma)).curve
    assert all(readings[-1] == pytest.approx(0.95, abs=0.01) for readings in fitted.readings)


def test_each_laser_has_a_focus_of_its_own(casts, others):
    rng = np.random.default_rng(3)
    focus = np.exp(0.5 * rng.standard_normal((BEAMS, 3)))
    truth = IntensityCurve(
        responses=(0.005, 3.0),
        readings=((0.0, 0.9),),
        distances=(4.0, 12.0, 40.0),
        distance_gains=tuple(map(tuple, focus.tolist())),
    )
    recorded = sweeps(with_model(intensity_curve=truth), STREETS, seed=6)
    curve = fit_intensity(recorded, casts.responses(SENSOR.model, SENSOR.range_sigma)).curve
    common = replace(curve, distance_gains=(tuple(np.median(curve.distance_gains, axis=0).tolist()),))
    wanted = others.observed(replace(SENSOR.model, intensity_curve=truth), SENSOR.range_sigma)
    off = []
    for model in (curve, common):
        found = others.observed(replace(SENSOR.model, intensity_curve=model), SENSOR.range_sigma)
        both = zip(wanted, found, strict=True)
        off.append(np.mean([np.abs(a.intensity - b.intensity)[a.valid].mean() for a, b in both]))
    assert off[0] < 0.04
    assert off[0] < 0.85 * off[1]
