import numpy as np
import pytest

from lidardraft.errors import SensorError
from lidardraft.perception.spherical_grid import FEATURES, SphericalGrid, features

GRID = SphericalGrid(rows=4, columns=8, top=10.0, bottom=-10.0)


def towards(azimuth, elevation, depth=10.0):
    azimuth, elevation = np.deg2rad(azimuth), np.deg2rad(elevation)
    return depth * np.array(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
    )


def test_azimuth_falls_to_the_right_and_elevation_downwards():
    points = np.array([towards(179, 9), towards(1, 1), towards(-1, -1), towards(-179, -9)])
    np.testing.assert_array_equal(GRID.pixels(points), [0, 8 + 3, 16 + 4, 24 + 7])


def test_points_out_of_view_belong_to_the_row_at_the_edge():
    np.testing.assert_array_equal(GRID.pixels(np.array([towards(-1, 60), towards(-1, -60)])), [4, 24 + 4])


def test_the_nearest_point_has_the_pixel():
    points = np.array([towards(1, 1, 20), towards(1, 1, 5), towards(1, 1, 9)])
    index = GRID.nearest(points, GRID.pixels(points))
    assert index[1, 3] == 1
    assert (index >= 0).sum() == 1


def test_a_hidden_point_takes_the_label_of_its_like():
    # a pole at 5 m hides one point of a wall at 20 m, whose neighbour has a pixel of its own
    points = np.array([towards(1, 1, 5), towards(2, 1, 20), towards(46, 1, 20)])
    pixels = GRID.pixels(points)
    index = GRID.nearest(points, pixels)
    label = np.zeros((4, 8), np.uint8)
    label.flat[pixels[0]], label.flat[pixels[2]] = 6, 3
    np.testing.assert_array_equal(GRID.back_project(label, points, pixels, index), [6, 3, 3])


def test_a_neighbour_across_the_seam_counts():
    points = np.array([towards(179, 1, 5), towards(178, 1, 20), towards(-179, 1, 20)])
    pixels = GRID.pixels(points)
    label = np.zeros((4, 8), np.uint8)
    label.flat[pixels[0]], label.flat[pixels[2]] = 6, 3
    np.testing.assert_array_equal(GRID.back_project(label, points, pixels, GRID.nearest(points, pixels)), [6, 3, 3])


def test_a_flat_road_points_upwards():
    grid = SphericalGrid()
    azimuth, elevation = np.meshgrid(np.linspace(179.9, -179.9, 1024), np.linspace(-5, -24, 60))
    points = np.stack(
        [towards(a, e, 1.73 / np.sin(np.deg2rad(-e))) for a, e in zip(azimuth.flat, elevation.flat, strict=True)]
    )
    index = grid.nearest(points, grid.pixels(points))
    image = features(points.astype(np.float32), np.full(len(points), 0.3, np.float32), 1.73, index)
    assert image.shape == (FEATURES, 64, 1024)
    valid = index >= 0
    np.testing.assert_allclose(image[3][valid], 0, atol=1e-4)  # on the ground
    np.testing.assert_allclose(image[5][valid], 0, atol=1e-6)  # every intensity is the mean
    known = valid & (image[8] > 0)
    assert known.sum() > 0.8 * valid.sum()
    np.testing.assert_allclose(image[8][known], 1, atol=1e-3)
    depth = np.linalg.norm(points[index[known]], axis=1)
    np.testing.assert_allclose(image[9][known], 1.73 / depth, atol=2e-3)  # the cosine to the ray
    assert not image[:, ~valid].any()


def test_a_wall_stands_upright():
    azimuth, height = np.meshgrid(np.linspace(20, -20, 114), np.linspace(1.5, -1.5, 40))
    points = np.stack([np.full(azimuth.size, 10.0), np.tan(np.deg2rad(azimuth.ravel())) * 10, height.ravel()], axis=1)
    grid = SphericalGrid(top=9, bottom=-9)
    index = grid.nearest(points, grid.pixels(points))
    image = features(points.astype(np.float32), None, 1.73, index)
    known = image[9] > 0
    assert known.sum() > 1000
    np.testing.assert_allclose(image[8][known], 0, atol=1e-3)
    assert not image[5].any()
    assert not image[6].any()


def test_the_scale_of_intensities_does_not_matter():
    points = np.array([towards(1, 1, 20), towards(60, 1, 5), towards(100, 1, 9)], dtype=np.float32)
    index = GRID.nearest(points, GRID.pixels(points))
    intensity = np.array([0.1, 0.3, 0.2], np.float32)
    np.testing.assert_allclose(
        features(points, intensity, 1.7, index), features(points, 3 * intensity, 1.7, index), atol=1e-6
    )


def test_no_points_are_an_empty_image():
    points = np.zeros((0, 3), np.float32)
    index = GRID.nearest(points, GRID.pixels(points))
    assert not features(points, None, 1.73, index).any()
    assert GRID.back_project(np.zeros((4, 8), np.uint8), points, GRID.pixels(points), index).shape == (0,)


@pytest.mark.parametrize("wrong", [{"rows": 0}, {"columns": 0}, {"top": -25.0}])
def test_a_grid_that_cannot_be(wrong):
    with pytest.raises(SensorError, match="it needs a row, a column and a top above its bottom"):
        SphericalGrid(**wrong)
