import math

import numpy as np
import pytest

from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.errors import LayoutError

K = np.array([[700.0, 0, 400], [0, 710.0, 300], [0, 0, 1]])


def test_rays_of_a_matrix_worked_out_by_hand():
    camera = Pinhole.from_matrix(K, 800, 600)
    rays = camera.rays(np.array([300, 300, 371]), np.array([400, 470, 400]))
    np.testing.assert_allclose(rays, [(1, 0, 0), (1, -0.1, 0), (1, 0, -0.1)])


def test_a_field_of_view_is_the_angle_between_the_edges():
    camera = Pinhole.from_hfov(math.radians(80), 640, 480)
    right, left = camera.rays(np.array(239.5), np.array([639.5, -0.5]))
    assert math.degrees(math.atan2(left[1], left[0])) == pytest.approx(40)
    assert math.degrees(math.atan2(right[1], right[0])) == pytest.approx(-40)
    assert camera.fx == camera.fy


def test_a_focal_length_of_film():
    """A picture of 3 : 2, the shape of the film: 36 mm see as wide as the film, 53 degrees."""
    camera = Pinhole.from_film(36.0, 300, 200)
    assert 2 * math.degrees(math.atan(150 / camera.fx)) == pytest.approx(53.13, abs=0.01)


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


def test_degrees_given_for_radians_are_told():
    with pytest.raises(LayoutError, match=r"hfov is 80 rad \(4584 degrees\)"):
        Pinhole.from_hfov(80, 800, 600)
