"""mathutils as a script sees it: vectors, Euler angles and matrices."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from functools import partial
from typing import ClassVar

import numpy as np

from lidardraft.drafting.blender_scene.rotations import (
    about_named_axis,
    affine,
    angles_of,
    rotation_matrix,
    tracking,
)
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe, is_number, real, reals

STEPS_OF_MATRIX = 15  # steps that what is done with a small array costs
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
    weight = 3
    methods: ClassVar[dict[str, tuple[int, Callable[..., Value]]]] = {}  # with what a call costs

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
        if name not in self.methods:
            return super().attribute(name)
        weight, method = self.methods[name]
        return Builtin(name, partial(method, self), weight)

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

    def _dot(self, other: Value) -> float:
        return sum(a * b for a, b in zip(self.numbers, self._same(other), strict=True))

    def _cross(self, other: Value) -> Vector:
        (ax, ay, az), (bx, by, bz) = self.numbers, self._same(other)
        return Vector([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])

    def _between(self, other: Value, factor: Value) -> Vector:
        part, others = real(factor, "the factor"), self._same(other)
        return Vector([a + (b - a) * part for a, b in zip(self.numbers, others, strict=True)])

    def _angle(self, vector: Value, *_: Value) -> float:
        other = self._same(vector)
        lengths = math.hypot(*self.numbers) * math.hypot(*other)
        if lengths == 0:
            raise RefusalError("the angle of a vector without length")
        return math.acos(max(-1.0, min(1.0, sum(a * b for a, b in zip(self.numbers, other, strict=True)) / lengths)))

    def _normalize(self) -> None:
        self.numbers = self._normalized().numbers

    def _rotate(self, turn: Value) -> None:
        numbers = reals(self, 3, "a vector that is turned")
        is_array = isinstance(turn, Matrix | Rotation)
        matrix = turn.array[:3, :3] if is_array else rotation_matrix(reals(turn, 3, "the angles"))
        self.numbers = (matrix @ numbers).tolist()


class Euler(Vector):
    """Angles about x, then y, then z [rad]."""

    kind = "an Euler"

    def _rotate_axis(self, axis: Value, angle: Value) -> None:
        self.numbers = angles_of(rotation_matrix(self.numbers) @ about_named_axis(axis, angle))


class Rotation(Record):
    """A quaternion, as the matrix [3, 3] that it stands for."""

    kind = "a Quaternion"
    weight = STEPS_OF_MATRIX

    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "to_euler": lambda *order: _euler(self.array, *order),
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
    weight = STEPS_OF_MATRIX

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
            "to_euler": lambda *order: _euler(self.array[:3, :3], *order),
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


def _euler(array: np.ndarray, order: Value = "XYZ", *_: Value) -> Euler:
    if order != "XYZ":
        raise RefusalError(f"angles in the order {describe(order)}; only 'XYZ' is read")
    return Euler(angles_of(array / np.linalg.norm(array, axis=0)))


Vector.methods = {
    "copy": (1, lambda self: type(self)(self.numbers)),
    "normalized": (2, Vector._normalized),
    "normalize": (2, Vector._normalize),
    "dot": (3, Vector._dot),
    "cross": (3, Vector._cross),
    "lerp": (3, Vector._between),
    "to_tuple": (1, lambda self: tuple(self.numbers)),
    "rotate": (STEPS_OF_MATRIX, Vector._rotate),
    "angle": (5, Vector._angle),
    "to_2d": (1, lambda self: Vector(self.numbers[:2])),
    "to_3d": (1, lambda self: Vector([*self.numbers, 0.0][:3])),
    "to_4d": (
        1,
        lambda self: Vector([*self.numbers, *(0.0, 1.0)[len(self.numbers) - 2 :]]),
    ),
    "to_track_quat": (4 * STEPS_OF_MATRIX, lambda self, track="Z", up="Y": Rotation(tracking(self.numbers, track, up))),
}
Euler.methods = Vector.methods | {
    "to_matrix": (STEPS_OF_MATRIX, lambda self: Matrix(rotation_matrix(self.numbers))),
    "to_quaternion": (STEPS_OF_MATRIX, lambda self: Rotation(rotation_matrix(self.numbers))),
    "rotate_axis": (2 * STEPS_OF_MATRIX, Euler._rotate_axis),
}
