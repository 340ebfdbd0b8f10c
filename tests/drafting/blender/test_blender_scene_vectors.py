import numpy as np
import pytest
from scene_reading import CUBE, refuses, scene, with_car

from lidardraft.drafting.blender.bpy.rotations import angles_of, rotation_matrix


@pytest.mark.parametrize(
    "test",
    [
        "(Vector((1, 2, 3)) + Vector((1, 1, 1)))[:] == (2.0, 3.0, 4.0)",
        "2 * Vector((1, 2)) == Vector((2, 4)) and Vector((2, 4)) / 2 == Vector((1, 2)) and "
        "-Vector((1, 2)) == Vector((-1, -2))",
        "Vector((3, 4, 0)).length == 5 and Vector((0, 0, 2)).normalized() == Vector((0, 0, 1))",
        "Vector((1, 0, 0)).cross(Vector((0, 1, 0))) == Vector((0, 0, 1)) and Vector((1, 2, 3)).dot((1, 1, 1)) == 6",
        "Vector((0, 0)).lerp(Vector((2, 4)), 0.5) == Vector((1, 2)) and Vector((1, 2, 3)).xy == Vector((1, 2))",
        "Vector((1, 2, 3)).to_tuple() == (1, 2, 3) and len(Vector((1, 2))) == 2 and "
        "[x for x in Vector((1, 2))] == [1, 2]",
        "(Matrix.Translation((1, 2, 3)) @ Vector((1, 1, 1))) == Vector((2, 3, 4))",
        "(Matrix.Scale(2, 4) @ Matrix.Identity(4) @ Vector((1, 2, 3))) == Vector((2, 4, 6))",
        "abs((Matrix.Rotation(math.pi / 2, 4, 'Z') @ Vector((1, 0, 0))).y - 1) < 1e-9",
        "(Matrix.Translation((1, 2, 3)).inverted().translation) == Vector((-1, -2, -3))",
        "Euler((0, 0, 1)).z == 1 and (Euler((0, 0, 0)).to_matrix() @ Vector((1, 2, 3))) == Vector((1, 2, 3))",
    ],
)
def test_what_they_are(test: str) -> None:
    with_car(f"assert {test}")


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


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("Vector((1,))", "a vector of a tuple; it must be 2 to 4 numbers"),
        ("Vector((1, 2, float('nan')))", "a vector is nan; it must be a finite number"),
        ("Vector((1, 2)) + 1", "a Vector . 1 is not supported"),
        ("Vector((1, 2)) + Vector((1, 2, 3))", "the other vector is a Vector; it must be 2 numbers"),
        ("Vector((1, 2)) / 0", "a vector divided by zero"),
        ("1 / Vector((1, 2))", "1 / a Vector is not supported"),
        ("Vector((1, 2)).z", "a Vector has no 'z'"),
        ("Vector((1, 2))[2]", "a Vector of 2 numbers has no place 2"),
        ("Euler((0, 0, 0), 'ZYX')", "only 'XYZ' is supported"),
        ("Matrix().to_euler('ZYX')", "angles in the order 'ZYX'; only 'XYZ' is supported"),
        ("Euler((0, 0, 1)).to_quaternion().to_euler('YXZ')", "angles in the order 'YXZ'"),
        ("Vector((1, 2)).rotate(Euler((0, 0, 1)))", "a vector that is turned is a Vector; it must be 3 numbers"),
        ("Matrix.Rotation(1, 4, 'W')", "the axis is 'W'"),
        ("Matrix.Scale(0, 4).inverted()", "a matrix that has no inverse"),
        ("Matrix(((1, 0), (0, 1)))", "it must be 3 or 4 rows"),
    ],
)
def test_what_they_refuse(script: str, said: str) -> None:
    refuses(script, said)


def test_a_vector_of_four_numbers() -> None:
    scene(
        CUBE + "assert Vector((1, 2)).to_4d()[:] == (1, 2, 0, 1) and Vector((1, 2, 3)).to_4d()[:] == (1, 2, 3, 1)\n"
        "assert Vector((1, 2, 3, 4)).to_4d()[:] == (1, 2, 3, 4)"
    )
