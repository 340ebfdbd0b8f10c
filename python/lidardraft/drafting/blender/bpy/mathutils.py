"""`mathutils` for scripts: vectors, Euler angles, quaternions and matrices; and rotations as arrays."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Sequence
from functools import partialmethod
from typing import ClassVar

import numpy as np

from lidardraft.drafting.blender.script.limits import RefusalError
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Methods,
    Namespace,
    Record,
    Value,
    builtins,
    describe,
    is_number,
    place,
    real,
    reals,
    text,
)

IDENTITY = np.eye(4)
IDENTITY.flags.writeable = False
Combine = Callable[[Value, Value], Value]


def rotation_matrix(angles: Sequence[float]) -> np.ndarray:
    """The rotation [3, 3] about x, then y, then z, by angles [rad]: Blender's order XYZ."""
    x, y, z = angles
    cx, sx, cy, sy, cz, sz = math.cos(x), math.sin(x), math.cos(y), math.sin(y), math.cos(z), math.sin(z)
    return np.array(
        [
            (cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz),
            (cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz),
            (-sy, sx * cy, cx * cy),
        ]
    )


def angles_of(rotation: np.ndarray) -> list[float]:
    """The angles about x, then y, then z [rad] of a rotation [3, 3]."""
    across = math.hypot(rotation[0, 0], rotation[1, 0])
    if across < 1e-9:  # looks straight up or down: the turn about z is taken as 0
        return [math.atan2(-rotation[1, 2], rotation[1, 1]), math.atan2(-rotation[2, 0], across), 0.0]
    x, z = math.atan2(rotation[2, 1], rotation[2, 2]), math.atan2(rotation[1, 0], rotation[0, 0])
    return [x, math.atan2(-rotation[2, 0], across), z]


def quaternion_of(rotation: np.ndarray) -> list[float]:
    """The quaternion w, x, y, z of a rotation [3, 3], with w of 0 or more."""
    a = rotation
    off = np.array([a[2, 1] - a[1, 2], a[0, 2] - a[2, 0], a[1, 0] - a[0, 1]])
    squares = np.maximum([1 + np.trace(a), *(1 + 2 * np.diag(a) - np.trace(a))], 0)  # 4 w^2, 4 x^2, ...
    largest = int(np.argmax(squares))
    if largest == 0:
        found = np.array([squares[0], *off])
    else:
        axis = largest - 1
        found = np.array([off[axis], *(a[axis] + a[:, axis])])
        found[largest] = squares[largest]
    found = found / np.linalg.norm(found)
    return [float(number) for number in (found if found[0] >= 0 else -found)]


def of_quaternion(numbers: Sequence[float]) -> np.ndarray:
    """The rotation [3, 3] of a quaternion w, x, y, z."""
    w, *axis = numbers
    length = float(np.linalg.norm(axis))
    return about_axis(np.array(axis), 2 * math.atan2(length, w)) if length else np.eye(3)


def tracking(direction: list[float], track: Value, up: Value) -> np.ndarray:
    """The rotation [3, 3] that turns the axis `track` ("X" to "-Z") along a direction, and the axis `up` upwards."""
    ahead, upward = text(track, "the track axis"), text(up, "the up axis")
    axes = [name.lower().removeprefix("-") for name in (ahead, upward)]
    if len(direction) != 3 or not any(direction) or axes[0] == axes[1] or not set(axes) <= {"x", "y", "z"}:
        raise RefusalError(f"no rotation takes {track!r:.20} along this direction and {up!r:.20} upwards")
    first, second = ("xyz".index(name) for name in axes)
    along = np.array(direction) / np.linalg.norm(direction) * (-1 if ahead.startswith("-") else 1)
    vertical = np.array([0.0, 0.0, 1.0]) if abs(along[2]) < 1 - 1e-9 else np.array([0.0, 1.0, 0.0])
    upwards = vertical - (vertical @ along) * along
    matrix = np.zeros((3, 3))
    matrix[:, first], matrix[:, second] = along, upwards / np.linalg.norm(upwards)
    matrix[:, 3 - first - second] = np.cross(matrix[:, first], matrix[:, second])
    return matrix if np.linalg.det(matrix) > 0 else matrix * np.where(np.arange(3) == 3 - first - second, -1, 1)


