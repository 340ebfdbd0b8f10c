"""Incidence from depth images, against that of the caster."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft import Layout, Primitive, RangeImage, Raycaster, Sensor
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.observe_cast import incidence_from_depth

ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road")
SCENE = Layout((
    ROAD,
    Primitive(shape="box", center=(9, 1, 0.8), size=(4, 2, 1.6), yaw=0.4, label="car", id="car_1", instance=1),
    Primitive(shape="box", center=(11, 3, 0.8), size=(4, 2, 1.6), yaw=0.4, label="car", id="car_2", instance=2),
    Primitive(shape="box", center=(20, -8, 4), size=(10, 6, 8), yaw=0.3, label="building", id="house_1"),
    Primitive(shape="box", center=(30, -2, 6), size=(10, 6, 12), yaw=0.3, label="building", id="house_2"),
    Primitive(shape="ellipsoid", center=(8, -4, 2), size=(5, 5, 4), label="vegetation", id="bush"),
))  # fmt: skip


def cast(sensor: Sensor, layout: Layout = SCENE) -> tuple[RangeImage, np.ndarray]:
    image = Raycaster(layout).scan(sensor, incidence=True)
    return image, incidence_from_depth(image.depth, image.label, image.instance, sensor)


SECTOR = replace(Sensor.preset("vlp32c"), name="sector", columns=400, azimuth_start=0.7, azimuth_span=1.4)


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


def test_an_empty_image_has_none() -> None:
    _, found = cast(SECTOR, Layout())
    assert (found == 0).all()
