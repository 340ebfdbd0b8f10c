import dataclasses

import numpy as np
import pytest

from lidardraft.diffusion.top_view import FAR, NEAR, top_view
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME

SENSOR = Sensor(name="small", elevations=tuple(np.linspace(0.05, -0.4, 16).tolist()), columns=128)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road")
TOWER = Primitive(shape="box", center=(12, 0, 20), size=(6, 6, 40), label="building", id="tower")
CAR = Primitive(shape="box", center=(0, 8, 0.75), size=(2, 4, 1.5), label="car", id="car", instance=1)


def test_a_pixel_is_the_surface_below_its_place() -> None:
    image = top_view(Layout(primitives=(ROAD, TOWER, CAR)), SENSOR, SENSOR.pose())
    distance = np.geomspace(FAR, NEAR, 16)
    azimuth = SENSOR.azimuth_start - (np.arange(128) + 0.5) * SENSOR.azimuth_span / 128
    x, y = distance[:, None] * np.cos(azimuth), distance[:, None] * np.sin(azimuth)
    expected = np.full(SENSOR.shape, BY_NAME["road"].id)
    expected[(abs(x - 12) < 3) & (abs(y) < 3)] = BY_NAME["building"].id
    expected[(abs(x) < 1) & (abs(y - 8) < 2)] = BY_NAME["car"].id
    assert len(np.unique(expected)) == 3
    np.testing.assert_array_equal(image.label, expected)
    depths = {name: np.unique(image.depth[image.label == BY_NAME[name].id]) for name in ("road", "car", "building")}
    assert depths["road"] == pytest.approx([12 + SENSOR.mount_height], abs=1e-3)
    assert depths["car"] == pytest.approx([12 + SENSOR.mount_height - 1.5], abs=1e-3)
    assert depths["building"] == pytest.approx([0.1])  # higher than the ceiling


def test_the_view_turns_and_moves_with_the_sensor() -> None:
    layout = Layout(primitives=(ROAD, CAR))
    here = top_view(layout, SENSOR, SENSOR.pose())
    turned = top_view(layout, SENSOR, SENSOR.pose(yaw=np.pi / 2))
    # to the left of a sensor that looks along x is ahead of one that looks along y
    np.testing.assert_array_equal(np.roll(here.label, 32, axis=1), turned.label)
    away = dataclasses.replace(CAR, center=(50, 8, 0.75))
    moved = top_view(Layout(primitives=(ROAD, away)), SENSOR, SENSOR.pose(x=50))
    np.testing.assert_array_equal(moved.label, here.label)


def test_where_nothing_is_there_is_no_return() -> None:
    image = top_view(Layout(primitives=(CAR,)), SENSOR, SENSOR.pose())
    assert set(np.unique(image.label)) == {0, BY_NAME["car"].id}
    assert not image.valid[image.label == 0].any()
