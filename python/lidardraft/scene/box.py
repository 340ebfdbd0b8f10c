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
    cos, sin = math.cos(largest.yaw), math.sin(largest.yaw)
    to_box = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for part in parts:
        turn = part.yaw - largest.yaw
        c, s = abs(math.cos(turn)), abs(math.sin(turn))
        length, width, height = part.size
        half = 0.5 * np.array([c * length + s * width, s * length + c * width, height])
        center = to_box @ part.center
        low, high = np.minimum(low, center - half), np.maximum(high, center + half)
    center = to_box.T @ ((low + high) / 2)
    return Box(
        largest.id, largest.label, largest.instance, tuple(center.tolist()), tuple((high - low).tolist()), largest.yaw
    )
