"""Boxes around objects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lidardraft.errors import LayoutError, one_of
from lidardraft.scene.layout_fields import check_id, checked_vector, checked_yaw
from lidardraft.semantics import BY_NAME

if TYPE_CHECKING:
    from lidardraft.scene.layout import Primitive


@dataclass(frozen=True, slots=True)
class Box:
    """An oriented box around one object: center and size (length, width, height, each >= 0) [m], yaw [rad].

    Raises `LayoutError` naming the box and the value that cannot be.
    """

    id: str
    label: str
    instance: int
    center: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float

    def __post_init__(self) -> None:
        check_id(self.id)
        object.__setattr__(self, "center", checked_vector(self.id, "center", self.center))
        object.__setattr__(self, "size", checked_vector(self.id, "size", self.size))
        if min(self.size) < 0:
            raise LayoutError(f"{self.id}: size is {list(self.size)}; no extent may be negative")
        if not isinstance(self.label, str) or self.label not in BY_NAME:
            raise LayoutError(f"{self.id}: label is {self.label!r}; it must be {one_of(BY_NAME, self.label)}")
        checked_yaw(self.id, self.yaw)
        if type(self.instance) is not int or self.instance < 0:
            raise LayoutError(f"{self.id}: instance is {self.instance!r}; it must be a whole number >= 0")

    def seen_from(self, pose: np.ndarray) -> Box:
        """The box in the frame of world_from_sensor `pose` [4, 4]; the tilt of the pose is left out."""
        center = pose[:3, :3].T @ (np.array(self.center) - pose[:3, 3])
        yaw = self.yaw - math.atan2(pose[1, 0], pose[0, 0])
        return replace(self, center=tuple(center.tolist()), yaw=math.remainder(yaw, math.tau))


def box_around(parts: Sequence[Primitive]) -> Box:
    """The box around the parts of one object, with the yaw, id, label and instance of the largest."""
    largest = max(parts, key=lambda part: math.prod(part.size))
    low, high = corners_around(parts, largest.yaw)
    u, v, z = ((a + b) / 2 for a, b in zip(low, high, strict=True))
    cos, sin = math.cos(largest.yaw), math.sin(largest.yaw)
    center = (cos * u - sin * v, sin * u + cos * v, z)
    size = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
    return Box(largest.id, largest.label, largest.instance, center, size, largest.yaw)


def corners_around(parts: Sequence[Primitive], yaw: float) -> tuple[list[float], list[float]]:
    """The lowest and the highest corner [3] of the box around shapes, in the layout's frame turned by `yaw`."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    low, high = [math.inf] * 3, [-math.inf] * 3
    for part in parts:
        x, y, z = part.center
        length, width, height = part.size
        c, s = abs(math.cos(part.yaw - yaw)), abs(math.sin(part.yaw - yaw))
        middle = (cos * x + sin * y, cos * y - sin * x, z)
        half = ((c * length + s * width) / 2, (s * length + c * width) / 2, height / 2)
        low = [min(a, m - h) for a, m, h in zip(low, middle, half, strict=True)]
        high = [max(a, m + h) for a, m, h in zip(high, middle, half, strict=True)]
    return low, high
