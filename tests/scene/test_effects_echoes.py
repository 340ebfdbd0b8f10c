"""Which of the echoes of a beam is reported: of several surfaces, of glass, of rain, snow and fog."""

from dataclasses import replace

import numpy as np
import pytest
from observed_walls import IDEAL, SENSOR, THRESHOLD, seen, wall

from lidardraft import Layout, Primitive, raycast
from lidardraft.scene.weather import Weather
from lidardraft.semantics import BY_NAME


def test_a_single_surface_is_the_same_through_sub_rays():
    one, three, seven = (
        seen(wall(15.0), replace(IDEAL, rays_per_beam=rays, divergence_h=2e-3, divergence_v=2e-3)) for rays in (1, 3, 7)
    )
    for many in (three, seven):
        np.testing.assert_allclose(many.depth, one.depth, atol=2e-3)
        np.testing.assert_allclose(many.intensity, one.intensity, rtol=0.02)
        np.testing.assert_array_equal(many.label, one.label)


def step(gap: float) -> Layout:
    """A near board before a wall, `gap` apart; beams cross the board's edges."""
    return Layout(primitives=(
        Primitive(shape="box", center=(10.05, 0.0, 0.0), size=(0.1, 3.0, 9.0), label="fence", id="board"),
        Primitive(shape="box", center=(10.5 + gap, 0.0, 0.0), size=(1.0, 99.0, 9.0), label="wall", id="wall"),
    ))  # fmt: skip


def test_mixed_pixels_at_an_edge_lie_between_and_far_edges_do_not_mix():
    model = replace(IDEAL, rays_per_beam=7, divergence_h=6e-3, divergence_v=6e-3)
    for gap, mixes in ((0.4, True), (3.0, False)):
        ahead = replace(SENSOR, azimuth_start=0.3, azimuth_span=0.6)
        scan = seen(step(gap), model, sensor=ahead)
        along = (ahead.pattern.directions() * scan.depth[..., None])[..., 0]
        between = (along > 10.05) & (along < 9.95 + gap)
        assert between.any() == mixes
        assert set(np.unique(scan.label)) == {4, 5}
        if mixes:
            assert between.mean() < 0.02
            assert along.min() > 9.99
            assert along.max() < 10.01 + gap


def test_an_edge_loses_firings_and_slanted_ground_does_not():
    model = replace(IDEAL, rays_per_beam=7, divergence_h=6e-3, divergence_v=6e-3, edge_drop=50.0)
    ahead = replace(SENSOR, azimuth_start=0.3, azimuth_span=0.6)
    assert seen(step(3.0), model, sensor=ahead).valid.mean() < seen(step(3.0), IDEAL, sensor=ahead).valid.mean()
    road = Layout((Primitive(shape="plane", center=(0, 0, -1.7), size=(400, 400, 0), label="road", id="road"),))
    flat = replace(SENSOR, elevations=(-0.03, -0.04))  # a beam's ground is 10 m long
    assert seen(road, model, sensor=flat).valid.all()


def test_the_return_mode_is_strongest_or_last():
    model = replace(IDEAL, rays_per_beam=7, divergence_h=6e-3, divergence_v=6e-3, detection_threshold=1e-9)
    ahead = replace(SENSOR, azimuth_start=0.3, azimuth_span=0.6)
    strongest, last = (
        seen(step(3.0), replace(model, last_return=on, fading=0.0), sensor=ahead) for on in (False, True)
    )
    changed = strongest.label != last.label
    assert changed.any()
    assert (strongest.label[changed] == BY_NAME["fence"].id).all()
    assert (last.label[changed] == BY_NAME["wall"].id).all()
    assert (last.depth >= strongest.depth).all()


def test_a_thin_pole_gives_a_weak_echo():
    pole = Primitive(shape="cylinder", center=(20.0, 0.0, 0.0), size=(0.06, 0.06, 9.0), label="pole", id="pole")
    layout = Layout(primitives=(replace(pole, material="concrete"),))
    model = replace(IDEAL, rays_per_beam=3, divergence_h=3e-3, divergence_v=3e-3)
    narrow = replace(SENSOR, azimuth_start=0.02, azimuth_span=0.04)
    thin, whole = (seen(layout, each, sensor=narrow) for each in (model, IDEAL))
    assert thin.valid.sum() >= whole.valid.sum()
    assert thin.intensity[thin.valid].mean() < 0.8 * whole.intensity[whole.valid].mean()


def test_glass_is_seen_through_in_places_and_not_when_that_is_off():
    layout = wall(15.0, "window")
    # looked at askew: glass that faces the sensor is brighter than what is behind it
    askew = replace(SENSOR, elevations=(0.6, 0.5))
    model = replace(IDEAL, detection_threshold=THRESHOLD / 20)
    clean = raycast(layout, askew).depth
    behind, closed = (seen(layout, replace(model, glass_transmission=on), sensor=askew).depth for on in (True, False))
    np.testing.assert_array_equal(closed[closed > 0], clean[closed > 0])
    deeper = (behind - clean)[behind > clean]
    assert 0.3 < len(deeper) / clean.size < 0.45
    assert deeper.mean() == pytest.approx(0.3, abs=0.05)
    seen_through = behind > clean
    assert (seen_through[:, 1:] == seen_through[:, :-1]).mean() > 0.8  # in patches, not here and there


def test_rain_snow_and_fog_bring_echoes_of_nothing_from_near_by():
    model = replace(IDEAL, rays_per_beam=3, divergence_h=3e-3, divergence_v=3e-3, detection_threshold=0.1 / 200**2)
    for weather in (Weather(visibility=30.0), Weather(snow=5.0), Weather(rain=100.0)):
        clear, scan = seen(wall(200.0), model), seen(wall(200.0), model, weather=weather)  # out of range
        backscatter = scan.valid & (scan.label == 0)
        assert (scan.depth[backscatter] < 40.1).all()
        assert backscatter.mean() > 0.01
        assert (scan.primitive[backscatter] == -1).all()
        assert not clear.valid.any()
