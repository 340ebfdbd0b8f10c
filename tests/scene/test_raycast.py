import dataclasses
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.errors import LayoutError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import Raycaster, raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME

SENSOR = Sensor(name="small", elevations=tuple(np.linspace(0.2, -0.4, 16)), columns=64, max_range=100.0)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(400, 400, 0), label="road", id="road")
CAR = Primitive(shape="box", center=(10, 0, 0.75), size=(4, 2, 1.5), label="car", id="car", instance=7)
BUSH = Primitive(shape="ellipsoid", center=(0, 12, 1.5), size=(4, 4, 3), label="vegetation", id="bush")
POST = Primitive(shape="cylinder", center=(-8, 0, 2), size=(2, 2, 4), label="pole", id="post")


def test_an_empty_layout_returns_nothing():
    image = raycast(Layout(), SENSOR, primitive=True)
    assert not image.valid.any()
    assert not image.label.any()
    assert not image.instance.any()
    assert (image.primitive == -1).all()


def test_a_flat_road_is_where_trigonometry_says():
    image = raycast(Layout(primitives=(ROAD,)), SENSOR, incidence=True)
    down = np.sin(-np.array(SENSOR.elevations))[:, None].repeat(64, axis=1)
    with np.errstate(divide="ignore"):
        expected = np.where(down > 0, SENSOR.mount_height / down, 0)
    expected[expected > SENSOR.max_range] = 0
    np.testing.assert_allclose(image.depth, expected, rtol=1e-5)
    np.testing.assert_allclose(image.incidence[image.valid], down[image.valid], rtol=1e-4)


def test_each_pixel_says_what_it_hit():
    layout = Layout(primitives=(ROAD, CAR, BUSH, POST))
    image = raycast(layout, SENSOR, primitive=True)
    for index, primitive in enumerate(layout):
        hit = image.primitive == index
        assert hit.any()
        assert (image.label[hit] == BY_NAME[primitive.label].id).all()
        assert (image.instance[hit] == primitive.instance).all()


def test_points_lie_on_the_surfaces():
    layout = Layout(primitives=(CAR, BUSH, POST))
    image = raycast(layout, SENSOR, primitive=True)
    points = image.points().astype(np.float64) + np.array([0, 0, SENSOR.mount_height])
    which = image.primitive[image.valid]
    unit = [2 * (points[which == k] - p.center) / p.size for k, p in enumerate(layout)]
    np.testing.assert_allclose(np.abs(unit[0]).max(axis=1), 1, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(unit[1], axis=1), 1, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(unit[2][:, :2], axis=1), 1, atol=1e-4)


@settings(max_examples=10, deadline=None)
@given(columns=st.integers(-64, 64))
def test_turning_the_sensor_by_columns_rolls_the_image(columns):
    caster = Raycaster(Layout(primitives=(ROAD, CAR, BUSH, POST)))
    still = caster.scan(SENSOR)
    turned = caster.scan(SENSOR, SENSOR.pose(yaw=columns * 2 * math.pi / 64))
    # A ray on the rim of a shape may fall to either side of it.
    same = np.isclose(turned.depth, np.roll(still.depth, columns, axis=1), rtol=1e-4)
    assert same.mean() > 0.99


def test_moving_world_and_sensor_together_changes_nothing():
    layout = Layout(primitives=(ROAD, CAR, BUSH))
    moved = Layout(
        primitives=tuple(dataclasses.replace(p, center=(p.center[0] + 8, p.center[1] - 4, p.center[2])) for p in layout)
    )
    still, image = raycast(layout, SENSOR), raycast(moved, SENSOR, SENSOR.pose(8, -4))
    assert np.isclose(still.depth, image.depth, rtol=1e-4).mean() > 0.99


def test_a_box_and_its_mesh_look_alike():
    corners = np.array([[x, y, z] for x in (8.0, 12.0) for y in (-1.0, 1.0) for z in (0.0, 1.5)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))])
    mesh = Primitive.from_mesh(corners, faces, label="car", id="car", instance=7)
    box, other = raycast(Layout(primitives=(CAR,)), SENSOR), raycast(Layout(primitives=(mesh,)), SENSOR)
    np.testing.assert_allclose(box.depth, other.depth, rtol=1e-5)
    np.testing.assert_array_equal(box.instance, other.instance)


def test_meshes_in_any_memory_order_are_cast():
    vertices = np.asfortranarray([[5.0, -1, 0], [5, 1, 0], [5, 0, 3]])
    mesh = Primitive.from_mesh(vertices, np.asfortranarray([[0, 1, 2], [2, 1, 0]]), label="building", id="m")
    assert raycast(Layout(primitives=(mesh,)), SENSOR).valid.any()


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (np.eye(3), r"pose has shape \(3, 3\); it must be \[4, 4\]"),
        (2 * np.eye(4), "rigid|rotation|pose|world_from_sensor"),
        (np.full((4, 4), np.nan), "finite|rigid|pose|world_from_sensor"),
        (np.diag([1.0, -1, 1, 1]), "rigid|rotation|pose|world_from_sensor"),
    ],
)
def test_a_pose_that_is_not_rigid(pose, message):
    with pytest.raises(LayoutError, match=message):
        raycast(Layout(primitives=(ROAD,)), SENSOR, pose)


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="this system does not list threads")
def test_threads_of_numbers_that_are_no_longer_asked_for_end():
    code = (
        "import os, time\n"
        "from lidardraft import Layout, Sensor, raycast\n"
        "before = len(os.listdir('/proc/self/task'))\n"
        "for threads in range(2, 31):\n"
        "    raycast(Layout(), Sensor.preset('vlp16'), threads=threads)\n"
        "until = time.monotonic() + 30\n"
        "while len(os.listdir('/proc/self/task')) > before + 114 and time.monotonic() < until:\n"
        "    time.sleep(0.01)\n"
        "print(len(os.listdir('/proc/self/task')) - before)\n"
    )
    left = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert 0 < int(left) <= 114  # those of the last four numbers
