"""mathutils as a script sees it: vectors, Euler angles and matrices."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender_scene.rotations import (
    about_axis,
    affine,
    angles_of,
    rotation_matrix,
    tracking,
)
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe, is_number, real, reals, text

IDENTITY = np.eye(4)
IDENTITY.flags.writeable = False
_AXES = {"x": 0, "y": 1, "z": 2, "w": 3}
_OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


class Vector(Record):
    """Two to four finite numbers, which can be set one by one."""

    kind = "a Vector"

    def __init__(self, numbers: list[float] | tuple[float, ...]) -> None:
        self.numbers = list(numbers)

    @classmethod
    def from_value(cls, value: Value) -> Vector:
        """The vector of a list, a tuple or another vector."""
        count = (
            len(value.elements()) if isinstance(value, Record) else len(value) if isinstance(value, list | tuple) else 0
        )
        if not 2 <= count <= 4:
            raise RefusalError(f"a vector of {describe(value)}; it must be 2 to 4 numbers")
        return cls(reals(value, count, "a vector"))

    def elements(self) -> list[Value]:
        return list(self.numbers)

    def attribute(self, name: str) -> Value:
        if name in _AXES and _AXES[name] < len(self.numbers):
            return self.numbers[_AXES[name]]
        if name in ("length", "magnitude", "length_squared"):
            return math.hypot(*self.numbers) ** (2 if name == "length_squared" else 1)
        if name in ("xy", "xyz", "xz", "yz") and len(self.numbers) > 2:
            return Vector([self.numbers[_AXES[axis]] for axis in name])
        methods: dict[str, Callable[..., Value]] = {
            "copy": lambda: type(self)(self.numbers),
            "normalized": self._normalized,
            "normalize": lambda: self._become(self._normalized()),
            "dot": lambda other: sum(a * b for a, b in zip(self.numbers, self._same(other), strict=True)),
            "cross": lambda other: Vector(np.cross(self.numbers, self._same(other)).tolist()),
            "lerp": lambda other, factor: self._between(other, real(factor, "the factor")),
            "to_tuple": lambda: tuple(self.numbers),
            "rotate": self._rotate,
            "angle": lambda other, *_: self._angle(self._same(other)),
            "to_2d": lambda: Vector(self.numbers[:2]),
            "to_3d": lambda: Vector([*self.numbers, 0.0][:3]),
            "to_track_quat": lambda track="Z", up="Y": Rotation(tracking(self.numbers, track, up)),
            "to_matrix": lambda: Matrix(rotation_matrix(self.numbers)),
        }
        if name not in methods or (name == "to_matrix" and not isinstance(self, Euler)):
            return super().attribute(name)
        return Builtin(name, methods[name])

    def set_attribute(self, name: str, value: Value) -> None:
        if name not in _AXES or _AXES[name] >= len(self.numbers):
            return super().set_attribute(name, value)
        self.numbers[_AXES[name]] = real(value, name)

    def item(self, key: Value) -> Value:
        if isinstance(key, slice):
            return tuple(self.numbers[key])
        return self.numbers[self._place(key)]

    def set_item(self, key: Value, value: Value) -> None:
        self.numbers[self._place(key)] = real(value, "a coordinate")

    def _place(self, key: Value) -> int:
        if not isinstance(key, int) or not -len(self.numbers) <= key < len(self.numbers):
            raise RefusalError(f"{self.kind} of {len(self.numbers)} numbers has no place {describe(key)}")
        return key

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        combine = _OPERATORS.get(operator)
        additive = operator in (ast.Add, ast.Sub)
        if combine is None or additive == is_number(other) or (reflected and operator is ast.Div):
            return super().binary(operator, other, reflected=reflected)
        others = [real(other, "the factor")] * len(self.numbers) if is_number(other) else self._same(other)
        pairs = zip(others, self.numbers, strict=True) if reflected else zip(self.numbers, others, strict=True)
        try:
            return Vector([real(combine(a, b), "a coordinate") for a, b in pairs])
        except ZeroDivisionError:
            raise RefusalError("a vector divided by zero") from None

    def negative(self) -> Value:
        return type(self)([-number for number in self.numbers])

    def equals(self, other: Value) -> bool:
        return isinstance(other, Vector) and other.numbers == self.numbers

    def _same(self, other: Value) -> tuple[float, ...]:
        return reals(other, len(self.numbers), "the other vector")

    def _normalized(self) -> Vector:
        length = math.hypot(*self.numbers)
        return Vector([number / length for number in self.numbers] if length else self.numbers)

    def _between(self, other: Value, factor: float) -> Vector:
        return Vector([a + (b - a) * factor for a, b in zip(self.numbers, self._same(other), strict=True)])

    def _angle(self, other: tuple[float, ...]) -> float:
        lengths = math.hypot(*self.numbers) * math.hypot(*other)
        if lengths == 0:
            raise RefusalError("the angle of a vector without length")
        return math.acos(max(-1.0, min(1.0, sum(a * b for a, b in zip(self.numbers, other, strict=True)) / lengths)))

    def _become(self, other: Vector) -> None:
        self.numbers = other.numbers

    def _rotate(self, turn: Value) -> None:
        matrix = turn.array[:3, :3] if isinstance(turn, Matrix) else rotation_matrix(reals(turn, 3, "the angles"))
        self.numbers = (matrix @ np.array(self.numbers[:3])).tolist()


class Euler(Vector):
    """Angles about x, then y, then z [rad]."""

    kind = "an Euler"

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "rotate_axis": self._rotate_axis,
            "to_quaternion": lambda: Rotation(rotation_matrix(self.numbers)),
        }
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def _rotate_axis(self, axis: Value, angle: Value) -> None:
        turn = _rotation(angle, 3, axis)
        self.numbers = angles_of(rotation_matrix(self.numbers) @ turn.array)


class Rotation(Record):
    """A quaternion, as the matrix [3, 3] that it stands for."""

    kind = "a Quaternion"

    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "to_euler": lambda *_: Euler(angles_of(self.array)),
            "to_matrix": lambda: Matrix(self.array),
            "copy": lambda: self,
            "inverted": lambda: Rotation(self.array.T),
            "normalized": lambda: self,
        }
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        if operator is not ast.MatMult or reflected or not isinstance(other, Vector | Rotation):
            return super().binary(operator, other, reflected=reflected)
        if isinstance(other, Rotation):
            return Rotation(self.array @ other.array)
        return Vector((self.array @ reals(other, 3, "the vector")).tolist())


class Matrix(Record):
    """A square matrix of three or four rows."""

    kind = "a Matrix"

    def __init__(self, array: np.ndarray) -> None:
        if not np.isfinite(array).all():
            raise RefusalError("a matrix with a number that is not finite")
        self.array = array

    @classmethod
    def from_value(cls, rows: Value = ()) -> Matrix:
        """The matrix of a list of rows; of 4 rows, the identity, where there are none."""
        if rows == ():
            return cls(np.eye(4))
        if not isinstance(rows, list | tuple) or len(rows) not in (3, 4):
            raise RefusalError(f"a matrix of {describe(rows)}; it must be 3 or 4 rows")
        return cls(np.array([reals(row, len(rows), "a row of a matrix") for row in rows]))

    def attribute(self, name: str) -> Value:
        if name == "translation" and len(self.array) == 4:
            return Vector(self.array[:3, 3].tolist())
        methods: dict[str, Callable[..., Value]] = {
            "copy": lambda: self,
            "inverted": self._inverted,
            "transposed": lambda: Matrix(self.array.T),
            "to_4x4": lambda: Matrix(
                affine(self.array[:3, :3], self.array[:3, 3] if len(self.array) == 4 else np.zeros(3))
            ),
            "to_euler": lambda *_: Euler(angles_of(self.array[:3, :3] / np.linalg.norm(self.array[:3, :3], axis=0))),
            "to_3x3": lambda: Matrix(self.array[:3, :3]),
            "to_quaternion": lambda: Rotation(self.array[:3, :3] / np.linalg.norm(self.array[:3, :3], axis=0)),
            "to_scale": lambda: Vector(np.linalg.norm(self.array[:3, :3], axis=0).tolist()),
            "to_translation": lambda: Vector(self.array[:3, 3].tolist()),
        }
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def elements(self) -> list[Value]:
        return [Vector(row) for row in self.array.tolist()]

    def item(self, key: Value) -> Value:
        if not isinstance(key, int) or not 0 <= key < len(self.array):
            raise RefusalError(f"a Matrix has no row {describe(key)}")
        return tuple(self.array[key].tolist())

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        if operator is not ast.MatMult or reflected or not isinstance(other, Vector | Matrix):
            return super().binary(operator, other, reflected=reflected)
        if isinstance(other, Matrix):
            if other.array.shape != self.array.shape:
                raise RefusalError("matrices of different sizes")
            return Matrix(self.array @ other.array)
        numbers = other.numbers
        if len(numbers) == 3 and len(self.array) == 4:
            return Vector((self.array[:3, :3] @ numbers + self.array[:3, 3]).tolist())
        if len(numbers) != len(self.array):
            raise RefusalError("a matrix and a vector of different sizes")
        return Vector((self.array @ numbers).tolist())

    def _inverted(self) -> Matrix:
        try:
            return Matrix(np.linalg.inv(self.array))
        except np.linalg.LinAlgError:
            raise RefusalError("a matrix that has no inverse") from None


class MatrixType(Record):
    """`mathutils.Matrix` itself, which is called and has constructors."""

    kind = "Matrix"

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        return Builtin("Matrix", Matrix.from_value).call(arguments, keywords)

    def attribute(self, name: str) -> Value:
        makers: dict[str, Callable[..., Value]] = {
            "Translation": lambda vector: Matrix(affine(np.eye(3), np.array(reals(vector, 3, "the translation")))),
            "Rotation": _rotation,
            "Scale": lambda factor, size, *axis: (
                Matrix(np.diag([*[real(factor, "the factor")] * 3, 1.0])[:size, :size])
                if not axis
                else _scale_along(factor, size, *axis)
            ),
            "Diagonal": lambda vector: Matrix(np.diag(Vector.from_value(vector).numbers)),
            "Identity": lambda size: Matrix(np.eye(4)[:size, :size]),
        }
        return Builtin(f"Matrix.{name}", makers[name]) if name in makers else super().attribute(name)


def _rotation(angle: Value, size: Value, axis: Value = "Z") -> Matrix:
    if isinstance(axis, Vector | tuple | list):
        turn = about_axis(np.array(reals(axis, 3, "the axis")), real(angle, "the angle"))
        return Matrix(affine(turn, np.zeros(3))[:size, :size])
    name = text(axis, "the axis").lower()
    if name not in ("x", "y", "z"):
        raise RefusalError(f"the axis is {axis!r}; it must be 'X', 'Y' or 'Z'")
    angles = [real(angle, "the angle") if name == each else 0.0 for each in "xyz"]
    return Matrix(affine(rotation_matrix(angles), np.zeros(3))[:size, :size])


def _scale_along(factor: Value, size: Value, axis: Value) -> Matrix:
    direction = np.array(reals(axis, 3, "the axis"))
    direction = direction / (np.linalg.norm(direction) or 1.0)
    stretched = np.eye(3) + (real(factor, "the factor") - 1) * np.outer(direction, direction)
    return Matrix(affine(stretched, np.zeros(3))[:size, :size])
