import math

import numpy as np
import pytest

from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.drafting.picture.road import RoadPlane, corrected_depth
from lidardraft.semantics import BY_NAME

ROAD, CAR = BY_NAME["road"].id, BY_NAME["car"].id
CAMERA = Pinhole.from_hfov(math.radians(60), 300, 200)
HEIGHT = 1.65  # m
PLANE = RoadPlane(level=np.eye(3), height=HEIGHT)


def road() -> tuple[np.ndarray, np.ndarray]:
    """Depth and classes of a flat road, with nothing over the horizon."""
    up = CAMERA.rays(*np.indices((200, 300)))[..., 2]
    depth = np.where(up < -0.02, HEIGHT / np.maximum(-up, 0.02), 0.0)
    return depth, np.where(depth > 0, ROAD, 0)


def test_exact_depth_stays():
    depth, labels = road()
    np.testing.assert_allclose(corrected_depth(depth, labels, CAMERA, PLANE, HEIGHT), depth)


def test_a_patch_that_is_off_is_brought_to_the_plane_and_what_stands_on_it_with_it():
    true, labels = road()
    foot = int(np.argmin(np.abs(true[:, 150] - 10.0)))
    true[foot - 40 : foot, 120:180], labels[foot - 40 : foot, 120:180] = 10.0, CAR
    depth = true * 1.05
    near = (true > 0) & (true < 11)
    better = corrected_depth(depth, labels, CAMERA, PLANE, HEIGHT)
    assert np.abs(better[near] / true[near] - 1).max() < 0.03
    wall = better[foot - 40 : foot, 120:180]
    assert np.ptp(wall) < 0.03 * wall.mean()  # it keeps its shape


@pytest.mark.parametrize("times", [0.8, 1.3])
def test_what_is_far_off_the_plane_is_a_slope(times):
    depth, labels = road()
    np.testing.assert_allclose(corrected_depth(times * depth, labels, CAMERA, PLANE, HEIGHT), times * depth)


def test_far_depth_is_moved_less():
    """A rise of 4 cm looks like depth that is 2.4 % too long, and a rise is the likelier the further away it is."""
    true, labels = road()
    moved = 1 - corrected_depth(1.024 * true, labels, CAMERA, PLANE, HEIGHT) / np.where(true > 0, 1.024 * true, 1)
    near, far = (moved[np.abs(true - depth) < 0.1 * depth].mean() for depth in (6.0, 60.0))
    assert near > 4 * far > 0


def test_without_a_road_nothing_moves():
    depth, labels = road()
    np.testing.assert_allclose(corrected_depth(depth, labels * 0 + CAR, CAMERA, PLANE, HEIGHT), depth)


@pytest.mark.parametrize("unit", [0.3, 2.0, 100.0])
def test_the_unit_of_depth_makes_no_difference(unit):
    true, labels = road()
    depth = 1.024 * true
    metres = corrected_depth(depth, labels, CAMERA, PLANE, HEIGHT)
    plane = RoadPlane(level=np.eye(3), height=HEIGHT / unit)
    np.testing.assert_allclose(corrected_depth(depth / unit, labels, CAMERA, plane, HEIGHT) * unit, metres)
