import math

import numpy as np

from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.drafting.picture.points import CELL, pseudo_cloud
from lidardraft.semantics import BY_NAME

ROAD, CAR, POLE, BUILDING = (BY_NAME[name].id for name in ("road", "car", "pole", "building"))
CAMERA = Pinhole.from_hfov(math.radians(8), 100, 60)  # a pixel is one cell
NONE = np.zeros((60, 100), dtype=np.int64)


def test_pixels_are_one_cell_here():
    assert round(CELL * CAMERA.fx) == 1


def test_points_lie_where_the_rays_end():
    depth = np.full((60, 100), 10.0)
    cloud = pseudo_cloud(depth, NONE + BUILDING, NONE + 3, CAMERA)
    assert len(cloud.points) == 6000
    np.testing.assert_allclose(cloud.points[:, 0], 10)
    assert cloud.points[:, 1].max() == -cloud.points[:, 1].min() > 0
    assert cloud.points[0, 1] > 0 > cloud.points[99, 1]  # the left of the picture is on the left
    assert cloud.points[0, 2] > 0 > cloud.points[-1, 2]
    assert set(cloud.instances) == {3}


def test_what_has_no_depth_or_no_class_has_no_point():
    depth, labels = np.full((60, 100), 10.0), NONE + BUILDING
    depth[:30], labels[:, :50] = 0, 0
    cloud = pseudo_cloud(depth, labels, NONE, CAMERA)
    assert len(cloud.points) == 30 * 50
    assert cloud.points[:, 1].max() < 0.05
    assert cloud.points[:, 2].max() < 0


def test_a_fine_picture_is_thinned_and_a_sparse_one_keeps_what_it_has():
    camera = CAMERA.resized(400, 240)
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
    cloud = pseudo_cloud(depth, labels, NONE, CAMERA)
    between = (cloud.points[:, 0] > 13) & (cloud.points[:, 0] < 25)
    assert not between.any()
    assert (cloud.points[:, 0] == 10).sum() > 60 * 40
    assert (cloud.points[:, 0] == 30).sum() > 60 * 40


def test_a_road_is_kept_however_flat_it_is_seen():
    rows = np.arange(60) + 1.0
    depth = np.broadcast_to((1.65 * CAMERA.fx / rows)[:, None], (60, 100))
    assert len(pseudo_cloud(depth, NONE + ROAD, NONE, CAMERA).points) == 6000


def test_a_class_that_reaches_over_the_edge_of_its_object_is_cut():
    depth, labels = np.full((60, 100), 30.0), NONE + BUILDING
    depth[20:40, 30:60] = 10
    labels[18:42, 28:62] = CAR  # two pixels too wide
    cloud = pseudo_cloud(depth, labels, NONE, CAMERA)
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
    cloud = pseudo_cloud(depth, labels, NONE, CAMERA)
    cars = cloud.points[cloud.labels == CAR]
    assert set(cars[:, 0]) == {10.0}
    assert len(cars) == 11 * 20


def test_a_thin_object_before_another_class_is_kept_whole():
    depth, labels = np.full((60, 100), 30.0), NONE + BUILDING
    depth[:, 50], labels[:, 50] = 8, POLE
    cloud = pseudo_cloud(depth, labels, NONE, CAMERA)
    assert (cloud.labels == POLE).sum() == 60
