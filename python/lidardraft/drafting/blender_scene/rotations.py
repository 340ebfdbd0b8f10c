"""Rotations and maps as matrices: of angles, about an axis, along a direction."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Value, text


def rotation_matrix(angles: list[float] | tuple[float, ...]) -> np.ndarray:
    """The rotation [3, 3] about x, then y, then z, by so many radians: Blender's order XYZ."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def angles_of(rotation: np.ndarray) -> list[float]:
    """The angles about x, then y, then z [rad] of a rotation [3, 3]."""
    across = math.hypot(rotation[0, 0], rotation[1, 0])
    if across < 1e-9:  # looks straight up or down: the turn about z is taken as 0
        return [math.atan2(-rotation[1, 2], rotation[1, 1]), math.atan2(-rotation[2, 0], across), 0.0]
    x, z = math.atan2(rotation[2, 1], rotation[2, 2]), math.atan2(rotation[1, 0], rotation[0, 0])
    return [x, math.atan2(-rotation[2, 0], across), z]


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


def about_axis(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation [3, 3] about an axis [3] by an angle [rad]."""
    length = np.linalg.norm(axis)
    if length == 0:
        raise RefusalError("a rotation about an axis without length")
    x, y, z = axis / length
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross)
