"""Layouts as sensors at rest and on the move see them; objects that move; processes that were forked."""

import dataclasses
import multiprocessing
import subprocess
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import pytest

from lidardraft.errors import LayoutError, SensorError
from lidardraft.scene.effects import observe
from lidardraft.scene.layout import Layout, Primitive, box_around
from lidardraft.scene.pose import rotations, upright
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Raycaster, raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME

SENSOR = Sensor(name="small", elevations=tuple(np.linspace(0.2, -0.4, 16)), columns=64, max_range=100.0)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(400, 400, 0), label="road", id="road")
CAR = Primitive(shape="box", center=(10, 0, 0.75), size=(4, 2, 1.5), label="car", id="car", instance=7)
BUSH = Primitive(shape="ellipsoid", center=(0, 12, 1.5), size=(4, 4, 3), label="vegetation", id="bush")
POST = Primitive(shape="cylinder", center=(-8, 0, 2), size=(2, 2, 4), label="pole", id="post")


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


def test_meshes_in_any_memory_order_are_cast():
    vertices = np.asfortranarray([[5.0, -1, 0], [5, 1, 0], [5, 0, 3]])
    mesh = Primitive.from_mesh(vertices, np.asfortranarray([[0, 1, 2], [2, 1, 0]]), label="building", id="m")
    assert raycast(Layout(primitives=(mesh,)), SENSOR).valid.any()


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="this system does not list threads")
def test_threads_of_numbers_that_are_no_longer_asked_for_end():
    code = (
        "import os, time\nfrom lidardraft import Layout, Sensor, raycast\n"
        "before = len(os.listdir('/proc/self/task'))\nfor threads in range(2, 31):\n"
        "    raycast(Layout(), Sensor.preset('vlp16'), threads=threads)\nuntil = time.monotonic() + 30\n"
        "while len(os.listdir('/proc/self/task')) > before + 114 and time.monotonic() < until:\n    time.sleep(0.01)\n"
        "print(len(os.listdir('/proc/self/task')) - before)\n"
    )
    left = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert 0 < int(left) <= 114  # those of the last four numbers


ROOM = Layout((Primitive(shape="box", center=(3, -2, 1), size=(40, 30, 12), label="building", id="room"),))
VELOCITY, TURN = (20.0, -3.0, 0.5), (0.2, -0.1, 1.5)


def test_each_column_is_that_of_a_scan_from_its_own_pose():
    moving = SENSOR.poses_in_motion(None, VELOCITY, TURN)
    rolling = raycast(ROOM, SENSOR, poses=moving)
    for column in (0, 17, 32, 63):
        still = raycast(ROOM, SENSOR, moving[column])
        np.testing.assert_allclose(rolling.depth[:, column], still.depth[:, column], rtol=1e-5, atol=2e-3)
    assert (np.abs(rolling.depth - raycast(ROOM, SENSOR).depth).max(axis=0)[[0, -1]] > 0.1).all()