def affine(linear: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """The matrix [4, 4] of a linear map [3, 3] and an offset [3]."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, offset
    return matrix


def moved(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Points [N, 3], transformed by a matrix [4, 4]."""
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


def inverse(matrix: np.ndarray, what: str) -> np.ndarray:
    """The inverse of a matrix; raises `RefusalError` if it has none."""
    try:
        return np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        raise RefusalError(f"{what} is scaled to nothing") from None


def about_axis(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation [3, 3] about an axis [3] by an angle [rad]."""
    length = np.linalg.norm(axis)
    if length == 0:
        raise RefusalError("a rotation about an axis without length")
    x, y, z = axis / length
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross)


def about_named_axis(axis: Value, angle: Value) -> np.ndarray:
    """The rotation [3, 3] about "X", "Y" or "Z" by an angle [rad]."""
    name, turn = text(axis, "the axis").lower(), real(angle, "the angle")
    if name not in ("x", "y", "z"):
        raise RefusalError(f"the axis is {describe(axis)}; it must be 'X', 'Y' or 'Z'")
    return rotation_matrix([turn if name == each else 0.0 for each in "xyz"])


class Vector(Record):
    """A vector of two to four finite numbers, which can be set one by one."""

    kind = "a Vector"
    axes = "xyzw"  # the names of the numbers

    def __init__(self, numbers: Sequence[float]) -> None:
        self._numbers = list(numbers)

    @property
    def numbers(self) -> list[float]:
        """Its current numbers; `change` replaces them."""
        return self._numbers

    def change(self, numbers: Sequence[float]) -> None:
        """Replace its numbers."""
        self._numbers = list(numbers)

    @classmethod
    def from_value(cls, value: Value = (0.0, 0.0, 0.0)) -> Vector:
        """The vector of a list, a tuple or another vector."""
        numbers = list(value) if isinstance(value, Record) else value
        if not isinstance(numbers, list | tuple) or not 2 <= len(numbers) <= 4:
            raise RefusalError(f"a vector of {describe(value)}; it must be 2 to 4 numbers")
        return cls(reals(value, len(numbers), "a vector"))

    def like(self, numbers: Sequence[float]) -> Vector:
        """A vector of the same kind with other numbers."""
        return type(self)(numbers)

    def __iter__(self) -> Iterator[Value]:
        return iter(self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)

    def _places(self, name: str) -> list[int]:
        """The indices of the axes in a name ("x", "xz"); empty if it names others."""
        known = self.axes[: len(self.numbers)]
        return [known.index(axis) for axis in name] if len(name) <= 4 and set(name) <= set(known) else []

    def attribute(self, name: str) -> Value:
        places = self._places(name)
        found = [self.numbers[each] for each in places]
        return super().attribute(name) if not found else found[0] if len(found) == 1 else Vector(found)

    def set_attribute(self, name: str, value: Value) -> None:
        places = self._places(name)
        if not places or len(set(places)) < len(places):
            return super().set_attribute(name, value)
        self._put(places, (value,) if len(places) == 1 else value)

    def _put(self, places: Sequence[int], values: Value) -> None:
        numbers = list(self.numbers)
        for each, number in zip(places, reals(values, len(places), "a coordinate"), strict=True):
            numbers[each] = number
        self.change(numbers)

    def __getitem__(self, key: Value) -> Value:
        numbers = self.numbers
        return tuple(numbers[key]) if isinstance(key, slice) else numbers[place(key, len(numbers), self.kind)]

    def __setitem__(self, key: Value, value: Value) -> None:
        if isinstance(key, slice):
            self._put(range(len(self.numbers))[key], value)
        else:
            self._put([place(key, len(self.numbers), self.kind)], (value,))

    def _combined(self, combine: Combine, other: Value, *, additive: bool, reflected: bool = False) -> Value:
        """The numbers, each combined with that of another vector if `additive`, else with a factor."""
        if additive == is_number(other):
            return NotImplemented
        others = self._same(other) if additive else [real(other, "the factor")] * len(self.numbers)
        pairs = zip(others, self.numbers, strict=True) if reflected else zip(self.numbers, others, strict=True)
        try:
            return Vector([real(combine(a, b), "a coordinate") for a, b in pairs])
        except ZeroDivisionError:
            raise RefusalError("a vector divided by zero") from None

    def _changed(self, combine: Combine, other: Value) -> Vector:
        self.change(combine(self, other).numbers)
        return self

    __add__ = partialmethod(_combined, operator.add, additive=True)
    __radd__ = partialmethod(_combined, operator.add, additive=True, reflected=True)
    __sub__ = partialmethod(_combined, operator.sub, additive=True)
    __rsub__ = partialmethod(_combined, operator.sub, additive=True, reflected=True)
    __mul__ = __rmul__ = partialmethod(_combined, operator.mul, additive=False)
    __truediv__ = partialmethod(_combined, operator.truediv, additive=False)
    __iadd__ = partialmethod(_changed, operator.add)
    __isub__ = partialmethod(_changed, operator.sub)
    __imul__ = partialmethod(_changed, operator.mul)
    __itruediv__ = partialmethod(_changed, operator.truediv)

    def __neg__(self) -> Vector:
        return self.like([-number for number in self.numbers])

    def __eq__(self, other: object) -> bool:
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
        return math.acos(max(-1.0, min(1.0, self._dot(vector) / lengths)))

    def _rotate(self, turn: Value) -> None:
        self.change((rotation_of(turn) @ reals(self, 3, "a vector that is turned")).tolist())

    fields: ClassVar[Methods] = {
        **dict.fromkeys(("length", "magnitude"), lambda self: math.hypot(*self.numbers)),
        "length_squared": lambda self: math.hypot(*self.numbers) ** 2,
    }
    methods: ClassVar[Methods] = {
        "copy": lambda self: self.like(self.numbers),
        "normalized": _normalized,
        "normalize": lambda self: self.change(self._normalized().numbers),
        "dot": _dot,
        "cross": _cross,
        "lerp": _between,
        "to_tuple": lambda self: tuple(self.numbers),
        "rotate": _rotate,
        "angle": _angle,
        "to_2d": lambda self: Vector(self.numbers[:2]),
        "to_3d": lambda self: Vector([*self.numbers, 0.0][:3]),
        "to_4d": lambda self: Vector([*self.numbers, *(0.0, 1.0)[len(self.numbers) - 2 :]]),
        "to_track_quat": lambda self, track="Z", up="Y": Quaternion(quaternion_of(tracking(self.numbers, track, up))),
    }


class LiveVector(Vector):
    """A vector whose numbers are read from another value and written back to it."""

    def __init__(self, read: Callable[[], Sequence[float]], write: Callable[[Sequence[float]], None]) -> None:
        self._read = read
        self._write = write

    @property
    def numbers(self) -> list[float]:
        return list(self._read())

    def change(self, numbers: Sequence[float]) -> None:
        self._write(numbers)

    def like(self, numbers: Sequence[float]) -> Vector:
        return Vector(numbers)


class Euler(Vector):
    """Angles about x, then y, then z [rad]."""

    kind = "an Euler"

    @classmethod
    def from_value(cls, value: Value = (0.0, 0.0, 0.0), order: Value = "XYZ") -> Euler:
        """The angles from three numbers [rad]."""
        _check_order(order)
        return cls(reals(value, 3, "the angles"))

    def _rotate(self, turn: Value) -> None:
        self.change(angles_of(rotation_of(turn) @ rotation_matrix(self.numbers)))

    def _rotate_axis(self, axis: Value, angle: Value) -> None:
        self.change(angles_of(rotation_matrix(self.numbers) @ about_named_axis(axis, angle)))

    methods: ClassVar[Methods] = Vector.methods | {
        "to_matrix": lambda self: Matrix(rotation_matrix(self.numbers)),
        "to_quaternion": lambda self: Quaternion(quaternion_of(rotation_matrix(self.numbers))),
        "rotate": _rotate,
        "rotate_axis": _rotate_axis,
    }


class Quaternion(Vector):
    """A rotation as four numbers w, x, y, z."""

    kind = "a Quaternion"
    axes = "wxyz"

    @classmethod
    def from_value(cls, value: Value = (1.0, 0.0, 0.0, 0.0), angle: Value = None) -> Quaternion:
        """The rotation from four numbers w, x, y, z, or from an axis and an angle [rad]."""
        if angle is None:
            return cls(reals(value, 4, "the quaternion"))
        return cls(quaternion_of(about_axis(np.array(reals(value, 3, "the axis")), real(angle, "the angle"))))

    def _refused(self, _other: Value) -> Vector:
        raise RefusalError("of quaternions, only products by @ are supported")

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = _refused

    def __matmul__(self, other: Value) -> Value:
        if isinstance(other, Quaternion):
            return Quaternion(quaternion_of(of_quaternion(self.numbers) @ of_quaternion(other.numbers)))
        return Vector((of_quaternion(self.numbers) @ reals(other, 3, "the vector")).tolist())

    def _inverted(self) -> Quaternion:
        w, x, y, z = self.numbers
        return Quaternion([w, -x, -y, -z])

    methods: ClassVar[Methods] = {
        "to_euler": lambda self, order="XYZ", *_: _euler(of_quaternion(self.numbers), order),
        "to_matrix": lambda self: Matrix(of_quaternion(self.numbers)),
        "copy": lambda self: self.like(self.numbers),
        "inverted": _inverted,
        "conjugated": _inverted,
        "normalized": lambda self: self.like(self._normalized().numbers),
    }


class Matrix(Record):
    """A square matrix of three or four rows; `changed` gets its new array after each change."""

    kind = "a Matrix"

    def __init__(self, array: np.ndarray, changed: Callable[[np.ndarray], None] | None = None) -> None:
        self._changed = changed
        self.array = _finite(array)

    def change(self, array: np.ndarray) -> None:
        """Replace its numbers."""
        self.array = _finite(array)
        if self._changed is not None:
            self._changed(self.array)

    @classmethod
    def from_value(cls, rows: Value = ()) -> Matrix:
        """The matrix from a list of rows; without rows, the identity [4, 4]."""
        if rows == ():
            return cls(np.eye(4))
        if isinstance(rows, Matrix):
            return cls(rows.array)
        if not isinstance(rows, list | tuple) or len(rows) not in (3, 4):
            raise RefusalError(f"a matrix of {describe(rows)}; it must be 3 or 4 rows")
        return cls(np.array([reals(row, len(rows), "a row of a matrix") for row in rows]))

    def _row(self, key: int | tuple[slice, int]) -> LiveVector:
        """A row, or a part of a column; setting it changes the matrix."""

        def write(numbers: Sequence[float]) -> None:
            array = self.array.copy()
            array[key] = numbers
            self.change(array)

        return LiveVector(lambda: self.array[key].tolist(), write)

    def _translation(self) -> Vector:
        if len(self.array) != 4:
            raise RefusalError("a Matrix of 3 rows has no translation")
        return self._row((slice(3), 3))

    def _translate(self, value: Value) -> None:
        self._translation().change(reals(value, 3, "the translation"))

    def __iter__(self) -> Iterator[Value]:
        return (self._row(row) for row in range(len(self.array)))

    def __len__(self) -> int:
        return len(self.array)

    def __getitem__(self, key: Value) -> Vector:
        return self._row(place(key, len(self.array), self.kind))

    def __setitem__(self, key: Value, value: Value) -> None:
        self[key].change(reals(value, len(self.array), "a row of a matrix"))

    def __matmul__(self, other: Value) -> Value:
        if isinstance(other, Matrix):
            if other.array.shape != self.array.shape:
                raise RefusalError("matrices of different sizes")
            return Matrix(self.array @ other.array)
        if not isinstance(other, Vector):
            return NotImplemented
        numbers = other.numbers
        if len(numbers) == 3 and len(self.array) == 4:
            return Vector((self.array[:3, :3] @ numbers + self.array[:3, 3]).tolist())
        if len(numbers) != len(self.array):
            raise RefusalError("a matrix and a vector of different sizes")
        return Vector((self.array @ numbers).tolist())

    def __imatmul__(self, other: Value) -> Value:
        product = self @ other
        if not isinstance(product, Matrix):
            return product
        self.change(product.array)
        return self

    def four_rows(self) -> np.ndarray:
        """Its map of points, [4, 4]."""
        return affine(self.array[:3, :3], self.array[:3, 3] if len(self.array) == 4 else np.zeros(3))

    def _to_quaternion(self) -> Quaternion:
        return Quaternion(quaternion_of(self.array[:3, :3] / np.linalg.norm(self.array[:3, :3], axis=0)))

    fields: ClassVar[Methods] = {"translation": _translation}
    setters: ClassVar[Methods] = {"translation": _translate}
    methods: ClassVar[Methods] = {
        "copy": lambda self: Matrix(self.array),
        "inverted": lambda self: Matrix(inverse(self.array, "the matrix")),
        "transposed": lambda self: Matrix(self.array.T),
        "to_4x4": lambda self: Matrix(self.four_rows()),
        "to_3x3": lambda self: Matrix(self.array[:3, :3]),
        "to_euler": lambda self, order="XYZ", *_: _euler(self.array[:3, :3], order),
        "to_quaternion": _to_quaternion,
        "to_scale": lambda self: Vector(np.linalg.norm(self.array[:3, :3], axis=0).tolist()),
        "to_translation": lambda self: self._translation().like(self._translation().numbers),
    }


def _finite(array: np.ndarray) -> np.ndarray:
    if not np.isfinite(array).all():
        raise RefusalError("a matrix with a number that is not finite")
    return array


def _sized(array: np.ndarray, size: Value = None) -> Matrix:
    """The matrix of the first `size` rows and columns, by default all."""
    rows = len(array) if size is None else size
    if rows not in (3, 4):
        raise RefusalError(f"a matrix of {describe(rows)} rows; it must have 3 or 4")
    return Matrix(array[:rows, :rows])


def rotation_of(turn: Value) -> np.ndarray:
    """The rotation [3, 3] of a matrix, a quaternion or three angles."""
    if isinstance(turn, Matrix):
        return np.asarray(turn.array[:3, :3])
    if isinstance(turn, Quaternion):
        return of_quaternion(turn.numbers)
    return rotation_matrix(reals(turn, 3, "the angles"))


def _composed(location: Value, rotation: Value, scale: Value) -> Matrix:
    """The matrix that scales, then turns, then moves; None leaves a part out."""
    offset = np.zeros(3) if location is None else np.array(reals(location, 3, "the location"))
    turn = np.eye(3) if rotation is None else rotation_of(rotation)
    return Matrix(affine(turn * ((1.0, 1.0, 1.0) if scale is None else reals(scale, 3, "the scale")), offset))


def _rotated(angle: Value, size: Value, axis: Value = "Z") -> Matrix:
    if isinstance(axis, Vector | tuple | list):
        turn = about_axis(np.array(reals(axis, 3, "the axis")), real(angle, "the angle"))
    else:
        turn = about_named_axis(axis, angle)
    return _sized(affine(turn, np.zeros(3)), size)


def _scaled(factor: Value, size: Value, axis: Value = None) -> Matrix:
    """The matrix that scales in all directions, or along one axis."""
    stretched = np.eye(3) * real(factor, "the factor")
    if axis is not None:
        direction = np.array(reals(axis, 3, "the axis"))
        direction = direction / (np.linalg.norm(direction) or 1.0)
        stretched = np.eye(3) + (real(factor, "the factor") - 1) * np.outer(direction, direction)
    return _sized(affine(stretched, np.zeros(3)), size)


def _check_order(order: Value) -> None:
    if order != "XYZ":
        raise RefusalError(f"angles in the order {describe(order)}; only 'XYZ' is supported")


def _euler(array: np.ndarray, order: Value) -> Euler:
    _check_order(order)
    return Euler(angles_of(array / np.linalg.norm(array, axis=0)))


def mathutils_module() -> Namespace:
    """The module: Vector, Euler, Matrix, Quaternion and Color."""
    vectors = builtins("", {"Vector": Vector.from_value, "Euler": Euler.from_value, "Color": Vector.from_value})
    quaternion = Builtin("Quaternion", Quaternion.from_value)
    matrices: Methods = {
        "Translation": lambda vector: Matrix(affine(np.eye(3), np.array(reals(vector, 3, "the translation")))),
        "Rotation": _rotated,
        "Scale": _scaled,
        "Diagonal": lambda vector: _sized(np.diag(Vector.from_value(vector).numbers)),
        "Identity": lambda size: _sized(np.eye(4), size),
        "LocRotScale": _composed,
    }
    matrix = Builtin("Matrix", Matrix.from_value, matrices)
    return Namespace("mathutils", {**vectors, "Matrix": matrix, "Quaternion": quaternion})
