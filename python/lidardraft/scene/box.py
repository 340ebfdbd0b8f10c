"""Boxes around objects, and the checks that they share with the shapes of a layout."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lidardraft.errors import LayoutError, as_int, one_of
from lidardraft.json_fields import are_numbers, is_number
from lidardraft.scene.pose import in_upright_frame
from lidardraft.semantics import BY_NAME

THINNEST = 1e-6  # m, the least extent of a shape; rays miss shapes a millionth as thick
FURTHEST = 1e9  # m, the limit of coordinates and extents; the core squares them in float32


@dataclass(frozen=True, slots=True)
class Box:
    """An oriented box around one object: center and size (length, width, height) [m], yaw [rad]. Extents may be 0, as
    for a person on a sheet, but not negative.

    `velocity` [m/s] is that over the ground along the axes of the box's frame; None if it is not known.

    Raises `LayoutError` naming the box and the invalid value.
    """

    id: str
    label: str
    instance: int
    center: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float
    velocity: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        check_id(self.id)
        object.__setattr__(self, "center", checked_vector(self.id, "center", self.center))
        object.__setattr__(self, "size", checked_vector(self.id, "size", self.size))
        if min(self.size) < 0:
            raise LayoutError(f"{self.id}: size is {list(self.size)}; no extent may be negative")
        if not isinstance(self.label, str) or self.label not in BY_NAME:
            raise LayoutError(f"{self.id}: label is {self.label!r}; it must be {one_of(BY_NAME, self.label)}")
        object.__setattr__(self, "yaw", checked_yaw(self.id, self.yaw))
        object.__setattr__(self, "instance", checked_instance(self.id, self.instance))
        if self.velocity is not None:
            object.__setattr__(self, "velocity", checked_vector(self.id, "velocity", self.velocity))

    def moving(self, velocity: tuple[float, float, float] | None) -> Box:
        """The box with a velocity in its frame; that of a person is level, as kerbs are stepped on within a moment."""
        if velocity is not None and self.label == "person":
            velocity = (*velocity[:2], 0.0)
        return replace(self, velocity=velocity)

    def seen_from(self, pose: np.ndarray) -> Box:
        """The box in the frame of world_from_sensor `pose` [4, 4]; the tilt of the pose is left out."""
        center = pose[:3, :3].T @ (np.array(self.center) - pose[:3, 3])
        yaw = self.yaw - math.atan2(pose[1, 0], pose[0, 0])
        velocity = None if self.velocity is None else tuple((pose[:3, :3].T @ self.velocity).tolist())
        return replace(self, center=tuple(center.tolist()), yaw=math.remainder(yaw, math.tau), velocity=velocity)

    def raised(self, height: float) -> Box:
        """The box moved up by `height` [m], as from the sensor's frame to the road's."""
        x, y, z = self.center
        return replace(self, center=(x, y, z + height))

    def contains(self, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        """Whether each of the points [N, 3] is in the box, or within `margin` [m] of its sides: bool [N]."""
        away = np.abs(in_upright_frame(points, self.center, self.yaw))
        return np.asarray((away <= np.array(self.size) / 2 + margin).all(axis=1))

    def corners(self) -> np.ndarray:
        """f64 [8, 3]: the four lower corners, then the four above them, each from the left rear clockwise, seen from
        above."""
        signs = np.array([(x, y, z) for z in (-1, 1) for x, y in ((-1, 1), (1, 1), (1, -1), (-1, -1))])
        x, y, z = (signs * np.array(self.size) / 2).T
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=1) + self.center


def check_id(id: object) -> None:
    """Raise `LayoutError` unless an id is a non-empty string of printable characters: others could control a
    terminal."""
    if not (isinstance(id, str) and id and id.isprintable()):
        raise LayoutError(f"id is {id!r}; it must be a non-empty string of printable characters")


def checked_vector(id: str, name: str, values: Any, length: int = 3, limit: float = FURTHEST) -> Any:
    """The values as a tuple of `length` finite floats; `LayoutError` on anything else."""
    if not are_numbers(values, length):
        raise LayoutError(f"{id}: {name} is {values!r}; it must be {length} finite numbers")
    if max(map(abs, values)) > limit:
        raise LayoutError(f"{id}: {name} is {values!r}; no number may be larger than {limit:g} m")
    return tuple(map(float, values))


def checked_instance(id: str, instance: Any, most: float = math.inf) -> int:
    """The instance as an int from 0 to `most`; `LayoutError` on anything else."""
    number = as_int(instance)
    if number is None or not 0 <= number <= most:
        limits = "a whole number >= 0" if most == math.inf else f"0 to {most}"
        raise LayoutError(f"{id}: instance is {instance!r}; it must be {limits}")
    return number


def checked_yaw(id: str, yaw: Any) -> float:
    """The yaw as a finite float [rad]; `LayoutError` on anything else."""
    if not is_number(yaw):
        raise LayoutError(f"{id}: yaw is {yaw!r}; it must be a finite number of radians")
    return float(yaw)
