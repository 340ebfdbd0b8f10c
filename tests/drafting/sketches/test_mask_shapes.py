import math

import numpy as np
import pytest
from scipy import ndimage

from lidardraft.drafting.sketches.drawn_shapes import Blob, SketchFrame, Stroke
from lidardraft.drafting.sketches.mask_shapes import shapes_of_mask

FRAME = SketchFrame(np.array([100.0, 100.0]), 0.1)


def rectangle(length: float, width: float, yaw: float, size: int = 200) -> np.ndarray:
    """The mask of a rectangle in the middle, its length at `yaw` from up."""
    down, right = np.mgrid[:size, :size] - size / 2
    along, across = -down * math.cos(yaw) - right * math.sin(yaw), down * math.sin(yaw) - right * math.cos(yaw)
    return (np.abs(along) <= length / 2) & (np.abs(across) <= width / 2)


@pytest.mark.parametrize("yaw", [0.0, 0.35, -1.2, 1.5])
@pytest.mark.parametrize("sizes", [(84, 36), (60, 58), (110, 95)])
def test_a_rectangle_has_its_place_size_and_yaw(sizes: tuple[float, float], yaw: float) -> None:
    (blob,) = shapes_of_mask(rectangle(*sizes, yaw), FRAME, "car", ("a",), "here")
    assert isinstance(blob, Blob)
    np.testing.assert_allclose(blob.center, 0.0, atol=0.11)
    assert sorted((blob.length, blob.width)) == pytest.approx(sorted(np.array(sizes) / 10), rel=0.04)
    turn = math.remainder(blob.yaw - yaw, math.pi / 2 if sizes[0] < 1.1 * sizes[1] else math.pi)
    assert abs(turn) < math.radians(2)
    assert (blob.label, blob.names, blob.where) == ("car", ("a",), "here")


def test_what_is_long_is_a_stroke_if_its_class_has_strokes() -> None:
    mask = rectangle(160, 12, 0.5)
    (stroke,) = shapes_of_mask(mask, FRAME, "vegetation", (), "")
    assert isinstance(stroke, Stroke)
    assert stroke.width == pytest.approx(1.2, abs=0.15)
    ahead = stroke.line[-1] - stroke.line[0]
    assert abs(math.remainder(math.atan2(ahead[1], ahead[0]) - 0.5, math.pi)) < 0.03
    assert np.linalg.norm(ahead) == pytest.approx(16, abs=0.6)
    (blob,) = shapes_of_mask(mask, FRAME, "bus", (), "")
    assert isinstance(blob, Blob)


def test_a_single_pixel_is_a_blob() -> None:
    mask = np.zeros((5, 5), bool)
    mask[2, 3] = True
    (blob,) = shapes_of_mask(mask, SketchFrame(np.array([3.0, 2.0]), 0.5), "person", (), "")
    assert isinstance(blob, Blob)
    np.testing.assert_allclose(blob.center, 0.0)
    assert (blob.length, blob.width) == pytest.approx((0.5, 0.5))


def test_an_outline_of_an_object_is_filled_and_one_of_a_hedge_is_not() -> None:
    solid = rectangle(44, 18, 0.3)
    outline = solid & ~ndimage.binary_erosion(solid, iterations=3)
    (whole,), (drawn,) = (list(shapes_of_mask(mask, FRAME, "car", (), "")) for mask in (solid, outline))
    assert isinstance(whole, Blob)
    assert isinstance(drawn, Blob)
    assert (drawn.length, drawn.width) == (whole.length, whole.width)
    assert all(isinstance(shape, Stroke) for shape in shapes_of_mask(outline, FRAME, "vegetation", (), ""))


def test_a_strip_that_leads_to_an_area_is_a_stroke() -> None:
    mask = np.zeros((400, 400), dtype=bool)
    mask[50:250, 60:340] = True
    mask[250:390, 180:220] = True
    stroke, blob = shapes_of_mask(mask, FRAME, "road", (), "")
    assert isinstance(stroke, Stroke)
    assert isinstance(blob, Blob)
    assert stroke.width == pytest.approx(4.0, abs=0.3)
    assert (blob.length, blob.width) == pytest.approx((28.0, 20.0), rel=0.02)
    assert [type(shape) for shape in shapes_of_mask(rectangle(110, 95, 0.4), FRAME, "road", (), "")] == [Blob]
