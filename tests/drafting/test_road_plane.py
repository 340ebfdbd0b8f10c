import math

import numpy as np
import pytest

from lidardraft.drafting.picture.road import find_road_plane
from lidardraft.errors import LayoutError
from lidardraft.semantics import BY_NAME

ROAD, TERRAIN, CAR = (BY_NAME[name].id for name in ("road", "terrain", "car"))


def ground(height=1.65, number=2000, seed=0):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(4, 40, number), rng.uniform(-8, 8, number), np.full(number, -height)])


def tilted(points, pitch, roll):
    """The points as a camera sees them that is turned down by `pitch` and to the right by `roll`."""
    cp, sp, cr, sr = math.cos(pitch), math.sin(pitch), math.cos(roll), math.sin(roll)
    return points @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]) @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (0.2, 0.0), (-0.15, 0.05), (0.3, -0.2)])
def test_height_and_tilt_are_found_among_points_that_are_wrong(pitch, roll):
    rng = np.random.default_rng(1)
    points = ground() + rng.normal(0, 0.01, (2000, 3))
    points[:500] += rng.uniform(0, 3, (500, 3))  # a quarter lies elsewhere
    plane = find_road_plane(tilted(points, pitch, roll), np.full(2000, ROAD))
    assert plane.height == pytest.approx(1.65, abs=0.02)
    np.testing.assert_allclose(plane.level @ plane.level.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(plane.level) == pytest.approx(1)
    level = tilted(points, pitch, roll) @ plane.level.T
    np.testing.assert_allclose(level[500:, 2], -1.65, atol=0.06)
    ahead = tilted(np.array([[1.0, 0, 0]]), 0, 0) @ plane.level.T  # the axis of the camera stays ahead
    assert abs(ahead[0, 1]) < 1e-9


def test_the_scale_of_the_points_is_the_scale_of_the_height():
    one, other = (find_road_plane(scale * ground(), np.full(2000, ROAD)) for scale in (1.0, 30.0))
    assert other.height == pytest.approx(30 * one.height)


def test_the_road_counts_before_the_grass_beside_it():
    grass = ground(1.2, 3000)
    points = np.concatenate([ground(1.65, 400), grass])
    labels = np.repeat([ROAD, TERRAIN], [400, 3000])
    assert find_road_plane(points, labels).height == pytest.approx(1.65)
    assert find_road_plane(points[100 + 300 :], labels[400:]).height == pytest.approx(1.2)


def test_no_ground_is_said():
    with pytest.raises(
        LayoutError, match="no ground is visible: 0 points of the picture are road, sidewalk or terrain"
    ):
        find_road_plane(ground(), np.full(2000, CAR))


def test_a_ground_that_is_no_plane_is_said():
    points = np.random.default_rng(0).uniform((2, -20, -9), (40, 20, 0), (2000, 3))
    with pytest.raises(
        LayoutError, match=r"no plane of the ground is found: .* of 2000 points of the ground lie on one"
    ):
        find_road_plane(points, np.full(2000, ROAD))


def test_a_picture_upside_down_is_said():
    with pytest.raises(LayoutError, match="is the depth metric, and the picture upright"):
        find_road_plane(ground() * (1, -1, -1), np.full(2000, ROAD))


def test_all_points_at_one_place():
    with pytest.raises(LayoutError, match="no plane of the ground"):
        find_road_plane(np.ones((300, 3)), np.full(300, ROAD))
