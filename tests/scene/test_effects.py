"""Effects against their closed forms and limits."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft import Layout, LidarDraftError, Primitive, RangeImage, Sensor, raycast
from lidardraft.errors import LayoutError, SensorError
from lidardraft.scene.effects import (
    Surface,
    drop,
    intensity,
    keep,
    observe,
    penetrate,
    power,
    range_noise,
    response,
    speckle,
)

SENSOR = Sensor(name="small", elevations=(0.02, -0.02), columns=512)


def wall(distance: float, material: str | None = "plaster") -> tuple[Layout, RangeImage]:
    """A ring of wall around the sensor, every ray at a right angle and at one distance."""
    ring = Primitive(
        shape="cylinder",
        center=(0.0, 0.0, 0.0),
        size=(2 * distance, 2 * distance, 40.0),
        label="building",
        id="ring",
        material=material,
    )
    layout = Layout(primitives=(ring,))
    return layout, raycast(layout, SENSOR, primitive=True, incidence=True, normal=True)


def surface(incidence: np.ndarray, reflectance: float = 1.0) -> Surface:
    flat = np.full_like(incidence, reflectance)
    return Surface(flat, 0 * flat, 0 * flat, 0 * flat, incidence)


def test_a_facing_white_surface_responds_with_its_reflectance():
    assert response(surface(np.ones(1), 0.4)) == pytest.approx(0.4)


def test_response_falls_with_incidence():
    cosines = np.cos(np.linspace(0, math.pi / 2, 50))
    assert (np.diff(response(surface(cosines))) < 0).all()


def test_a_grazed_rough_surface_still_responds():
    # B / A of Oren and Nayar at a slope spread of 0.4 rad
    expected = (0.45 * 0.16 / 0.25) / (1 - 0.5 * 0.16 / 0.49)
    assert response(surface(np.zeros(1))) == pytest.approx(expected)


def test_power_falls_with_the_square_of_range():
    near, far = (power(image, Surface.of(image, layout)).mean() for layout, image in (wall(10.0), wall(20.0)))
    assert near / far == pytest.approx(4.0, rel=0.01)


def test_pavement_facing_the_sensor_at_50_m_is_at_the_threshold():
    _, image = wall(50.0)
    white = Surface.of(image, wall(50.0)[0])
    assert power(image, replace(white, reflectance=np.full(SENSOR.shape, 0.1))).mean() == pytest.approx(1.0, rel=0.01)


def test_intensity_falls_with_range_and_stays_in_0_1():
    means = []
    for distance in (5.0, 20.0, 40.0, 80.0):
        layout, image = wall(distance, "retroreflector")
        lit = intensity(image, Surface.of(image, layout)).intensity
        assert lit.min() >= 0.0
        assert lit.max() <= 1.0
        means.append(lit.mean())
    assert (np.diff(means) < 0).all()
    # corrected for range to 40 m: there, half is left
    assert means[2] == pytest.approx(0.5, rel=0.01)


def test_nothing_is_dropped_when_every_cause_is_off():
    layout, image = wall(10.0, "plaster")
    assert (
        drop(image, Surface.of(image, layout), np.random.default_rng(0), chance=0.0).valid.sum()
        >= image.valid.sum() - 1
    )


def test_everything_is_dropped_at_chance_1():
    layout, image = wall(10.0)
    assert not drop(image, Surface.of(image, layout), np.random.default_rng(0), chance=1.0).valid.any()


@pytest.mark.parametrize(("material", "lost"), [("plaster", 0.0), ("glass", 0.85), ("window", 0.6)])
def test_transmission_is_the_share_that_is_lost(material: str, lost: float):
    layout, image = wall(3.0, material)
    left = drop(image, Surface.of(image, layout), np.random.default_rng(1), chance=0.0).valid.mean()
    assert left == pytest.approx(1.0 - lost, abs=0.05)


def test_gloss_loses_rays_at_grazing_incidence_only():
    _, image = wall(2.0)
    shape = SENSOR.shape
    for cosine, left in ((1.0, 1.0), (0.5, 1 - 0.8 * 0.75)):
        glossy = replace(surface(np.full(shape, cosine)), gloss=np.full(shape, 0.8))
        share = drop(image, glossy, np.random.default_rng(2), chance=0.0).valid.mean()
        assert share == pytest.approx(left, abs=0.05)


def test_a_dark_far_surface_is_lost_and_a_near_one_is_not():
    near, far = (
        drop(image, Surface.of(image, layout), np.random.default_rng(3), chance=0.0).valid.mean()
        for layout, image in (wall(5.0, "rubber"), wall(100.0, "rubber"))
    )
    assert near > 0.99
    assert far < 0.05


def test_what_is_dropped_is_no_return_in_every_image():
    layout, image = wall(10.0)
    lit = intensity(image, Surface.of(image, layout))
    mask = np.zeros(SENSOR.shape, dtype=bool)
    mask[0] = True
    left = keep(lit, mask)
    assert left.valid[0].all()
    for name, blank in (
        ("depth", 0),
        ("label", 0),
        ("instance", 0),
        ("intensity", 0),
        ("incidence", 0),
        ("primitive", -1),
        ("normal", 0),
    ):
        assert (getattr(left, name)[1] == blank).all()
        assert getattr(left, name).dtype == getattr(lit, name).dtype


def test_range_noise_has_the_sensors_sigma_and_grows_with_weak_echoes():
    spread = []
    for distance, material in ((5.0, "plaster"), (100.0, "rubber")):
        layout, image = wall(distance, material)
        noisy = range_noise(image, Surface.of(image, layout), np.random.default_rng(4))
        spread.append((noisy.depth - image.depth).std())
    assert spread[0] == pytest.approx(SENSOR.range_sigma, rel=0.1)
    assert spread[1] == pytest.approx(3 * SENSOR.range_sigma, rel=0.1)


def test_foliage_is_seen_from_behind_its_surface_and_plaster_is_not():
    layout, image = wall(5.0, "foliage")
    deeper = penetrate(image, Surface.of(image, layout), np.random.default_rng(5)).depth - image.depth
    assert deeper.min() >= 0.0
    assert deeper.mean() == pytest.approx(0.08, rel=0.15)
    layout, image = wall(5.0, "plaster")
    assert (penetrate(image, Surface.of(image, layout), np.random.default_rng(5)).depth == image.depth).all()


def test_noise_never_leaves_the_sensors_limits():
    layout, image = wall(0.52)
    noisy = range_noise(image, Surface.of(image, layout), np.random.default_rng(6))
    assert noisy.depth.min() >= np.float32(SENSOR.min_range)


def test_speckle_of_spread_0_changes_nothing():
    layout, image = wall(10.0)
    lit = intensity(image, Surface.of(image, layout))
    assert (speckle(lit, np.random.default_rng(7), spread=0.0).intensity == lit.intensity).all()


def test_an_empty_image_stays_empty():
    layout = Layout()
    image = raycast(layout, SENSOR, primitive=True, incidence=True)
    seen = observe(image, layout, np.random.default_rng(8))
    assert not seen.valid.any()
    assert (seen.intensity == 0).all()


def test_the_same_seed_gives_the_same_scan():
    layout, image = wall(30.0)
    one, two = (observe(image, layout, np.random.default_rng(9)) for _ in range(2))
    assert (one.depth == two.depth).all()
    assert (one.intensity == two.intensity).all()
    assert (observe(image, layout, np.random.default_rng(10)).depth != one.depth).any()


def test_the_image_given_is_not_changed():
    layout, image = wall(30.0)
    before = image.depth.copy()
    observe(image, layout, np.random.default_rng(11))
    assert (image.depth == before).all()
    assert image.intensity is None


def test_errors():
    layout, image = wall(10.0)
    with pytest.raises(SensorError, match="the image lacks primitive or incidence"):
        Surface.of(replace(image, primitive=None), layout)
    with pytest.raises(SensorError, match="the image shows primitive 0; the layout has 0"):
        Surface.of(image, Layout())
    with pytest.raises(LayoutError, match="ring: material is 'cheese'; it must be one of asphalt, "):
        observe(image, wall(10.0, "cheese")[0], np.random.default_rng(0))
    with pytest.raises(SensorError, match="the image has no intensity"):
        speckle(image, np.random.default_rng(0))
    with pytest.raises(LidarDraftError, match=r"chance is 1\.5; the share of rays lost by chance must be 0 to 1"):
        drop(image, Surface.of(image, layout), np.random.default_rng(0), chance=1.5)
