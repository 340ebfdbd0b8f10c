"""A receiver and a curve of intensity are found again, from other streets than they were recorded in."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from recorded_streets import SENSOR, sweeps, with_model

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.calibration.intensity import Readings, fit_intensity
from lidardraft.calibration.receiver import at_limits, bisected, fit_receiver, fit_speckle, fit_texture
from lidardraft.calibration.street_casts import StreetCasts, with_rays_that_fit
from lidardraft.calibration.surface_groups import GROUND, LANE, LOW, ROUGH, SMOOTH, groups_of
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor_model import IntensityCurve, SensorModel
from lidardraft.semantics import BY_NAME

STREETS = 16
TYPICAL = SensorModel(tilt_spread=0.0, gain_spread=0.0)


@pytest.fixture(scope="module")
def casts() -> StreetCasts:
    return StreetCasts.from_sensor(SENSOR, TYPICAL, STREETS, seed=77)


@pytest.mark.parametrize("target", [0.003, 1.0, 70.0])
def test_bisection_finds_the_value_of_a_monotone_figure(target):
    assert bisected(lambda value: value**2, target**2, (1e-3, 1e2)) == pytest.approx(target, rel=0.03)
    assert bisected(lambda value: -value, -target, (1e-3, 1e2)) == pytest.approx(target, rel=0.03)


def test_what_no_value_reaches_gets_the_nearest_limit():
    assert bisected(lambda value: value, 7.0, (0.1, 1.0)) == pytest.approx(1.0, rel=0.02)
    assert bisected(lambda value: -value, 7.0, (0.1, 1.0)) == pytest.approx(0.1, rel=0.02)


@pytest.mark.parametrize(
    ("threshold", "drop", "sigma", "jitter"),
    [
        pytest.param(0.10 / 40.0**2, 0.002, 0.004, 0.03, id="short and exact"),
        pytest.param(0.10 / 120.0**2, 0.03, 0.02, 0.15, id="long and noisy"),
    ],
)
def test_drop_and_noise_are_found(casts, threshold, drop, sigma, jitter):
    truth = with_model(detection_threshold=threshold, drop_exponent=drop, jitter=jitter)
    model, found = fit_receiver(sweeps(replace(truth, range_sigma=sigma), STREETS, seed=6), casts, TYPICAL)
    assert model.detection_threshold == pytest.approx(threshold, rel=0.6)  # a quarter in range
    assert model.drop_exponent == pytest.approx(drop, rel=0.2, abs=0.01)
    assert found == pytest.approx(sigma, rel=0.4)
    assert 0.5 * jitter < model.jitter < 2.0 * jitter
    assert model.offset_spread == TYPICAL.offset_spread  # lasers 2 degrees apart do not tell


@pytest.mark.parametrize("spread", [pytest.param(0.003, marks=pytest.mark.slow), 0.03])
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


def test_responses_know_no_least_reading(casts):
    linear, limited = (casts.responses(replace(TYPICAL, least_reading=least), 0.01) for least in (0.0, 1 / 255))
    for one, other in zip(linear, limited, strict=True):
        np.testing.assert_array_equal(one.intensity, other.intensity)


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


CURVE_STREETS = 10
BEAMS = len(SENSOR.elevations)


@pytest.fixture(scope="module")
def own_casts() -> StreetCasts:
    return StreetCasts.from_sensor(SENSOR, SENSOR.model, CURVE_STREETS, seed=77)


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


@settings(max_examples=2, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(curves())
def test_readings_come_out_as_the_known_curve_has_them(own_casts, others, truth):
    model = replace(SENSOR.model, intensity_curve=truth)
    recorded = sweeps(replace(SENSOR, model=model), CURVE_STREETS, seed=6)
    fit = fit_intensity(Readings.from_sweeps(recorded), own_casts.responses(SENSOR.model, SENSOR.range_sigma))
    assert fit.residual < 0.08
    expected = others.observed(model, SENSOR.range_sigma)
    found = others.observed(replace(SENSOR.model, intensity_curve=fit.curve), SENSOR.range_sigma)
    wanted, read = (np.concatenate([s.intensity[s.valid] for s in some]) for some in (expected, found))
    assert np.abs(read - wanted).mean() < 0.035
    assert (read == 0).mean() == pytest.approx((wanted == 0).mean(), abs=0.03)
    for row in range(BEAMS):
        wanted, read = (np.concatenate([s.intensity[row][s.valid[row]] for s in some]) for some in (expected, found))
        assert read.mean() == pytest.approx(wanted.mean(), abs=0.06)


def test_classes_are_used_where_there_are_some(own_casts, others):
    model = replace(SENSOR.model, full_scale=0.5)
    recorded = sweeps(replace(SENSOR, model=model), CURVE_STREETS, seed=6)
    assert all(sweep.label is not None for sweep in recorded)
    for labelled in (recorded, [replace(sweep, label=None) for sweep in recorded]):
        fit = fit_intensity(Readings.from_sweeps(labelled), own_casts.responses(SENSOR.model, SENSOR.range_sigma))
        wanted = others.observed(model, SENSOR.range_sigma)
        found = others.observed(replace(SENSOR.model, intensity_curve=fit.curve), SENSOR.range_sigma)
        both = zip(wanted, found, strict=True)
        assert np.mean([np.abs(a.intensity - b.intensity)[a.valid].mean() for a, b in both]) < 0.055


def test_a_sensor_that_never_reads_0_has_no_cutoff(own_casts):
    curve = IntensityCurve(responses=(1e-4, 10.0), readings=((0.2, 0.9),))
    recorded = sweeps(with_model(intensity_curve=curve), 4, seed=6)
    fit = fit_intensity(Readings.from_sweeps(recorded), own_casts.responses(SENSOR.model, SENSOR.range_sigma))
    assert set(fit.curve.cutoffs) == {0.0}
    assert len(fit.curve.readings) == BEAMS
    assert (np.diff(fit.curve.readings, axis=1) >= 0).all()


def test_retroreflectors_read_as_the_brightest_recorded_returns(own_casts):
    curve = IntensityCurve(responses=(0.01, 1.0, 3.0), readings=((0.1, 0.5, 0.95),))
    recorded = sweeps(with_model(intensity_curve=curve), CURVE_STREETS, seed=6)
    fitted = fit_intensity(Readings.from_sweeps(recorded), own_casts.responses(SENSOR.model, SENSOR.range_sigma)).curve
    assert all(readings[-1] == pytest.approx(0.95, abs=0.01) for readings in fitted.readings)


def test_each_laser_has_a_focus_of_its_own(own_casts, others):
    rng = np.random.default_rng(3)
    focus = np.exp(rng.standard_normal((BEAMS, 3)))
    truth = IntensityCurve(
        responses=(0.005, 3.0),
        readings=((0.0, 0.9),),
        distances=(4.0, 12.0, 40.0),
        distance_gains=tuple(map(tuple, focus.tolist())),
    )
    recorded = sweeps(with_model(intensity_curve=truth), CURVE_STREETS, seed=6)
    curve = fit_intensity(Readings.from_sweeps(recorded), own_casts.responses(SENSOR.model, SENSOR.range_sigma)).curve
    common = replace(curve, distance_gains=(tuple(np.median(curve.distance_gains, axis=0).tolist()),))
    wanted = others.observed(replace(SENSOR.model, intensity_curve=truth), SENSOR.range_sigma)
    off = []
    for model in (curve, common):
        found = others.observed(replace(SENSOR.model, intensity_curve=model), SENSOR.range_sigma)
        both = zip(wanted, found, strict=True)
        off.append(np.mean([np.abs(a.intensity - b.intensity)[a.valid].mean() for a, b in both]))
    assert off[0] < 0.04
    assert off[0] < 0.9 * off[1]


@pytest.fixture(scope="module")
def two_casts() -> StreetCasts:
    return StreetCasts.from_sensor(SENSOR, SENSOR.model, 2, seed=5)


def test_the_model_and_the_noise_are_those_that_are_given(two_casts):
    exact = SensorModel.ideal()
    exact = replace(exact, rays_per_beam=SENSOR.model.rays_per_beam)
    clean, noisy = two_casts.observed(exact, 0.0)[0], two_casts.observed(exact, 0.05)[0]
    both = clean.valid & noisy.valid
    assert (noisy.depth - clean.depth)[both].std() == pytest.approx(0.05, rel=0.05)
    again = two_casts.observed(exact, 0.0)[0]
    np.testing.assert_array_equal(again.points, clean.points)


def test_responses_are_readings_of_a_sensor_without_limits(two_casts):
    linear = replace(SENSOR.model, full_scale=1.0, knee=1.0, levels=0, compensation_range=math.inf)
    read, responses = two_casts.observed(linear, 0.01)[1], two_casts.responses(SENSOR.model, 0.01)[1]
    np.testing.assert_array_equal(read.points, responses.points)
    below = responses.intensity < 0.99
    np.testing.assert_allclose(read.intensity[below], responses.intensity[below], rtol=1e-4)
    assert responses.intensity.max() > 2.0  # a sign


def test_beams_that_are_too_close_for_sub_rays_get_one_each():
    close = Sensor(name="close", elevations=(0.001, 0.0), columns=8)
    assert with_rays_that_fit(close, SensorModel(divergence_v=3e-3)).rays_per_beam == 1
    assert with_rays_that_fit(SENSOR, SENSOR.model) == SENSOR.model


def box(id: str, label: str, center: tuple[float, float, float], size: tuple[float, float, float], **fields: float):
    return Primitive(shape="box", id=id, label=label, center=center, size=size, **fields)


@pytest.fixture(scope="module")
def sweep() -> Sweep:
    road = Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road")
    front = box("front", "building", (0.0, 25.0, 10.0), (300.0, 1.0, 20.0))
    hedge = box("hedge", "vegetation", (0.0, -25.0, 10.0), (300.0, 8.0, 20.0), extinction=0.5)
    car = box("car", "car", (10.0, 5.0, 0.9), (4.0, 1.8, 1.2))
    return Sweep.from_image(raycast(Layout((road, front, hedge, car)), SENSOR))


def test_place_and_shape_say_what_a_return_is_of(sweep):
    group, height = groups_of(sweep, labelled=False), sweep.points[..., 2] + SENSOR.mount_height
    is_of = {name: sweep.label == BY_NAME[name].id for name in ("road", "building", "vegetation", "car")}
    assert set(np.unique(group[is_of["road"]])) == {LANE, GROUND}
    assert (np.abs(sweep.points[..., 1][group == LANE]) < 2.0).all()
    assert (group[is_of["car"] & (height > 0.6)] == LOW).all()
    high = height > 2.6
    assert (group[is_of["building"] & high] == SMOOTH).mean() > 0.6  # at a slant rows bend
    assert (group[is_of["vegetation"] & high] == ROUGH).mean() > 0.9


def test_labels_say_it_where_there_are_some(sweep):
    group = groups_of(sweep, labelled=True)
    per_class = [np.unique(group[sweep.label == BY_NAME[name].id]) for name in ("road", "building", "car")]
    assert [len(found) for found in per_class] == [1, 1, 1]
    assert len(np.unique(per_class)) == 3
