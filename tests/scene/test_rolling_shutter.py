"""Scans with a pose for each column, of a sensor that moves while it sweeps."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from strategies import layouts, poses, sensors

from lidardraft.errors import LayoutError, SensorError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.pose import rotations, upright
from lidardraft.scene.raycast import Raycaster, raycast
from lidardraft.scene.sensor import Sensor

SENSOR = Sensor(name="small", elevations=tuple(np.linspace(0.1, -0.4, 16)), columns=64, max_range=100.0)
ROOM = Layout((Primitive(shape="box", center=(3, -2, 1), size=(40, 30, 12), label="building", id="room"),))
VELOCITY, TURN = (20.0, -3.0, 0.5), (0.2, -0.1, 1.5)


@settings(max_examples=25, deadline=None)
@given(layouts(), sensors(), poses())
def test_a_sensor_that_stands_still_scans_as_ever(layout, sensor, pose):
    caster = Raycaster(layout)
    still = caster.scan(sensor, pose, primitive=True)
    rolling = caster.scan(sensor, poses=np.tile(pose, (sensor.columns, 1, 1)), primitive=True)
    for name in ("label", "instance", "primitive"):
        np.testing.assert_array_equal(getattr(rolling, name), getattr(still, name), err_msg=name)
    np.testing.assert_allclose(rolling.depth, still.depth, rtol=1e-5, atol=2e-3)


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


def test_columns_fire_one_after_the_other():
    np.testing.assert_allclose(SENSOR.column_times(), np.arange(64) * 0.1 / 64)


def test_motion_that_cannot_be():
    with pytest.raises(LayoutError, match=r"velocity\[1\] is nan; it must be finite"):
        SENSOR.poses_in_motion(velocity=(0.0, np.nan, 0.0))
    with pytest.raises(LayoutError, match=r"angular_velocity has shape \(2,\); it must be \[3\]"):
        SENSOR.poses_in_motion(angular_velocity=(0.0, 1.0))
    with pytest.raises(LayoutError, match=r"pose has shape \(3, 3\); it must be \[4, 4\]"):
        SENSOR.poses_in_motion(np.eye(3))
    with pytest.raises(SensorError, match=r"small: sweep_time is -0\.1; it must be 0 or more"):
        dataclasses.replace(SENSOR, sweep_time=-0.1)
