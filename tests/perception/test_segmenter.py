import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from lidardraft.errors import CheckpointError, LayoutError, LidarDraftError
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig
from lidardraft.perception.spherical_grid import FEATURES, SphericalGrid
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import PRESETS, Sensor

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


def test_every_pixel_of_a_class(segmenter):
    logits = segmenter(torch.randn(2, FEATURES, 16, 64))
    assert logits.shape == (2, 20, 16, 64)


def test_the_width_is_a_ring(segmenter):
    x = torch.randn(1, FEATURES, 16, 64)
    with torch.no_grad():
        there, turned = segmenter(x), segmenter(x.roll(8, dims=-1))
    torch.testing.assert_close(there.roll(8, dims=-1), turned, atol=1e-4, rtol=1e-4)


def test_every_column_of_a_cell_is_seen(segmenter):
    x = torch.randn(1, FEATURES, 16, 64)
    y = x.clone()
    y[..., 1::2] += 1
    with torch.no_grad():
        assert (segmenter(x) - segmenter(y)).abs().max() > 1e-3


@pytest.mark.parametrize("sensor", [SMALL, PRESETS["vlp16"]], ids=lambda sensor: sensor.name)
def test_returns_of_any_sensor_get_a_class_and_nothing_else_does(segmenter, sensor):
    image = raycast(room(), sensor)
    label = segmenter.label(image)
    assert label.dtype == np.uint8
    np.testing.assert_array_equal(label > 0, image.valid)
    assert label.max() <= 20


def test_the_default_network_is_compact():
    assert 1e6 < sum(p.numel() for p in Segmenter().parameters()) < 2e6


def test_points_may_come_in_any_order(segmenter):
    points = raycast(room(), SMALL).points()
    order = np.random.default_rng(0).permutation(len(points))
    intensity = np.linspace(0, 1, len(points), dtype=np.float32)
    label = segmenter.label_points(points, intensity, 1.73)
    assert len(np.unique(label)) > 1
    assert (segmenter.label_points(points[order], intensity[order], 1.73) == label[order]).mean() > 0.9  # ties


def test_a_saved_segmenter_comes_back(segmenter, tmp_path):
    weight_file.save(segmenter, tmp_path / "s.safetensors", {"note": "x"})
    again = weight_file.load(tmp_path / "s.safetensors", Segmenter)
    assert again.config == TINY
    image = raycast(room(), SMALL)
    np.testing.assert_array_equal(again.label(image), segmenter.label(image))


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
