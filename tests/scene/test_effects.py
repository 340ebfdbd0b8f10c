"""The effects of a sensor against closed forms, each of them switched on or off, and all together."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from observed_walls import IDEAL, SENSOR, THRESHOLD, seen, wall
from scipy.spatial import cKDTree

from lidardraft import Layout, Primitive, RangeImage, Sensor, raycast
from lidardraft.errors import SensorError
from lidardraft.scene.bodies import Bodies
from lidardraft.scene.effects import observe, sub_rays
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor_model import MODELS, IntensityCurve, SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather, first_particle, particles
from lidardraft.simulation.sweeps import Sweeper


def test_with_every_effect_off_the_scan_is_the_cast():
    layout = wall(12.0)
    clean, scan = raycast(layout, SENSOR, primitive=True, incidence=True), seen(layout, IDEAL)
    for name in ("depth", "label", "instance", "primitive", "incidence"):
        np.testing.assert_array_equal(getattr(scan, name), getattr(clean, name))
        assert getattr(scan, name).dtype == getattr(clean, name).dtype
    assert scan.sensor is SENSOR
    np.testing.assert_allclose(scan.intensity, 0.45, rtol=0.01)


def test_an_empty_image_stays_empty():
    assert not seen(Layout(), SensorModel()).valid.any()


def test_the_same_seed_gives_the_same_scan_and_leaves_the_image_as_it_was():
    layout, model = wall(30.0), SensorModel()
    image = raycast(layout, sub_rays(SENSOR, model), primitive=True, incidence=True)
    before = image.depth.copy()
    one, two, other = (observe(image, layout, seed=seed, sensor=SENSOR, model=model) for seed in (9, 9, 10))
    for name in ("depth", "intensity", "label"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert (one.depth != other.depth).any()
    np.testing.assert_array_equal(image.depth, before)
    for threads in (1, 3):
        np.testing.assert_array_equal(
            observe(image, layout, seed=9, sensor=SENSOR, model=model, threads=threads).depth, one.depth
        )
    generated = observe(image, layout, seed=np.random.Generator(np.random.SFC64(9)), sensor=SENSOR, model=model)
    np.testing.assert_array_equal(generated.depth, one.depth)


def test_a_plain_image_needs_no_sensor_and_a_moving_one_is_observed_alike():
    layout = wall(20.0)
    caster = Raycaster(layout)
    poses = SENSOR.poses_in_motion(velocity=(15.0, 0.0, 0.0))
    moving = caster.scan(SENSOR, poses=poses, primitive=True, incidence=True)
    scan = observe(moving, layout, seed=0, model=IDEAL)
    np.testing.assert_array_equal(scan.depth, moving.depth)
    assert observe(moving, layout, seed=0).valid.mean() > 0.9


def test_errors():
    layout = wall(10.0)
    image = raycast(layout, SENSOR, primitive=True, incidence=True)
    with pytest.raises(SensorError, match="the image lacks primitive or incidence"):
        observe(raycast(layout, SENSOR), layout, seed=0)
    with pytest.raises(SensorError, match="the image shows primitive 0; the layout has 0"):
        observe(image, Layout(), seed=0)
    with pytest.raises(SensorError, match="the image is of small; sub_rays of small are small x 3"):
        observe(image, layout, seed=0, sensor=SENSOR)


# Another value for every number of the model.
OTHERWISE = {
    "rays_per_beam": 7,
    "divergence_h": 9.0e-3,
    "divergence_v": 9.0e-3,
    "pulse_duration": 20e-9,
    "detection_threshold": 0.10 / 15.0**2,
    "last_return": True,
    "speckle": 0.3,
    "texture": 0.3,
    "material_noise": False,
    "dust": 0.8,
    "fading": 0.0,
    "drop_exponent": 0.3,
    "edge_drop": 3.0,
    "glass_transmission": False,
    "jitter": 0.3,
    "range_step": 0.1,
    "unit": 1,
    "range_offsets": (0.1, 0.0, 0.0, 0.0),
    "offset_spread": 0.1,
    "gain_spread": 0.3,
    "tilt_spread": 0.02,
    "full_scale": 0.5,
    "knee": 0.6,
    "cutoff": 0.5,
    "cutoff_spread": 2.0,
    "levels": 7,
    "least_reading": 0.3,
    "compensation_range": 15.0,
    "intensity_curve": IntensityCurve(responses=(0.01, 1.0), readings=((0.1, 0.7),)),
}


def corner_with_a_window() -> Layout:
    """A wall far off, a sign brighter than white, a pane, and poles that beams half meet, some before a panel."""

    def box(id: str, center: tuple[float, float, float], size: tuple[float, float, float], material: str) -> Primitive:
        return Primitive(shape="box", center=center, size=size, label="building", id=id, material=material)

    poles = [box(f"pole_{k}", (6.0, 0.25 * k - 5.0, 0.0), (0.03, 0.03, 8.0), "plaster") for k in range(40)]
    panel = box("panel", (7.6, -2.5, 0.0), (0.1, 5.0, 8.0), "plaster")
    sign = box("sign", (0.0, 20.0, 0.0), (10.0, 0.2, 10.0), "retroreflector")
    pane = box("pane", (-5.0, 0.0, 0.0), (0.1, 30.0, 20.0), "glass")
    road = Primitive(shape="plane", center=(0, 0, -0.6), size=(200, 200, 0), label="road", id="road", material="gravel")
    return Layout((*wall(40.0).primitives, *poles, panel, sign, pane, road))


def test_every_number_of_the_model_has_an_effect():
    assert set(OTHERWISE) == {field.name for field in fields(SensorModel)}
    layout, model = corner_with_a_window(), SensorModel(unit=2)
    usual = seen(layout, model)
    for name, value in OTHERWISE.items():
        other = seen(layout, replace(model, **{name: value}))
        changed = (usual.depth != other.depth) | (usual.intensity != other.intensity)
        assert changed.any(), name


@pytest.mark.parametrize("distance", [20.0, 50.0, 100.0])
def test_ray_drop_follows_the_power(distance: float):
    scan = seen(wall(distance, "plaster"), replace(IDEAL, detection_threshold=THRESHOLD))
    power = 0.45 * (1 / distance**2) / THRESHOLD
    assert scan.valid.mean() == pytest.approx(math.exp(-2 / power**1.25), abs=0.02)


def test_the_drop_exponent_holds_for_near_bright_surfaces():
    assert seen(wall(3.0), replace(IDEAL, drop_exponent=0.1)).valid.mean() == pytest.approx(math.exp(-0.1), abs=0.01)


def test_beams_that_make_several_echoes_are_dropped_by_their_own_probability():
    panel = Primitive(shape="box", center=(6.0, 0.0, 0.0), size=(0.1, 5.0, 8.0), label="building", id="panel")
    layout = Layout(primitives=(*wall(20.0).primitives, panel))
    fan = replace(IDEAL, rays_per_beam=3, divergence_h=9e-3, divergence_v=9e-3)
    depth = raycast(layout, sub_rays(SENSOR, fan)).depth.reshape(4, 3, -1)
    split = np.ptp(depth, axis=1) > fan.pulse_length
    assert split.sum() >= 8
    np.testing.assert_array_equal(seen(layout, replace(fan, edge_drop=20.0)).valid, ~split)
    scans = [seen(layout, replace(fan, edge_drop=0.5), seed=seed).valid for seed in range(40)]
    assert np.mean([valid[split] for valid in scans]) == pytest.approx(math.exp(-0.5), abs=0.1)
    assert all(valid[~split].all() for valid in scans)


def test_fading_keeps_the_share_of_dropped_rays_and_makes_runs_of_them():
    layout = wall(40.0, "rubber")
    power = 0.03 / 40.0**2 / 1e-6
    drops = 1 - math.exp(-2 / power**1.25)
    lengths = []
    for fading in (0.0, 1.6):
        dropped = np.concatenate(
            [~seen(layout, replace(IDEAL, detection_threshold=1e-6, fading=fading), seed=s).valid for s in range(12)]
        )
        starts = dropped[:, 1:] & ~dropped[:, :-1]
        lengths.append(dropped.sum() / starts.sum())
        assert dropped.mean() == pytest.approx(drops, abs=0.015)
    assert lengths[0] == pytest.approx(1.0 / (1 - drops), abs=0.05)
    assert lengths[1] > lengths[0] + 0.1


def test_glass_that_is_turned_away_is_dropped_where_plaster_is_not():
    # a ring seen from far below its axis: 60 degrees of incidence
    steep = replace(SENSOR, elevations=(-1.0, -1.05))
    for material, most in (("glass", 0.65), ("plaster", 0.0)):
        scan = seen(wall(15.0, material), replace(IDEAL, detection_threshold=THRESHOLD), sensor=steep)
        assert (~scan.valid).mean() >= most
    assert scan.valid.mean() > 0.9


def road() -> Layout:
    return Layout(primitives=(
        Primitive(shape="plane", center=(0.0, 0.0, 0.0), size=(400.0, 400.0, 0.0), label="road", id="road"),
    ))  # fmt: skip


def test_grazing_incidence_and_a_wet_road_drop_returns():
    down = replace(SENSOR, elevations=(-0.06, -0.15, -0.3), columns=16384)
    model = replace(IDEAL, detection_threshold=THRESHOLD / 10)
    dry, wet = (seen(road(), model, sensor=down, weather=Weather(wetness=w)).valid.mean(axis=1) for w in (0.0, 1.0))
    assert (np.diff(dry) > 0).all()
    assert (wet < dry).all()
    assert (dry - wet)[0] > 0.3


def test_a_return_from_nothing_is_no_return_in_every_image():
    scan = seen(wall(100.0, "rubber"), replace(IDEAL, detection_threshold=THRESHOLD))
    dropped = ~scan.valid
    assert dropped.mean() > 0.9
    for name, blank in (("label", 0), ("instance", 0), ("intensity", 0), ("incidence", 0), ("primitive", -1)):
        assert (getattr(scan, name)[dropped] == blank).all()


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


def test_glass_is_seen_through_to_one_depth_a_pane_and_not_when_that_is_off():
    layout = wall(15.0, "window")
    # looked at askew: glass that faces the sensor is brighter than what is behind it
    askew = replace(SENSOR, elevations=(0.6, 0.5))
    model = replace(IDEAL, detection_threshold=THRESHOLD / 20)
    clean = raycast(layout, askew).depth
    behind, closed = (seen(layout, replace(model, glass_transmission=on), sensor=askew).depth for on in (True, False))
    np.testing.assert_array_equal(closed[closed > 0], clean[closed > 0])
    deeper = (behind - clean)[behind > clean]
    assert len(deeper) > 0.99 * clean.size
    assert deeper.mean() == pytest.approx(0.25, abs=0.02)
    assert np.quantile(np.abs(np.diff(behind, axis=1)), 0.9) < 0.05  # no jumps from firing to firing


def test_one_pane_is_not_as_deep_as_another():
    panes = [replace(wall(15.0, "window").primitives[0], id=f"pane {k}", center=(0.0, 0.0, float(k))) for k in range(9)]
    assert np.unique(Surfaces.from_layout(Layout(tuple(panes))).behind).size == 10


@pytest.mark.parametrize(
    ("weather", "fall"),
    [(Weather(snow=rate), 1.0) for rate in (0.5, 1.0, 4.0)] + [(Weather(rain=rate), 5.0) for rate in (2.0, 5.0, 20.0)],
)
def test_as_much_water_is_in_the_air_as_falls(weather: Weather, fall: float):
    """An exponential distribution N0 exp(-L D) of drops holds pi N0 / L^4 of water, which falls at about 1 m/s as snow
    and 5 m/s as rain."""
    density, least, larger, _ = particles(weather)
    most = density / larger * np.exp(least / larger)
    assert 3.6e6 * np.pi * most * larger**4 * fall == pytest.approx(max(weather.snow, weather.rain), rel=0.5)


def test_a_beam_meets_what_its_volume_holds():
    """A cone frustum from 0.95 to 40 m, round and as wide as the window and its divergence."""
    weather, width = Weather(snow=1.0), 2e-4
    radii = (0.011 + width * np.array([0.95, 40.0])) / 2
    volume = np.pi / 3 * (40.0 - 0.95) * (radii[0] ** 2 + radii[0] * radii[1] + radii[1] ** 2)
    range_, _ = first_particle(weather, (width, width), (200, 1000), np.random.default_rng(0))
    held = 3.8e6 / 2550 * np.exp(-2.55)  # snowflakes over 1 mm in a cubic metre (Gunn and Marshall, 1958)
    assert (range_ > 0).mean() == pytest.approx(1 - np.exp(-held * volume), abs=0.005)


def test_rain_snow_and_fog_bring_echoes_of_nothing_from_near_by():
    model = replace(IDEAL, rays_per_beam=3, divergence_h=3e-3, divergence_v=3e-3, detection_threshold=0.1 / 200**2)
    for weather in (Weather(visibility=30.0), Weather(snow=5.0), Weather(rain=100.0)):
        clear, scan = seen(wall(200.0), model), seen(wall(200.0), model, weather=weather)  # out of range
        backscatter = scan.valid & (scan.label == 0)
        assert (scan.depth[backscatter] < 40.1).all()
        assert backscatter.mean() > 0.01
        assert (scan.primitive[backscatter] == -1).all()
        assert not clear.valid.any()


def test_fog_takes_its_share_there_and_back():
    model = replace(
        IDEAL, divergence_h=1e-6, divergence_v=1e-6, pulse_duration=1e-15
    )  # an echo of fog itself is of no power
    clear, fog = (seen(wall(30.0), model, weather=Weather(visibility=v)) for v in (math.inf, 150.0))
    np.testing.assert_allclose(fog.intensity / clear.intensity, np.exp(-2 * 3.91 / 150.0 * clear.depth), rtol=1e-5)


def test_intensity_is_calibrated_saturates_and_is_rounded():
    white = replace(IDEAL, full_scale=0.4)
    assert seen(wall(5.0, "plaster"), white).intensity.max() == 1.0
    tenths = replace(IDEAL, levels=10)
    np.testing.assert_allclose(np.unique(seen(wall(5.0, "brick"), tenths).intensity), [0.4])
    for distance in (5.0, 40.0):
        assert seen(wall(distance), IDEAL).intensity.mean() == pytest.approx(0.45, rel=0.01)
    # what is corrected to 40 m has half left there
    assert seen(wall(40.0), replace(IDEAL, compensation_range=40.0)).intensity.mean() == pytest.approx(0.225, rel=0.01)


def test_a_knee_keeps_the_upper_scale_for_retroreflectors():
    model = replace(IDEAL, knee=100 / 255, full_scale=300.0)
    assert seen(wall(10.0, "plaster"), model).intensity.mean() == pytest.approx(0.45 * 100 / 255, rel=0.01)
    bright = seen(wall(10.0, "retroreflector"), model).intensity
    assert bright.min() > 100 / 255
    assert bright.max() <= 1.0


def test_a_curve_is_linear_in_the_logarithm_and_each_beam_may_have_its_own():
    flat, steep, low, dark = (0.4, 0.4, 0.4), (0.0, 0.65, 1.0), (0.1, 0.4, 0.9), (0.0, 0.1, 0.2)
    curve = IntensityCurve(
        responses=(0.045, 0.45, 4.5), readings=(flat, steep, low, dark), cutoffs=(0.0, 0.7, 0.2, 0.11)
    )
    for model, expected in (
        (replace(IDEAL, intensity_curve=curve), [0.4, 0.0, 0.4, 0.0]),
        (replace(IDEAL, intensity_curve=replace(curve, readings=(low,), cutoffs=())), [0.4] * 4),
    ):
        np.testing.assert_allclose(seen(wall(10.0), model).intensity.T, np.tile(expected, (1024, 1)), atol=3e-3)
    third = replace(curve, responses=(0.45 / 10, 0.45 * 10, 45.0), readings=(low,), cutoffs=())
    np.testing.assert_allclose(seen(wall(10.0), replace(IDEAL, intensity_curve=third)).intensity, 0.25, atol=3e-3)


def test_a_curve_has_gains_by_distance():
    curve = IntensityCurve(
        responses=(0.0045, 0.45), readings=((0.0, 1.0),), distances=(10.0, 20.0), distance_gains=((0.1, 0.01),)
    )
    near, middle, far = (
        seen(wall(distance), replace(IDEAL, intensity_curve=curve)).intensity for distance in (5.0, 15.0, 40.0)
    )
    for read, expected in ((near, 0.5), (middle, 0.25), (far, 0.0)):
        np.testing.assert_allclose(read, expected, atol=2e-3)
    each = replace(curve, distance_gains=((0.1, 0.01), (1.0, 1.0), (0.01, 0.01), (0.1, 0.01)))
    read = seen(wall(5.0), replace(IDEAL, intensity_curve=each)).intensity
    np.testing.assert_allclose(read.T, np.tile([0.5, 1.0, 0.0, 0.5], (1024, 1)), atol=2e-3)


def test_a_curve_of_another_sensor_is_refused():
    curve = IntensityCurve(responses=(0.1,), readings=((0.5,),), cutoffs=(0.1, 0.1))
    with pytest.raises(SensorError, match="cutoffs of the intensity curve has 2 values; it needs 4"):
        seen(wall(10.0), replace(IDEAL, intensity_curve=curve))


def test_speckle_and_grain_scatter_the_intensity():
    for change, spread in (({"speckle": 0.1}, 0.1), ({"material_noise": True}, 0.03)):
        logarithm = np.log(seen(wall(10.0), replace(IDEAL, **change)).intensity / 0.45)
        assert logarithm.std() == pytest.approx(spread, rel=0.2)
        assert abs(np.corrcoef(logarithm[:, 1:].ravel(), logarithm[:, :-1].ravel())[0, 1]) < 0.1
        assert abs(np.corrcoef(logarithm[1], logarithm[2])[0, 1]) < 0.15


def test_texture_makes_surfaces_brighter_here_than_there():
    logarithm, half = (np.log(seen(wall(30.0, m), replace(IDEAL, texture=0.2)).intensity) for m in ("soil", "plaster"))
    assert logarithm.std() == pytest.approx(0.2, rel=0.2)
    assert half.std() == pytest.approx(0.1, rel=0.2)
    # 0.18 m from firing to firing, 0.6 m from beam to beam
    assert np.corrcoef(logarithm[:, 1:].ravel(), logarithm[:, :-1].ravel())[0, 1] > 0.8
    assert np.corrcoef(logarithm[0], logarithm[1])[0, 1] > 0.5


def test_paint_and_glass_have_no_texture():
    for material in ("mid-paint", "car-glass"):
        plain, textured = (seen(wall(10.0, material), replace(IDEAL, texture=texture)) for texture in (0.0, 0.5))
        np.testing.assert_array_equal(plain.intensity, textured.intensity)


def test_a_place_has_one_texture_for_every_beam_and_pose():
    model = replace(IDEAL, texture=0.3)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road", material="asphalt")
    places, read = [], []
    for x, columns, down in ((0.0, 512, 0.0), (3.0, 700, 0.003)):
        angles = tuple(-0.1 - down - 0.002 * k for k in range(100))
        sensor = replace(SENSOR, elevations=angles, columns=columns)
        pose = sensor.pose(x, yaw=0.4 * x)
        clean = raycast(Layout((road,)), sensor, pose, primitive=True, incidence=True)
        scan = observe(clean, Layout((road,)), seed=0, model=model, poses=pose)
        points = clean.points() @ pose[:3, :3].T + pose[:3, 3]
        response = seen_flat(clean, road)
        places.append(points), read.append(np.log(scan.intensity[clean.valid] / response[clean.valid]))
    distance, nearest = cKDTree(places[0]).query(places[1])
    close = distance < 0.005
    assert close.sum() > 100
    assert np.abs(read[1] - read[0][nearest])[close].std() < 0.1 * read[0].std()


def seen_flat(clean: RangeImage, road: Primitive) -> np.ndarray:
    """What is read of a road without texture."""
    intensity = observe(clean, Layout((road,)), seed=0, model=IDEAL).intensity
    assert intensity is not None
    return intensity


def test_no_return_of_an_ouster_reads_0():
    scan = seen(wall(30.0, "dark-paint"), replace(MODELS["os1-128"], rays_per_beam=1))
    assert scan.valid.mean() > 0.9
    assert scan.intensity[scan.valid].min() >= 1 / 255 - 1e-6


def test_dust_darkens_the_same_places_in_every_scan():
    stained = [seen(wall(10.0), replace(IDEAL, dust=2.0), seed=seed).intensity for seed in (0, 1)]
    np.testing.assert_array_equal(*stained)
    dark = stained[0] < 0.44
    assert 0.01 < dark.mean() < 0.3
    assert (stained[0] <= 0.46).all()


def test_what_would_read_less_than_the_cutoff_reads_0():
    usual = seen(wall(12.0), IDEAL).intensity
    np.testing.assert_array_equal(seen(wall(12.0), replace(IDEAL, cutoff=0.4)).intensity, usual)
    assert not seen(wall(12.0), replace(IDEAL, cutoff=0.5)).intensity.any()
    unit = replace(IDEAL, cutoff=0.45, cutoff_spread=0.3, unit=2)
    differing, again = (seen(wall(12.0), unit, seed=seed).intensity for seed in (0, 1))
    assert set((differing > 0).mean(axis=1)) == {0.0, 1.0}  # whole beams, the same in every scan of a unit
    np.testing.assert_array_equal(differing > 0, again > 0)


def test_range_noise_grows_as_power_falls():
    model = replace(IDEAL, jitter=0.1, detection_threshold=1e-5)
    noisy = replace(SENSOR, range_sigma=0.02)
    for distance, material in ((5.0, "plaster"), (50.0, "plaster"), (50.0, "rubber")):
        scan = seen(wall(distance, material), model, sensor=noisy)
        share = {"plaster": 0.45, "rubber": 0.03}[material]
        power = share / distance**2 / 1e-5
        clean = raycast(wall(distance, material), noisy).depth
        spread = (scan.depth - clean)[scan.valid].std()
        assert spread == pytest.approx(math.hypot(0.02, 0.1 / math.sqrt(power)), rel=0.05)


def test_a_rough_surface_scatters_ranges_by_its_heights():
    model = replace(IDEAL, material_noise=True)
    flat = Layout(
        (Primitive(shape="plane", center=(0, 0, -2), size=(200, 200, 0), label="other", id="ground", material="bark"),)
    )
    steep = replace(SENSOR, elevations=(-0.8, -0.9, -1.0, -1.1))
    for layout, sensor, cosine in (
        (wall(9.0, "bark"), SENSOR, np.ones(4)),
        (flat, steep, np.sin([0.8, 0.9, 1.0, 1.1])),
    ):
        moved = seen(layout, model, sensor=sensor).depth - raycast(layout, sensor).depth
        np.testing.assert_allclose(moved.std(axis=1), 0.01 / cosine, rtol=0.12)
    smooth = seen(wall(9.0, "plaster"), model).depth
    np.testing.assert_array_equal(smooth, raycast(wall(9.0), SENSOR).depth)


def test_uneven_ground_is_as_high_at_a_place_in_every_scan_and_from_everywhere():
    lawn = Layout((Primitive(shape="plane", center=(0, 0, -2), size=(200, 200, 0), label="terrain", id="lawn"),))
    sensor = replace(SENSOR, columns=2000, elevations=(-0.3, -0.4, -0.5))
    model, aside = replace(IDEAL, material_noise=True), np.eye(4)
    aside[1, 3] = 0.01

    def heights(seed: int, pose: np.ndarray) -> np.ndarray:
        clean = raycast(lawn, sensor, pose, primitive=True, incidence=True)
        found = observe(clean, lawn, seed=seed, sensor=sensor, model=model, poses=pose)
        return (found.depth - clean.depth) * np.sin([[-0.3], [-0.4], [-0.5]])

    here, again, beside = heights(1, np.eye(4)), heights(2, np.eye(4)), heights(3, aside)
    np.testing.assert_allclose(here.std(), math.hypot(0.022, 0.008), rtol=0.15)
    for other in (again, beside):
        assert np.corrcoef(here.ravel(), other.ravel())[0, 1] > 0.8
    off = np.abs(np.diff(here, axis=1))
    assert np.median(off) < 0.02  # alike close by


def test_ranges_are_rounded_and_never_leave_the_limits():
    coarse = seen(wall(12.0), replace(IDEAL, range_step=0.25)).depth
    np.testing.assert_allclose(np.unique(coarse), [12.0])
    near = replace(SENSOR, range_sigma=0.3, min_range=0.5)
    assert seen(wall(0.52), IDEAL, sensor=near).depth.min() >= np.float32(0.5)


def test_each_beam_of_a_unit_has_an_offset_and_a_gain_of_its_own():
    model = replace(IDEAL, offset_spread=0.05, gain_spread=0.3)
    clean = raycast(wall(10.0), SENSOR).depth
    one, again, other = (seen(wall(10.0), replace(model, unit=u), seed=s) for u, s in ((3, 0), (3, 1), (4, 0)))
    np.testing.assert_array_equal(one.depth, again.depth)
    np.testing.assert_allclose((one.depth - clean).std(axis=1), 0.0, atol=1e-5)
    assert len(np.unique((one.depth - clean)[:, 0])) == 4
    assert len(np.unique(one.intensity)) == 4
    assert (one.depth != other.depth).all()


def test_a_known_offset_is_in_every_range_of_its_beam():
    layout, offsets = wall(12.0), (0.05, 0.0, -0.02, 0.0)
    off = seen(layout, replace(IDEAL, range_offsets=offsets)).depth - seen(layout, IDEAL).depth
    np.testing.assert_allclose(off, np.broadcast_to(np.array(offsets)[:, None], off.shape), atol=1e-5)
    # a model alone does not know how many beams there are
    with pytest.raises(SensorError, match="range_offsets has 3 values; it needs one for each of 4 beams"):
        seen(layout, replace(IDEAL, range_offsets=offsets[:3]))


FEW = Sensor(name="few", elevations=(0.05, 0.0, -0.05, -0.1), columns=256)
LAYOUT = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road"),
    Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="car_1", instance=1),
))  # fmt: skip
RAIN = Weather(rain=20.0, wetness=1.0)


def same(one: RangeImage, two: RangeImage) -> bool:
    names = ("depth", "label", "instance", "intensity")
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in names)


def test_a_scan_is_a_cast_that_is_observed() -> None:
    model = SensorModel(unit=3, jitter=0.2)
    poses = FEW.poses_in_motion(velocity=(15.0, 0.0, 0.0))
    for kwargs in ({"pose": FEW.pose(x=1.0)}, {"poses": poses}):
        (pose,) = kwargs.values()
        clean = Raycaster(LAYOUT).scan(sub_rays(FEW, model), **kwargs, primitive=True, incidence=True, seed=4)
        surfaces = Surfaces.from_layout(LAYOUT, wetness=1.0)
        expected = observe(clean, surfaces, seed=5, sensor=FEW, model=model, weather=RAIN, poses=pose)
        for threads in (None, 1, 3):
            sweeper, bodies = Sweeper.of(FEW, model, RAIN, threads), Bodies.of(LAYOUT, RAIN.wetness, by_id=False)
            scan = sweeper.observe(sweeper.cast(bodies, (), pose, 4), bodies.surfaces, pose, 5)
            assert same(scan, expected)
    assert expected.valid.mean() > 0.25
    assert Sweeper.of(FEW, None, None).model == SensorModel()
