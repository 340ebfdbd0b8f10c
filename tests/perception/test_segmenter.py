import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from lidardraft.errors import CheckpointError, LayoutError, LidarDraftError, SensorError
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import (
    FEATURES,
    Segmenter,
    SegmenterConfig,
    SphericalGrid,
    averaged,
    features,
    ground_heights,
)
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import PRESETS, Sensor

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
    np.testing.assert_array_equal(label.flat[GRID.back_project(points, pixels, index)], [6, 3, 3])


def test_a_neighbour_across_the_seam_counts():
    points = np.array([towards(179, 1, 5), towards(178, 1, 20), towards(-179, 1, 20)])
    pixels = GRID.pixels(points)
    label = np.zeros((4, 8), np.uint8)
    label.flat[pixels[0]], label.flat[pixels[2]] = 6, 3
    np.testing.assert_array_equal(
        label.flat[GRID.back_project(points, pixels, GRID.nearest(points, pixels))], [6, 3, 3]
    )


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


def test_the_ground_may_be_tilted_and_crowned_and_hidden_in_part():
    random = np.random.default_rng(0)
    x, y = random.uniform(-40, 40, (2, 20_000))
    ground = -1.7 + 0.02 * x - 0.015 * y - 5e-4 * y**2
    height = np.where(random.random(20_000) < 0.5, random.uniform(0, 4, 20_000), 0)  # half of it are cars and walls
    height[y > 8] += 0.15  # a kerb
    found = ground_heights(np.stack([x, y, ground + height], axis=1).astype(np.float32), 1.6)
    np.testing.assert_allclose((found - ground)[np.abs(y) < 8], 0, atol=0.1)
    beside, on = (np.median((ground - found)[(y > low) & (y < low + 4)]) for low in (8, 4))
    assert beside + 0.15 - on > 0.1  # and the kerb is still there


def test_near_returns_have_a_say_and_far_ones_none():
    xyz = torch.zeros(3, 5, 9)
    xyz[0, :, 1:] = 10.0  # a wall, which does not return in the first column
    xyz[1, :, 1:] = torch.arange(8) * 0.1
    xyz[0, 2, 6] = 5.0  # and what stands before it
    probability = torch.zeros(2, 5, 9)
    probability[0] = 0.9
    probability[:, 2, 3] = torch.tensor([0.1, 0.9])
    probability[:, 2, 6] = torch.tensor([0.2, 0.8])
    probability[1] = 1 - probability[0]
    found = averaged(probability, xyz)
    assert found[0, 2, 3] > 0.7
    torch.testing.assert_close(found[0, 2, 6], torch.tensor(0.2))
    torch.testing.assert_close(found.sum(0), torch.ones(5, 9))
    torch.testing.assert_close(found[0, 2, 0], torch.tensor(0.9))


def test_no_point_has_no_class(segmenter):
    label, probability = segmenter.predict(np.zeros((0, 3)), None, 1.73)
    assert label.shape == probability.shape == (0,)


def test_the_scale_of_intensities_does_not_matter():
    points = np.array([towards(1, 1, 20), towards(60, 1, 5), towards(100, 1, 9)], dtype=np.float32)
    index = GRID.nearest(points, GRID.pixels(points))
    intensity = np.array([0.1, 0.3, 0.2], np.float32)
    np.testing.assert_allclose(
        features(points, intensity, 1.7, index), features(points, 3 * intensity, 1.7, index), atol=1e-6
    )


@pytest.mark.parametrize("wrong", [{"rows": 0}, {"columns": 0}, {"top": -25.0}])
def test_a_grid_that_cannot_be(wrong):
    with pytest.raises(SensorError, match="it needs a row, a column and a top above its bottom"):
        SphericalGrid(**wrong)


TINY = SegmenterConfig(grid=SphericalGrid(rows=16, columns=64), widths=(8, 8, 16))
SMALL = Sensor(name="small", elevations=tuple(np.linspace(0.03, -0.4, 16).tolist()), columns=128)


