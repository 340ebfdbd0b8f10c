"""Poses: rigid float64 matrices [4, 4] that take points of one frame to another, p_world = pose @ p_sensor."""

from __future__ import annotations

import math
from typing import Any, TypeVar

import numpy as np

from lidardraft.errors import LayoutError


def finite_array(name: str, values: Any, *shape: int | str) -> np.ndarray:
    """`values` as a C-contiguous float64 array of finite numbers; a letter in `shape` stands for any length.

    Raises `LayoutError` naming the shape, or the first row that is not finite.
    """
    array = as_array(name, values, *shape)
    if not np.isfinite(array).all():
        bad = np.argwhere(~np.isfinite(array))[0].tolist()
        raise LayoutError(f"{name}{bad} is {array[tuple(bad)]}; it must be finite")
    return array


def as_array(name: str, values: Any, *shape: int | str) -> np.ndarray:
    """Like `finite_array`, for values that the core checks."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise LayoutError(f"{name} is {values!r:.200}; it must be numbers [{_written(shape)}]") from None
    fits = array.ndim == len(shape) and all(
        isinstance(n, str) or n == m for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise LayoutError(f"{name} has shape {array.shape}; it must be [{_written(shape)}]")
    return array


def _written(shape: tuple[int | str, ...]) -> str:
    return ", ".join(map(str, shape))


def upright(center: tuple[float, float, float], yaw: float) -> np.ndarray:
    """The pose [4, 4] of an upright object at `center`, turned by `yaw` [rad] about z."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    x, y, z = center
    return np.array([(cos, -sin, 0.0, x), (sin, cos, 0.0, y), (0.0, 0.0, 1.0, z), (0.0, 0.0, 0.0, 1.0)])


def moved_by_column(poses: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points [H, W, 3] with each column moved by its pose of [W, 4, 4]: f64 [H, W, 3]."""
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    moved = np.empty_like(points)
    for axis, (a, b, c, offset) in enumerate(poses[:, :3].transpose(1, 2, 0)):
        moved[..., axis] = x * a + y * b + z * c + offset
    return moved


def rotation(yaw: float) -> np.ndarray:
    """The matrix [2, 2] that takes points [..., 2] from a frame turned by `yaw` to the frame around: points @
    rotation."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, sin], [-sin, cos]])


Place = tuple[float, float, float]  # x, y [m] and yaw [rad] of an upright object
_Metres = TypeVar("_Metres", float, np.ndarray)


def point_at(place: Place, ahead: _Metres, left: _Metres) -> tuple[_Metres, _Metres]:
    """x, y of the point `ahead` and `left` [m] of the middle of an object at `place`."""
    x, y, yaw = place
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + cos * ahead - sin * left, y + sin * ahead + cos * left


def in_frame(inner: Place, outer: Place) -> Place:
    """A place in a frame that is at `outer`, as a place in the frame around it."""
    return *point_at(outer, *inner[:2]), outer[2] + inner[2]


def place_around(place: Place) -> Place:
    """The place of the surrounding frame, in the frame that is at `place`."""
    x, y, yaw = place
    return *point_at((0.0, 0.0, -yaw), -x, -y), -yaw


def in_upright_frame(points: np.ndarray, center: tuple[float, float, float], yaw: float) -> np.ndarray:
    """Points [N, 3] in the frame of an object at `center`, turned by `yaw` about z: f64 [N, 3]."""
    pose = upright(center, yaw)
    local: np.ndarray = (points - pose[:3, 3]) @ pose[:3, :3]
    return local


def inverse(pose: np.ndarray) -> np.ndarray:
    """The inverse of a rigid pose [4, 4]."""
    back = np.eye(4)
    back[:3, :3] = pose[:3, :3].T
    back[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return back


def rotations(vectors: np.ndarray) -> np.ndarray:
    """The rotations [N, 3, 3] about vectors [N, 3] by their lengths [rad]: the formula of Rodrigues."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    # sin(a) / a and (1 - cos(a)) / a^2, without a division by zero: np.sinc(x) is sin(pi x) / (pi x).
    first, second = np.sinc(angle / np.pi), np.sinc(angle / (2 * np.pi)) ** 2 / 2
    turned: np.ndarray = np.eye(3) + first * cross + second * cross @ cross
    return turned
