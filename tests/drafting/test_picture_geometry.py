"""Pictures: cameras, points, and the plane of the road."""

import math

import numpy as np
import pytest

from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.drafting.picture.points import pseudo_cloud
from lidardraft.drafting.picture.road import RoadPlane, corrected_depth, find_road_plane
from lidardraft.errors import LayoutError
from lidardraft.semantics import BY_NAME

K = np.array([[700.0, 0, 400], [0, 710.0, 300], [0, 0, 1]])


def test_rays_of_a_matrix_worked_out_by_hand():
    camera = Pinhole.from_matrix(K, 800, 600)
    rays = camera.rays(np.array([300, 300, 371]), np.array([400, 470, 400]))
    np.testing.assert_allclose(rays, [(1, 0, 0), (1, -0.1, 0), (1, 0, -0.1)])


def test_a_resized_picture_has_the_same_edges():
    camera = Pinhole.from_matrix(K, 800, 600)
    small = camera.resized(200, 100)
    for whole, part in (((-0.5, -0.5), (-0.5, -0.5)), ((599.5, 799.5), (99.5, 199.5))):
        np.testing.assert_allclose(camera.rays(*map(np.array, whole)), small.rays(*map(np.array, part)))


def test_intrinsics_come_in_three_forms():
    projection = np.column_stack([K, [44.0, 0.2, 0.0]])
    camera = Pinhole.from_matrix(K, 800, 600)
    assert Pinhole.from_matrix(projection, 800, 600) == Pinhole.from_matrix((700, 710, 400, 300), 800, 600) == camera


@pytest.mark.parametrize(
    ("intrinsics", "said"),
    [
        ((700, 710, 400), r"shape \(3,\)"),
        ("K", "shape"),
        (None, "shape"),
        ((700, -1, 400, 300), "fx and fy greater than 0"),
        ((700, math.nan, 400, 300), "must be finite"),
        ((700, 700, 900, 300), r"principal point \(900, 300\) lies outside the picture of 800 x 600"),
        ((20, 20, 400, 300), "fx is 20 pixels, so 800 pixels are 174 degrees; a pinhole sees 5 to 170"),
        ((20000, 20000, 400, 300), "a pinhole sees 5 to 170"),
    ],
)
def test_intrinsics_that_cannot_be(intrinsics, said):
    with pytest.raises(LayoutError, match=said):
        Pinhole.from_matrix(intrinsics, 800, 600)


@pytest.mark.parametrize("degrees", [0, -80, 200, 175, 1, math.nan, math.inf])
def test_fields_of_view_that_cannot_be(degrees):
    with pytest.raises(LayoutError, match=r"hfov is .*a pinhole sees 5 to 170 degrees"):
        Pinhole.from_hfov(math.radians(degrees), 800, 600)


ROAD, TERRAIN, CAR, POLE, BUILDING = (BY_NAME[name].id for name in ("road", "terrain", "car", "pole", "building"))
FINE_CAMERA = Pinhole.from_hfov(math.radians(8), 100, 60)  # a pixel is one cell
NONE = np.zeros((60, 100), dtype=np.int64)


def test_what_has_no_depth_or_no_class_has_no_point():
    depth, labels = np.full((60, 100), 10.0), NONE + BUILDING
    depth[:30], labels[:, :50] = 0, 0
    cloud = pseudo_cloud(depth, labels, NONE, FINE_CAMERA)
    assert len(cloud.points) == 30 * 50
    assert cloud.points[:, 1].max() < 0.05
    assert cloud.points[:, 2].max() < 0


def test_a_fine_picture_is_thinned_and_a_sparse_one_keeps_what_it_has():
    camera = FINE_CAMERA.resized(400, 240)
    dense = pseudo_cloud(np.full((240, 400), 10.0), np.full((240, 400), BUILDING), np.zeros((240, 400), int), camera)
    assert len(dense.points) == 60 * 100
    sparse = np.zeros((240, 400))
    rows, columns = np.indices((60, 100)) * 4 + np.random.default_rng(0).integers(0, 4, (2, 60, 100))
    sparse[rows, columns] = 10.0
    kept = pseudo_cloud(sparse, np.full((240, 400), BUILDING), np.zeros((240, 400), int), camera)
    assert len(kept.points) == 60 * 100


def test_a_smooth_edge_leaves_nothing_between_two_surfaces():
    depth = np.full((60, 100), 10.0)
    depth[:, 50:] = 30
    depth[:, 47:53] = np.geomspace(10, 30, 6)
    labels = NONE + BUILDING
    cloud = pseudo_cloud(depth, labels, NONE, FINE_CAMERA)
    between = (cloud.points[:, 0] > 13) & (cloud.points[:, 0] < 25)
    assert not between.any()
    assert (cloud.points[:, 0] == 10).sum() > 60 * 40
    assert (cloud.points[:, 0] == 30).sum() > 60 * 40