@pytest.fixture
def segmenter():
    torch.manual_seed(0)
    return Segmenter(TINY).eval()


def room():
    box = {"shape": "box", "center": (6, 0, 1), "size": (1, 8, 3), "label": "building", "id": "b"}
    road = {"shape": "plane", "center": (0, 0, 0), "size": (60, 60, 0), "label": "road", "id": "road"}
    return Layout(primitives=(Primitive(**box), Primitive(**road)))


def test_the_width_is_a_ring(segmenter):
    x = torch.randn(1, FEATURES, 16, 64)
    with torch.no_grad():
        there, turned = segmenter(x), segmenter(x.roll(8, dims=-1))
    torch.testing.assert_close(there.roll(8, dims=-1), turned, atol=1e-4, rtol=1e-4)


@pytest.mark.parametrize("sensor", [SMALL, PRESETS["vlp16"]], ids=lambda sensor: sensor.name)
def test_returns_of_any_sensor_get_a_class_and_nothing_else_does(segmenter, sensor):
    image = raycast(room(), sensor)
    label = segmenter.label(image)
    assert label.dtype == np.uint8
    np.testing.assert_array_equal(label > 0, image.valid)
    assert label.max() <= 20


def test_a_mirrored_scan_has_the_mirrored_classes(segmenter):
    points = raycast(room(), SMALL).points()
    label, probability = segmenter.predict(points, None, 1.73)
    other, same = segmenter.predict(points * [1, -1, 1], None, 1.73)
    assert (label == other).mean() > 0.98  # points on the border of two pixels fall into the other one
    assert np.median(np.abs(probability - same)) < 1e-2
    assert ((probability > 0.05) & (probability <= 1)).all()
    least = float(np.median(probability))
    sure = segmenter.label_points(points, None, 1.73, least=least)
    np.testing.assert_array_equal(sure, np.where(probability < least, 0, label))


def test_points_may_come_in_any_order(segmenter):
    points = raycast(room(), SMALL).points()
    order = np.random.default_rng(0).permutation(len(points))
    intensity = np.linspace(0, 1, len(points), dtype=np.float32)
    label = segmenter.label_points(points, intensity, 1.73)
    assert len(np.unique(label)) > 1
    assert (segmenter.label_points(points[order], intensity[order], 1.73) == label[order]).mean() > 0.9  # ties


def test_points_that_cannot_be(segmenter):
    with pytest.raises(LayoutError, match=r"points are \(3, 2\); they must be finite and \[N, 3\]"):
        segmenter.label_points(np.zeros((3, 2)), None, 1.73)
    with pytest.raises(LayoutError, match=r"they must be finite"):
        segmenter.label_points(np.full((3, 3), np.nan), None, 1.73)
    with pytest.raises(LayoutError, match=r"intensity is \(2,\) for 3 points; it must be \[N\]"):
        segmenter.label_points(np.ones((3, 3)), np.zeros(2), 1.73)


def test_a_config_that_cannot_be():
    with pytest.raises(LidarDraftError, match=r"widths are \(8,\) on 63 columns; it needs one, and even columns"):
        SegmenterConfig(grid=SphericalGrid(columns=63), widths=(8,))
    with pytest.raises(LidarDraftError, match=r"widths are \(\)"):
        SegmenterConfig(widths=())


@pytest.mark.parametrize(
    "config", ['{"grid": {"sides": 3}, "widths": [8]}', '{"widths": [8]}', '{"grid": {}, "widths": []}']
)
def test_a_config_in_a_file_that_makes_no_segmenter(segmenter, tmp_path, config):
    path = tmp_path / "s.safetensors"
    save_file(segmenter.state_dict(), path, {"schema": Segmenter.SCHEMA, "config": config})
    with pytest.raises(CheckpointError, match="its config makes no Segmenter"):
        weight_file.load(path, Segmenter)
