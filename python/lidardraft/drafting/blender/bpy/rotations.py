"""Rotations and maps as matrices: of angles, about an axis, along a direction."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lidardraft.drafting.blender.script.limits import RefusalError
from lidardraft.drafting.blender.script.values import Value, describe, real, text

IDENTITY = np.eye(4)
IDENTITY.flags.writeable = False


def rotation_matrix(angles: Sequence[float]) -> np.ndarray:
    """The rotation [3, 3] about x, then y, then z, by so many radians: Blender's order XYZ."""
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
    """Points [N, 3] where a matrix [4, 4] takes them."""
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


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