def test_a_road_is_kept_however_flat_it_is_seen():
    rows = np.arange(60) + 1.0
    depth = np.broadcast_to((1.65 * FINE_CAMERA.fx / rows)[:, None], (60, 100))
    assert len(pseudo_cloud(depth, NONE + ROAD, NONE, FINE_CAMERA).points) == 6000


def test_a_class_that_reaches_over_the_edge_of_its_object_is_cut():
    depth, labels = np.full((60, 100), 30.0), NONE + BUILDING
    depth[20:40, 30:60] = 10
    labels[18:42, 28:62] = CAR  # two pixels too wide
    cloud = pseudo_cloud(depth, labels, NONE, FINE_CAMERA)
    cars = cloud.points[cloud.labels == CAR]
    assert len(cars) >= 20 * 30
    assert (
        cars[:, 0] > 20
    ).sum() <= 4 * 2 * 2  # the corners, from where the object is straight neither across nor down


def test_the_last_rows_of_a_roof_seen_at_a_flat_angle_are_left_out():
    """They would be an object of their own; the rows of a wall, and one row alone, are kept."""
    depth, labels = np.full((60, 100), 30.0), NONE + BUILDING
    depth[30:40, 20:40], labels[30:40, 20:40] = 10, CAR
    depth[29, 20:40], labels[29, 20:40] = 10.8, CAR
    depth[50, 20:40], labels[50, 20:40] = 10, CAR
    cloud = pseudo_cloud(depth, labels, NONE, FINE_CAMERA)
    cars = cloud.points[cloud.labels == CAR]
    assert set(cars[:, 0]) == {10.0}
    assert len(cars) == 11 * 20


def test_a_thin_object_before_another_class_is_kept_whole():
    depth, labels = np.full((60, 100), 30.0), NONE + BUILDING
    depth[:, 50], labels[:, 50] = 8, POLE
    cloud = pseudo_cloud(depth, labels, NONE, FINE_CAMERA)
    assert (cloud.labels == POLE).sum() == 60


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


def test_the_road_counts_before_the_grass_beside_it():
    grass = ground(1.2, 3000)
    points = np.concatenate([ground(1.65, 400), grass])
    labels = np.repeat([ROAD, TERRAIN], [400, 3000])
    assert find_road_plane(points, labels).height == pytest.approx(1.65)
    assert find_road_plane(points[100 + 300 :], labels[400:]).height == pytest.approx(1.2)


def test_a_picture_upside_down_is_said():
    with pytest.raises(LayoutError, match="is the depth metric, and the picture upright"):
        find_road_plane(ground() * (1, -1, -1), np.full(2000, ROAD))


CAMERA = Pinhole.from_hfov(math.radians(60), 300, 200)
HEIGHT = 1.65  # m
PLANE = RoadPlane(level=np.eye(3), height=HEIGHT)


def flat_road() -> tuple[np.ndarray, np.ndarray]:
    """Depth and classes of a flat road, with nothing over the horizon."""
    up = CAMERA.rays(*np.indices((200, 300)))[..., 2]
    depth = np.where(up < -0.02, HEIGHT / np.maximum(-up, 0.02), 0.0)
    return depth, np.where(depth > 0, ROAD, 0)


def test_a_patch_that_is_off_is_brought_to_the_plane_and_what_stands_on_it_with_it():
    true, labels = flat_road()
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
    depth, labels = flat_road()
    np.testing.assert_allclose(corrected_depth(times * depth, labels, CAMERA, PLANE, HEIGHT), times * depth)


def test_far_depth_is_moved_less():
    """A rise of 4 cm looks like depth that is 2.4 % too long, and a rise is the likelier the further away it is."""
    true, labels = flat_road()
    moved = 1 - corrected_depth(1.024 * true, labels, CAMERA, PLANE, HEIGHT) / np.where(true > 0, 1.024 * true, 1)
    near, far = (moved[np.abs(true - depth) < 0.1 * depth].mean() for depth in (6.0, 60.0))
    assert near > 4 * far > 0


@pytest.mark.parametrize("unit", [0.3, 2.0, 100.0])
def test_the_unit_of_depth_makes_no_difference(unit):
    true, labels = flat_road()
    depth = 1.024 * true
    metres = corrected_depth(depth, labels, CAMERA, PLANE, HEIGHT)
    plane = RoadPlane(level=np.eye(3), height=HEIGHT / unit)
    np.testing.assert_allclose(corrected_depth(depth / unit, labels, CAMERA, plane, HEIGHT) * unit, metres)