def test_points_brought_to_the_world_lie_on_its_walls():
    moving = SENSOR.poses_in_motion(SENSOR.pose(1.0, 2.0, 0.5), VELOCITY, TURN)
    image = raycast(ROOM, SENSOR, poses=moving)
    assert image.valid.all()
    walls = ROOM.primitives[0]

    def off(points):
        """How far the points are from the walls, in half sizes of the room."""
        return np.abs(np.abs(2 * (points - walls.center) / walls.size).max(axis=1) - 1).max()

    undistorted = image.points(moving)
    assert undistorted.dtype == np.float64
    assert off(undistorted) < 1e-4
    middle = moving[SENSOR.columns // 2]
    assert off(image.points() @ middle[:3, :3].T + middle[:3, 3]) > 0.02


def test_points_in_the_world_agree_with_those_of_the_sensor():
    pose = SENSOR.pose(3.0, -1.0, 0.4)
    image = raycast(ROOM, SENSOR, pose)
    expected = image.points() @ pose[:3, :3].T + pose[:3, 3]
    np.testing.assert_allclose(image.points(np.tile(pose, (64, 1, 1))), expected, atol=1e-5)
    with pytest.raises(LayoutError, match=r"poses has shape \(4, 4\); it must be \[64, 4, 4\]"):
        image.points(pose)


def test_the_pose_given_is_that_of_the_middle_of_the_sweep():
    pose = SENSOR.pose(1.0, 2.0, 0.3)
    moving = SENSOR.poses_in_motion(pose, VELOCITY, TURN)
    assert moving.shape == (64, 4, 4)
    np.testing.assert_allclose(moving[32], pose, atol=1e-15)
    np.testing.assert_allclose(moving[0, :3, 3], pose[:3, 3] - 0.05 * np.array(VELOCITY))
    turned = pose[:3, :3] @ rotations(-0.05 * np.array([TURN]))[0]
    np.testing.assert_allclose(moving[0, :3, :3], turned, atol=1e-15)


def test_a_turn_is_about_the_axes_of_the_sensor():
    standing = upright((0.0, 0.0, 0.0), 0.0)
    standing[:3, :3] = rotations(np.array([[np.pi / 2, 0, 0]]))[0]  # its z axis looks along -y of the world
    moving = dataclasses.replace(SENSOR, sweep_time=1.0).poses_in_motion(standing, angular_velocity=(0, 0, 0.4))
    np.testing.assert_allclose(moving[:, :3, 2], np.tile([0, -1, 0], (64, 1)), atol=1e-15)
    np.testing.assert_allclose(moving[0, :3, 0], [np.cos(0.2), 0, -np.sin(0.2)], atol=1e-15)


def test_a_flash_does_not_move():
    flash = dataclasses.replace(SENSOR, sweep_time=0.0)
    assert not flash.column_times().any()
    still = np.tile(flash.pose(), (64, 1, 1))
    np.testing.assert_array_equal(flash.poses_in_motion(None, VELOCITY, TURN), still)
    np.testing.assert_array_equal(SENSOR.poses_in_motion(), still)


def test_motion_that_cannot_be():
    with pytest.raises(LayoutError, match=r"velocity\[1\] is nan; it must be finite"):
        SENSOR.poses_in_motion(velocity=(0.0, np.nan, 0.0))
    with pytest.raises(LayoutError, match=r"angular_velocity has shape \(2,\); it must be \[3\]"):
        SENSOR.poses_in_motion(angular_velocity=(0.0, 1.0))
    with pytest.raises(LayoutError, match=r"pose has shape \(3, 3\); it must be \[4, 4\]"):
        SENSOR.poses_in_motion(np.eye(3))
    with pytest.raises(SensorError, match=r"small: sweep_time is -0\.1; it must be 0 or more"):
        dataclasses.replace(SENSOR, sweep_time=-0.1)


FINE = Sensor(name="small", elevations=tuple(np.linspace(0.3, -0.4, 24)), columns=128, max_range=100.0)
TURNED = Primitive(shape="box", center=(10, 1, 0.75), size=(4, 2, 1.5), label="car", id="car_1", yaw=0.4, instance=1)
CABIN = dataclasses.replace(TURNED, id="van_2.cabin", center=(-9, 1, 1), size=(2, 2, 2), instance=2)
TRUNK = dataclasses.replace(TURNED, id="van_2.box", center=(-12, 2.2, 1.4), size=(4, 2, 2.8), yaw=0.5, instance=2)
LAYOUT = Layout((ROAD, TURNED, CABIN, TRUNK))


def differing(a, b):
    """Share of the rays that return something else."""
    return np.mean((a.instance != b.instance) | (a.label != b.label) | ~np.isclose(a.depth, b.depth, rtol=1e-4))


@pytest.mark.parametrize(("name", "object"), [("car_1", (TURNED,)), ("van_2", (CABIN, TRUNK)), ("van_2.box", (TRUNK,))])
def test_a_moved_object_is_cast_where_it_stands(name, object):
    box = box_around(object)
    caster = Raycaster(LAYOUT)
    caster.move(name, upright((3.0, 6.0, box.center[2] + 0.2), box.yaw + 1.1))
    moved = {
        part.id: dataclasses.replace(
            part,
            center=tuple(upright((3.0, 6.0, box.center[2] + 0.2), 1.1) @ [*(np.subtract(part.center, box.center)), 1])[
                :3
            ],
            yaw=part.yaw + 1.1,
        )
        for part in object
    }
    there = Layout(tuple(moved.get(part.id, part) for part in LAYOUT))
    assert differing(caster.scan(FINE), raycast(LAYOUT, FINE)) > 0.01
    assert differing(caster.scan(FINE), raycast(there, FINE)) < 0.001


def test_only_the_thing_that_moved_has_moved():
    caster, before = Raycaster(LAYOUT), raycast(LAYOUT, FINE)
    caster.move("car_1", upright((0.0, 0.0, 60.0), 0.0))
    after = caster.scan(FINE)
    others = before.instance != 1
    np.testing.assert_array_equal(after.instance[others], before.instance[others])
    np.testing.assert_array_equal(after.depth[others], before.depth[others])
    assert not (after.instance == 1).any()
    assert (before.instance == 1).any()
    assert caster.layout == LAYOUT


def test_a_name_of_parts_is_the_object_before_it_is_a_part():
    base = dataclasses.replace(TURNED, id="car_1", center=(10, 1, 0.5), size=(4, 2, 1))
    roof = dataclasses.replace(TURNED, id="car_1.roof", center=(10, 1, 1.25), size=(2, 2, 0.5))
    caster = Raycaster(Layout((base, roof)))
    caster.move("car_1", upright((0.0, 0.0, 60.0), 0.0))
    assert not caster.scan(FINE).valid.any()


@pytest.mark.parametrize(
    ("id", "pose", "message"),
    [
        ("car_9", np.eye(4), r"no primitive has the id 'car_9'; did you mean 'car_1'\?$"),
        ("car_1", np.eye(3), r"pose has shape \(3, 3\); it must be \[4, 4\]"),
        ("car_1", np.full((4, 4), np.nan), r"pose\[0, 0\] is nan; it must be finite"),
        ("car_1", np.diag([2.0, 2, 2, 1]), r"world_from_primitive\[0\]: .*R\^T R"),
        ("van_2", np.diag([1.0, -1, 1, 1]), r"world_from_primitive\[0\]: .*mirror"),
        ("van_2", np.diag([1.0, 1, 1, 2]), r"world_from_primitive\[0\]: the last row"),
    ],
)
def test_moves_that_cannot_be_change_nothing(id, pose, message):
    caster = Raycaster(LAYOUT)
    with pytest.raises(LayoutError, match=message):
        caster.move(id, pose)
    np.testing.assert_array_equal(caster.scan(FINE).depth, raycast(LAYOUT, FINE).depth)
    with pytest.raises(LayoutError, match="no primitive has the id 'car_1'; it has none"):
        Raycaster(Layout()).move("car_1", np.eye(4))


HOUSE = Layout((Primitive(shape="box", center=(8, 0, 0), size=(2, 9, 6), label="building", id="house"),))
CASTER = Raycaster(HOUSE)
VLP16 = Sensor.preset("vlp16")


def scan(threads: int | None) -> np.ndarray:
    return CASTER.scan(VLP16, threads=threads).depth


def scan_batch(threads: int | None) -> np.ndarray:
    return CASTER.scan_batch(VLP16, np.stack([VLP16.pose()] * 4), threads=threads).depth


def cast(threads: int | None) -> np.ndarray:
    directions = np.stack([np.ones(5000), np.linspace(-1, 1, 5000), np.zeros(5000)], axis=-1)
    return CASTER.cast(np.zeros((5000, 3)), directions, threads=threads).distance


def observed(threads: int | None) -> np.ndarray:
    clean = CASTER.scan(VLP16, primitive=True, incidence=True, threads=threads)
    return observe(clean, HOUSE, seed=0, threads=threads).depth


def projected(_: int | None) -> np.ndarray:
    points = np.stack([np.full(9000, 9.0), np.linspace(-9, 9, 9000), np.zeros(9000)], axis=-1)
    return RangeImage.project(points, VLP16).depth


def send(pipe: Connection, work: Callable[[int | None], np.ndarray], threads: int | None) -> None:
    pipe.send(work(threads))


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="this system has no fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")  # Python from 3.12 on warns of what is tried here
@pytest.mark.parametrize("threads", [2, None])
@pytest.mark.parametrize("work", [scan, scan_batch, cast, observed, projected])
def test_a_forked_child_does_what_its_parent_did(work: Callable[[int | None], np.ndarray], threads: int | None):
    for before in (threads, 2):
        expected = work(before)
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(target=send, args=(theirs, work, threads), daemon=True)
    child.start()
    try:
        assert ours.poll(60), "the child hangs"
        np.testing.assert_array_equal(ours.recv(), expected)
    finally:
        child.kill()
        child.join()
    np.testing.assert_array_equal(work(2), expected)
