"""`mathutils.Matrix` as a script calls it: its constructors."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender_scene.rotations import about_axis, about_named_axis, affine, rotation_matrix
from lidardraft.drafting.blender_scene.vectors import STEPS_OF_MATRIX, Matrix, Rotation, Vector
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe, real, reals


class MatrixType(Record):
    """`mathutils.Matrix` itself, which is called and has constructors."""

    kind = "Matrix"
    weight = STEPS_OF_MATRIX

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        return Builtin("Matrix", Matrix.from_value).call(arguments, keywords)

    def attribute(self, name: str) -> Value:
        makers: dict[str, Callable[..., Value]] = {
            "Translation": lambda vector: Matrix(affine(np.eye(3), np.array(reals(vector, 3, "the translation")))),
            "Rotation": _rotation,
            "Scale": _scaling,
            "Diagonal": lambda vector: _sized(np.diag(Vector.from_value(vector).numbers)),
            "Identity": lambda size: _sized(np.eye(4), size),
            "LocRotScale": _composed,
        }
        return Builtin(f"Matrix.{name}", makers[name]) if name in makers else super().attribute(name)


def _sized(array: np.ndarray, size: Value = None) -> Matrix:
    """The first rows and columns of a matrix [4, 4], or all of another one."""
    rows = len(array) if size is None else size
    if rows not in (3, 4):
        raise RefusalError(f"a matrix of {describe(rows)} rows; 3 or 4 are read")
    return Matrix(array[:rows, :rows])


def _composed(location: Value, rotation: Value, scale: Value) -> Matrix:
    """What scales, then turns, then moves; None leaves a part out."""
    offset = np.zeros(3) if location is None else np.array(reals(location, 3, "the location"))
    turn = np.eye(3)
    if isinstance(rotation, Rotation | Matrix):
        turn = rotation.array[:3, :3]
    elif rotation is not None:
        turn = rotation_matrix(reals(rotation, 3, "the rotation"))
    return Matrix(affine(turn * ((1.0, 1.0, 1.0) if scale is None else reals(scale, 3, "the scale")), offset))


def _rotation(angle: Value, size: Value, axis: Value = "Z") -> Matrix:
    if isinstance(axis, Vector | tuple | list):
        turn = about_axis(np.array(reals(axis, 3, "the axis")), real(angle, "the angle"))
    else:
        turn = about_named_axis(axis, angle)
    return _sized(affine(turn, np.zeros(3)), size)


def _scaling(factor: Value, size: Value, axis: Value = None) -> Matrix:
    """What scales in all directions, or along an axis alone."""
    stretched = np.eye(3) * real(factor, "the factor")
    if axis is not None:
        direction = np.array(reals(axis, 3, "the axis"))
        direction = direction / (np.linalg.norm(direction) or 1.0)
        stretched = np.eye(3) + (real(factor, "the factor") - 1) * np.outer(direction, direction)
    return _sized(affine(stretched, np.zeros(3)), size)
