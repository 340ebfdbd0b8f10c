import numpy as np
import pytest

from lidardraft.drafting.blender.bpy.rotations import about_axis, angles_of, rotation_matrix
from lidardraft.drafting.blender.script.limits import RefusalError


def test_a_turn_about_an_axis_is_that_of_its_angle() -> None:
    for axis, angles in (((0, 0, 2.0), (0, 0, 0.7)), ((0.5, 0, 0), (0.7, 0, 0)), ((0, 3.0, 0), (0, 0.7, 0))):
        np.testing.assert_allclose(about_axis(np.array(axis), 0.7), rotation_matrix(angles), atol=1e-12)
    with pytest.raises(RefusalError, match="without length"):
        about_axis(np.zeros(3), 1.0)


def test_the_angles_of_a_turn_give_it_again() -> None:
    turn = about_axis(np.array([1.0, 2.0, 3.0]), 1.1)
    np.testing.assert_allclose(rotation_matrix(angles_of(turn)), turn, atol=1e-12)
