import numpy as np
import pytest

from lidardraft.errors import LayoutError
from lidardraft.scene.pose import (
    as_array,
    finite_array,
    in_upright_frame,
    inverse,
    place_around,
    point_at,
    rotations,
    upright,
)


def test_a_turn_about_z_is_the_matrix_of_the_books():
    turned = rotations(np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.0], [0.0, 0.0, 1e-12]]))
    np.testing.assert_allclose(turned[0], upright((0.0, 0.0, 0.0), 0.3)[:3, :3], atol=1e-15)
    np.testing.assert_array_equal(turned[1], np.eye(3))
    np.testing.assert_allclose(turned[2][1, 0], 1e-12)


def test_rotations_are_rigid_and_leave_their_axis():
    vectors = np.random.default_rng(0).uniform(-4, 4, (50, 3))
    turned = rotations(vectors)
    np.testing.assert_allclose(turned @ turned.swapaxes(1, 2), np.tile(np.eye(3), (50, 1, 1)), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(turned), 1)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", turned, vectors), vectors, atol=1e-13)
    np.testing.assert_allclose(np.trace(turned, axis1=1, axis2=2), 1 + 2 * np.cos(np.linalg.norm(vectors, axis=1)))


def test_the_inverse_leads_back():
    pose = upright((3.0, -2.0, 1.0), 0.7)
    pose[:3, :3] = pose[:3, :3] @ rotations(np.array([[0.1, 0.2, -0.3]]))[0]
    np.testing.assert_allclose(inverse(pose) @ pose, np.eye(4), atol=1e-15)


def test_points_and_places_in_the_frame_of_what_stands_somewhere():
    points = np.array([[1.0, 2.0, 3.0], [4.0, -1.0, 0.5]])
    back = inverse(upright((3.0, -2.0, 1.0), 0.7))
    expected = points @ back[:3, :3].T + back[:3, 3]
    np.testing.assert_allclose(in_upright_frame(points, (3.0, -2.0, 1.0), 0.7), expected, atol=1e-14)
    x, y, yaw = place_around((3.0, -2.0, 0.7))
    assert yaw == -0.7
    np.testing.assert_allclose((x, y), inverse(upright((3.0, -2.0, 0.0), 0.7))[:2, 3], atol=1e-14)
    np.testing.assert_allclose(point_at((x, y, yaw), 3.0, -2.0), (0.0, 0.0), atol=1e-14)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.eye(3), r"pose has shape \(3, 3\); it must be \[4, 4\]"),
        ([[1, 2], [3]], r"pose is \[\[1, 2\], \[3\]\]; it must be numbers \[4, 4\]"),
        ("here", r"pose is 'here'; it must be numbers \[4, 4\]"),
        (None, r"pose has shape|pose is None"),
    ],
)
def test_what_is_no_array_of_that_shape(values, message):
    with pytest.raises(LayoutError, match=message):
        as_array("pose", values, 4, 4)


def test_what_is_not_finite_is_named():
    with pytest.raises(LayoutError, match=r"rays\[1, 0\] is nan; it must be finite"):
        finite_array("rays", [[0, 1], [np.nan, 2]], "N", 2)
    assert finite_array("rays", np.zeros((0, 2)), "N", 2).shape == (0, 2)
