"""All effects together, each of them switched on or off, and errors."""

from dataclasses import fields, replace

import numpy as np
import pytest
from observed_walls import IDEAL, SENSOR, seen, wall

from lidardraft import Layout, Primitive, raycast
from lidardraft.errors import LayoutError, SensorError
from lidardraft.scene.effects import observe
from lidardraft.scene.intensity_curve import IntensityCurve
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor_model import SensorModel, sub_rays


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
    with pytest.raises(LayoutError, match="ring: material is 'cheese'; it must be one of asphalt, "):
        observe(image, wall(10.0, "cheese"), seed=0)
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
