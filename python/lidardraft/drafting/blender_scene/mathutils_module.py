"""`mathutils` as a script imports it."""

from __future__ import annotations

import numpy as np

from lidardraft.drafting.blender_scene.matrix_constructors import MatrixType
from lidardraft.drafting.blender_scene.rotations import about_axis
from lidardraft.drafting.blender_scene.vectors import STEPS_OF_MATRIX, Euler, Rotation, Vector
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, Namespace, Value, describe, real, reals


def mathutils_module() -> Namespace:
    """Vector, Euler, Matrix, Quaternion and Color."""

    def euler(angles: Value = (0.0, 0.0, 0.0), order: Value = "XYZ") -> Euler:
        if order != "XYZ":
            raise RefusalError(f"angles in the order {describe(order)}; only 'XYZ' is read")
        return Euler(reals(angles, 3, "the angles"))

    vector = Builtin("Vector", lambda numbers=(0.0, 0.0, 0.0): Vector.from_value(numbers))
    makers = {"Vector": vector, "Euler": Builtin("Euler", euler), "Matrix": MatrixType()}
    makers |= {"Quaternion": Builtin("Quaternion", quaternion, 2 * STEPS_OF_MATRIX), "Color": vector}
    return Namespace("mathutils", makers)


def quaternion(value: Value = (1.0, 0.0, 0.0, 0.0), angle: Value = None) -> Rotation:
    """The rotation of four numbers w, x, y, z, or of an axis and an angle [rad]."""
    if isinstance(value, Rotation):
        return value
    if angle is not None:
        return Rotation(about_axis(np.array(reals(value, 3, "the axis")), real(angle, "the angle")))
    w, *axis = reals(value, 4, "the quaternion")
    length = float(np.linalg.norm(axis))
    return Rotation(about_axis(np.array(axis), 2 * float(np.arctan2(length, w))) if length else np.eye(3))
