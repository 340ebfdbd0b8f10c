"""Casts of other renderers: their labels stay, and what a sensor does to light is added."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lidardraft import Layout, Primitive, RangeImage, Raycaster, Sensor, observe_cast, observe_points
from lidardraft.errors import LayoutError, LidarDraftError, SensorError
from lidardraft.scene.effects import observe
from lidardraft.scene.materials import MATERIALS
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.observe_cast import incidence_from_depth

SENSOR = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(8, -24, 24)).tolist()), columns=256)
LAYOUT = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road"),
    Primitive(shape="box", center=(9, 1, 0.8), size=(4, 2, 1.5), label="car", id="car_4", instance=4),
    Primitive(shape="box", center=(9, -6, 0.8), size=(4, 2, 1.5), label="car", id="car_7", instance=7),
    Primitive(shape="box", center=(25, 0, 4), size=(6, 40, 8), label="building", id="house_1"),
    Primitive(shape="ellipsoid", center=(-9, 4, 2), size=(5, 5, 4), label="vegetation", id="bush", extinction=9.0),
))  # fmt: skip
CAST = Raycaster(LAYOUT).scan(SENSOR, incidence=True, primitive=True)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road")
SCENE = Layout((
    ROAD,
    Primitive(shape="box", center=(9, 1, 0.8), size=(4, 2, 1.6), yaw=0.4, label="car", id="car_1", instance=1),
    Primitive(shape="box", center=(11, 3, 0.8), size=(4, 2, 1.6), yaw=0.4, label="car", id="car_2", instance=2),
    Primitive(shape="box", center=(20, -8, 4), size=(10, 6, 8), yaw=0.3, label="building", id="house_1"),
    Primitive(shape="box", center=(30, -2, 6), size=(10, 6, 12), yaw=0.3, label="building", id="house_2"),
    Primitive(shape="ellipsoid", center=(8, -4, 2), size=(5, 5, 4), label="vegetation", id="bush"),
))  # fmt: skip
SECTOR = replace(Sensor.preset("vlp32c"), name="sector", columns=400, azimuth_start=0.7, azimuth_span=1.4)


def observed(sensor: Sensor = SENSOR, **changes: Any) -> RangeImage:
    """The cast, observed; `changes` take the place of its images or are options."""
    given: dict[str, Any] = {"depth": CAST.depth, "label": CAST.label, "instance": CAST.instance} | changes
    return observe_cast(given.pop("depth"), given.pop("label"), sensor, **given)


def test_every_return_keeps_its_label_and_instance() -> None:
    scan = observed()
    assert 0.9 < scan.valid.sum() / CAST.valid.sum() < 1.0
    assert not (scan.valid & ~CAST.valid).any()
    for name in ("label", "instance"):
        np.testing.assert_array_equal(getattr(scan, name), np.where(scan.valid, getattr(CAST, name), 0))
    assert np.abs(scan.depth - CAST.depth)[scan.valid].max() < 1.0
    assert scan.intensity.max() > 0.1
    assert (scan.intensity[~scan.valid] == 0).all()


def test_it_is_what_observe_makes_of_the_same_surfaces() -> None:
    model = replace(SensorModel(), material_noise=False)
    materials = [replace(p, material={"car": "dark-paint", "building": "brick"}.get(p.label)) for p in LAYOUT]
    surfaces = Surfaces.from_layout(Layout(tuple(materials)), variation=False)
    expected = observe(CAST, surfaces, seed=5, model=model)
    scan = observed(
        instance=None,  # which have a variation
        incidence=CAST.incidence,
        materials={"car": "dark-paint", "building": "brick"},
        model=model,
        seed=5,
    )
    for name in ("depth", "label", "intensity", "incidence"):
        np.testing.assert_array_equal(getattr(scan, name), getattr(expected, name), err_msg=name)


def test_incidence_that_is_not_given_is_that_of_the_normals() -> None:
    given, found = observed(incidence=CAST.incidence), observed()
    both = given.valid & found.valid
    assert np.quantile(np.abs(given.incidence - found.incidence)[both], 0.95) < 0.01
    assert (given.valid == found.valid).mean() > 0.99
    # of leaves there is none
    leaves = found.label == BY_NAME["vegetation"].id
    assert (found.incidence[leaves] == 1).all()


def test_materials_are_those_of_classes_or_of_pixels() -> None:
    cars = CAST.label == BY_NAME["car"].id
    names = [material.name for material in MATERIALS]
    image = np.where(cars, names.index("retroreflector"), -1)
    by_class, by_pixel = observed(materials={"car": "retroreflector"}), observed(materials=image)
    np.testing.assert_array_equal(by_class.intensity, by_pixel.intensity)
    usual = observed()
    np.testing.assert_array_equal(by_class.intensity[~cars], usual.intensity[~cars])
    assert by_class.intensity[cars].mean() > 2 * usual.intensity[cars].mean()


def test_objects_of_one_class_differ_and_keep_their_looks() -> None:
    sensor, ideal = SENSOR, SensorModel.ideal()
    facing = np.ones(sensor.shape)
    scans = [observed(incidence=facing, model=replace(ideal, full_scale=9.0), seed=seed) for seed in (0, 1)]
    brightness = [[scan.intensity[scan.instance == number].mean() for number in (4, 7)] for scan in scans]
    assert brightness[0] == brightness[1]
    assert brightness[0][0] != brightness[0][1]


def test_weather_returns_are_of_nothing() -> None:
    scan = observed(weather=Weather(visibility=30.0, wetness=1.0))
    fog = scan.valid & (scan.label == 0)
    assert fog.any()
    assert (scan.instance[fog] == 0).all()
    kept = scan.valid & ~fog
    np.testing.assert_array_equal(scan.label[kept], CAST.label[kept])


def test_what_is_out_of_range_or_blocked_is_dropped() -> None:
    near = replace(SENSOR, max_range=12.0, min_range=6.0, range_sigma=0.0)
    depth = observed(near, model=SensorModel.ideal()).depth
    clean = np.where((CAST.depth >= 6.0) & (CAST.depth <= 12.0), CAST.depth, 0.0)
    np.testing.assert_array_equal(depth, clean)
    blocked = replace(SENSOR, blocked=(((-0.5, 0.5),),) * 24)
    seen = observed(blocked).valid
    assert not seen[:, 110:146].any()
    assert seen.any()


def test_points_are_observed_in_their_pixels() -> None:
    order = np.random.default_rng(0).permutation(CAST.valid.sum())
    given = {"instance": CAST.instance, "incidence": CAST.incidence}
    columns = {name: image[CAST.valid][order] for name, image in given.items()}
    materials = np.full(len(order), -1)
    scan = observe_points(
        CAST.points()[order], CAST.label[CAST.valid][order], SENSOR, materials=materials, seed=3, **columns
    )
    expected = observed(seed=3, **given)
    for name in ("label", "instance"):
        np.testing.assert_array_equal(getattr(scan, name), getattr(expected, name))
    np.testing.assert_allclose(scan.depth, expected.depth, atol=1e-4)


def test_points_of_another_sensor_are_a_warning() -> None:
    other = replace(SENSOR, elevations=tuple(np.deg2rad(np.linspace(2, -3, 8)).tolist()))
    with pytest.warns(UserWarning, match=r"\d\d% of the points have no pixel of small of their own"):
        observe_points(CAST.points(), CAST.label[CAST.valid], other)


def test_a_flat_mirror_is_seen_from_the_front_alone() -> None:
    few = Sensor(name="few", elevations=(0.02, -0.05, -0.2), columns=90)
    depth, label = np.full((3, 90), 8.0), np.full((3, 90), BY_NAME["building"].id)
    scan = observe_cast(depth, label, few, incidence=np.full((3, 90), -math.cos(0.3)))
    assert scan.valid.mean() > 0.95
    np.testing.assert_allclose(scan.incidence[scan.valid], math.cos(0.3), rtol=1e-6)


def test_lists_and_any_type_of_whole_numbers_are_images() -> None:
    expected = observed(materials=np.zeros(SENSOR.shape, int))
    for given in ({"instance": CAST.instance.astype(np.uint64)}, {"materials": np.zeros(SENSOR.shape, int).tolist()}):
        scan = observed(**{"materials": np.zeros(SENSOR.shape, int)} | given)
        np.testing.assert_array_equal(scan.depth, expected.depth)
        np.testing.assert_array_equal(scan.instance, expected.instance)


def at(image: np.ndarray, value: float) -> np.ndarray:
    """The image with a value in row 3, column 7."""
    changed = image.astype(np.float64 if isinstance(value, float) else np.int64)
    changed[3, 7] = value
    return changed


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"depth": at(CAST.depth, np.nan)}, "depth is nan in row 3, column 7; it must be 0 or more"),
        ({"depth": at(CAST.depth, np.inf)}, "depth is inf in row 3, column 7; it must be 0 or more, and 0 where there"),
        ({"depth": at(CAST.depth, -1.0)}, "depth is -1.0 in row 3, column 7"),
        ({"depth": CAST.depth[1:]}, r"depth has shape \(23, 256\); the sensor's images have \(24, 256\)"),
        ({"depth": CAST.depth.astype(str)}, "depth is <U32; it must hold numbers"),
        ({"label": at(CAST.label, 252)}, "label is 252 in row 3, column 7; ids of CLASSES are 0 to 20"),
        ({"label": at(CAST.label, -1)}, "label is -1 in row 3"),
        ({"label": CAST.label * 1.0}, "label is float64; it must hold whole numbers"),
        ({"instance": at(CAST.instance, -1)}, "instance is -1 in row 3, column 7; it must be 0 to 4294967295"),
        ({"incidence": at(CAST.incidence, 57.0)}, "incidence is 57.0 in row 3, column 7; a cosine is -1 to 1"),
        ({"materials": {"carr": "metal"}}, "materials names the class 'carr'; it must be .*; did you mean 'car'?"),
        ({"materials": {"car": "cheese"}}, "the material of car is 'cheese'; it must be one of asphalt, "),
        ({"materials": np.full(SENSOR.shape, 99)}, "materials is 99 in row 0, column 0; it must be -1 to 29"),
        ({"depth": [[1.0, 2.0], [3.0]]}, "depth is no array; the sensor's images have"),
        ({"seed": -1}, "seed is -1; it must be an integer of 0 to 2"),
    ],
)
def test_bad_input_is_one_line(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(LidarDraftError, match=message):
        observed(**changes)


def test_points_that_cannot_be_are_one_line() -> None:
    points, label = CAST.points(), CAST.label[CAST.valid]
    with pytest.raises(LayoutError, match=r"points have shape \(3,\); they must be \[N, 3\]"):
        observe_points(points[0], label, SENSOR)
    with pytest.raises(LayoutError, match="label has shape"):
        observe_points(points, label[1:], SENSOR)
    with pytest.raises(SensorError, match="label is 99 in row"):
        observe_points(points, np.full(len(points), 99), SENSOR)


def cast(sensor: Sensor, layout: Layout = SCENE) -> tuple[RangeImage, np.ndarray]:
    image = Raycaster(layout).scan(sensor, incidence=True)
    return image, incidence_from_depth(image.depth, image.label, image.instance, sensor)


@pytest.mark.parametrize("sensor", [*map(Sensor.preset, ("hdl64e", "vlp32c", "os1-128")), SECTOR], ids=lambda s: s.name)
def test_it_is_that_of_the_caster_but_at_a_few_edges(sensor: Sensor) -> None:
    image, found = cast(sensor)
    assert found.dtype == np.float32
    assert (found[~image.valid] == 0).all()
    off = np.abs(found - image.incidence)
    flat = image.valid & (image.label != BY_NAME["vegetation"].id)
    assert np.quantile(off[flat], 0.97) < 0.01
    assert off[flat].mean() < 0.01
    assert off[image.valid & ~flat].mean() < 0.1


def test_edges_between_objects_of_one_class_are_no_slopes() -> None:
    image, found = cast(Sensor.preset("os1-128"))
    cars = image.label == BY_NAME["car"].id
    edge = cars & (np.roll(image.instance, 1, axis=1) != image.instance)
    assert edge.sum() > 20
    assert np.quantile(np.abs(found - image.incidence)[edge], 0.9) < 0.05
    # houses have no instance: only their depths tell them apart
    houses = image.label == BY_NAME["building"].id
    jump = houses & np.roll(houses, 1, axis=1) & (np.abs(np.roll(image.depth, 1, axis=1) - image.depth) > 2.0)
    assert jump.sum() > 5
    assert np.median(np.abs(found - image.incidence)[jump]) < 0.01


def test_what_is_one_pixel_wide_faces_the_sensor_and_the_ground_is_level() -> None:
    few = Sensor(name="few", elevations=(0.01, -0.2), columns=360)
    pole = Primitive(shape="cylinder", center=(20, 0.17, 2), size=(0.2, 0.2, 4), label="pole", id="pole")
    image, found = cast(few, Layout((ROAD, pole)))
    on_pole = image.label == BY_NAME["pole"].id
    assert 1 <= on_pole.sum() <= 3
    assert (found[on_pole] > 0.99).all()
    ground = image.label == BY_NAME["road"].id
    np.testing.assert_allclose(found[ground], math.sin(0.2), atol=1e-3)


@pytest.mark.filterwarnings("error")
def test_a_single_beam_has_neighbours_in_its_row_alone() -> None:
    one = Sensor(name="one", elevations=(-0.1,), columns=360)
    image, found = cast(one, Layout((ROAD,)))
    np.testing.assert_allclose(found, math.sin(0.1), atol=1e-3)
    assert image.valid.all()
