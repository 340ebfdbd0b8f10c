import pytest
from scene_reading import refuses, with_car


@pytest.mark.parametrize(
    "test",
    [
        "Matrix.Scale(2, 4, (1, 0, 0)) @ Vector((1, 2, 3)) == Vector((2, 2, 3))",
        "Matrix.Diagonal((1, 2, 3, 1)) @ Vector((1, 1, 1)) == Vector((1, 2, 3))",
        "abs((Matrix.Rotation(math.pi / 2, 3, (0, 0, 5)) @ Vector((1, 0, 0))).y - 1) < 1e-9",
        "Matrix.LocRotScale((1, 2, 3), Euler((0, 0, 0)), (2, 2, 2)) @ Vector((1, 1, 1)) == Vector((3, 4, 5))",
        "Matrix.LocRotScale(None, None, None) @ Vector((1, 2, 3)) == Vector((1, 2, 3))",
    ],
)
def test_matrices_are_those_of_blender(test: str) -> None:
    with_car(f"assert {test}")


def test_a_matrix_of_all_three_places_an_object() -> None:
    car = with_car("car.matrix_world = Matrix.LocRotScale(Vector((9, 1, 2)), Euler((0, 0, 0.5)), Vector((4, 2, 1)))")
    assert (car.center, car.size) == (pytest.approx((9, 1, 2)), pytest.approx((4, 2, 1)))
    assert car.yaw == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("Matrix.Rotation(1, 2)", "a matrix of 2 rows; it must have 3 or 4"),
        ("Matrix.Rotation(1, 'x', 'Z')", "a matrix of 'x' rows; it must have 3 or 4"),
        ("Matrix.Identity(-4)", "a matrix of -4 rows"),
        ("Matrix.LocRotScale(None, 1, None)", "the angles is 1; it must be 3 numbers"),
    ],
)
def test_what_they_refuse(script: str, said: str) -> None:
    refuses(script, said)
