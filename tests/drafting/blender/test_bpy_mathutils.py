"""Vectors, angles, quaternions and matrices."""

import numpy as np
import pytest
from scene_reading import refuses, scene, with_car

from lidardraft.drafting.blender.bpy.mathutils import angles_of, rotation_matrix

QUATERNION = "from mathutils import Quaternion\n"
TRUE: list[str] = [
    # what they are
    "(Vector((1, 2, 3)) + Vector((1, 1, 1)))[:] == (2.0, 3.0, 4.0)",
    "2 * Vector((1, 2)) == Vector((2, 4)) and Vector((2, 4)) / 2 == Vector((1, 2)) and "
    "-Vector((1, 2)) == Vector((-1, -2))",
    "Vector((3, 4, 0)).length == 5 and Vector((0, 0, 2)).normalized() == Vector((0, 0, 1))",
    "Vector((1, 0, 0)).cross(Vector((0, 1, 0))) == Vector((0, 0, 1)) and Vector((1, 2, 3)).dot((1, 1, 1)) == 6",
    "Vector((0, 0)).lerp(Vector((2, 4)), 0.5) == Vector((1, 2)) and Vector((1, 2, 3)).xy == Vector((1, 2))",
    "Vector((1, 2, 3)).to_tuple() == (1, 2, 3) and len(Vector((1, 2))) == 2 and [x for x in Vector((1, 2))] == [1, 2]",
    "(Matrix.Translation((1, 2, 3)) @ Vector((1, 1, 1))) == Vector((2, 3, 4))",
    "(Matrix.Scale(2, 4) @ Matrix.Identity(4) @ Vector((1, 2, 3))) == Vector((2, 4, 6))",
    "abs((Matrix.Rotation(math.pi / 2, 4, 'Z') @ Vector((1, 0, 0))).y - 1) < 1e-9",
    "(Matrix.Translation((1, 2, 3)).inverted().translation) == Vector((-1, -2, -3))",
    "Euler((0, 0, 1)).z == 1 and (Euler((0, 0, 0)).to_matrix() @ Vector((1, 2, 3))) == Vector((1, 2, 3))",
    # matrices are those of blender
    "Matrix.Scale(2, 4, (1, 0, 0)) @ Vector((1, 2, 3)) == Vector((2, 2, 3))",
    "Matrix.Diagonal((1, 2, 3, 1)) @ Vector((1, 1, 1)) == Vector((1, 2, 3))",
    "abs((Matrix.Rotation(math.pi / 2, 3, (0, 0, 5)) @ Vector((1, 0, 0))).y - 1) < 1e-9",
    "Matrix.LocRotScale((1, 2, 3), Euler((0, 0, 0)), (2, 2, 2)) @ Vector((1, 1, 1)) == Vector((3, 4, 5))",
    "Matrix.LocRotScale(None, None, None) @ Vector((1, 2, 3)) == Vector((1, 2, 3))",
]
REFUSED: list[tuple[str, str]] = [
    ("Vector((1,))", "a vector of a tuple; it must be 2 to 4 numbers"),
    ("Vector((1, 2, float('nan')))", "a vector is nan; it must be a finite number"),
    ("Vector((1, 2)) + 1", "a Vector . 1 is not supported"),
    ("Vector((1, 2)) + Vector((1, 2, 3))", "the other vector is a Vector; it must be 2 numbers"),
    (QUATERNION + "Quaternion((1, 2))", "the quaternion is a tuple; it must be 4 numbers"),
    (QUATERNION + "Quaternion((0, 0, 0), 1)", "a rotation about an axis without length"),
    ("from mathutils import noise\nnoise.noise((0, 0, 0))", "a call of mathutils.noise.noise"),
    ("Euler((0, 0, 0), 'ZYX')", "angles in the order 'ZYX'; only 'XYZ' is supported"),
    ("Matrix.Rotation(1, 2)", "a matrix of 2 rows; it must have 3 or 4"),
    ("Matrix.Rotation(1, 'x', 'Z')", "a matrix of 'x' rows; it must have 3 or 4"),
    ("Matrix.Identity(-4)", "a matrix of -4 rows"),
    ("Matrix.LocRotScale(None, 1, None)", "the angles is 1; it must be 3 numbers"),
]


@pytest.mark.parametrize("test", TRUE)
def test_it_is_so_as_in_blender(test: str) -> None:
    with_car(f"assert {test}")


@pytest.mark.parametrize(("script", "said"), REFUSED)
def test_it_is_refused(script: str, said: str) -> None:
    refuses(script, said)


def test_numbers_of_a_vector_are_set_one_by_one() -> None:
    car = with_car(
        "car.location.x += 3\ncar.location[1] = 2\nv = car.location.copy()\nv.z = 9\ncar.rotation_euler.z = 0.5"
    )
    assert car.center == (8.0, 2.0, 0.5)
    assert car.yaw == 0.5


def test_a_rotation_and_its_angles() -> None:
    random = np.random.default_rng(0)
    for angles in [(0.1, -1.2, 2.5), (0.0, 0.0, 3.0), *random.uniform(-1.5, 1.5, (50, 3)).tolist()]:
        np.testing.assert_allclose(angles_of(rotation_matrix(angles)), angles, atol=1e-9)
    upwards = rotation_matrix((0.3, np.pi / 2, 0.0))
    np.testing.assert_allclose(rotation_matrix(angles_of(upwards)), upwards, atol=1e-9)


def test_a_quaternion_turns_an_object_in_its_mode() -> None:
    for value in ("Quaternion((0, 0, 1), math.pi / 3)", "(math.cos(math.pi / 6), 0, 0, math.sin(math.pi / 6))"):
        car = with_car(QUATERNION + f"car.rotation_mode = 'QUATERNION'\ncar.rotation_quaternion = {value}")
        assert car.yaw == pytest.approx(1.0471975512)
    assert with_car(QUATERNION + "car.rotation_quaternion = Quaternion((0, 0, 1), 1)").yaw == 0  # as in Blender


def test_rotations_are_combined() -> None:
    scene(
        QUATERNION + "import bpy\nq = Quaternion((0, 0, 1), math.pi / 2)\nv = q @ Vector((1, 0, 0))\n"
        "assert abs(v.y - 1) < 1e-9 and abs((q @ q).to_euler().z) > 3.1\n"
        "assert abs((Euler((0, 0, 1)).to_quaternion().inverted() @ Vector((1, 0, 0))).y + math.sin(1)) < 1e-9\n"
        "e = Euler((0, 0, 0.5))\ne.rotate_axis('Z', 0.25)\nassert abs(e.z - 0.75) < 1e-9\n"
        "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Car'"
    )


def test_a_matrix_of_all_three_places_an_object() -> None:
    car = with_car("car.matrix_world = Matrix.LocRotScale(Vector((9, 1, 2)), Euler((0, 0, 0.5)), Vector((4, 2, 1)))")
    assert (car.center, car.size) == (pytest.approx((9, 1, 2)), pytest.approx((4, 2, 1)))
    assert car.yaw == pytest.approx(0.5)
