"""What a scan saw of a street: how much of each object, and where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import Layout, object_of
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, NUM_CLASSES

_FEW = 200  # returns; of objects with more, one in four is used
_MANY = 1200  # returns; of objects with more, one in sixteen is used
_VEGETATION = BY_NAME["vegetation"].id  # always one in four at least: every part of a plant counts


@dataclass(frozen=True, eq=False)
class VisibleObjects:
    """The returns of one scan on objects, from a sensor at `pose` [4, 4] over the ego vehicle at `place` (x, y, yaw).

    `scan` says which primitive each return is of; `owners` i32 [P + 1] is `owners_of` the scene, and `count` says
    how many objects there are.
    """

    place: tuple[float, float, float]
    pose: np.ndarray
    scan: RangeImage
    owners: np.ndarray
    count: int

    @cached_property
    def _all(self) -> tuple[np.ndarray, np.ndarray]:
        """Pixels [M] that show an object, and for each [M] the object times K plus its class."""
        assert self.scan.primitive is not None
        owner = self.owners[self.scan.primitive.ravel()]
        pixels = np.flatnonzero((owner >= 0) & (self.scan.depth.ravel() > 0))
        return pixels, owner[pixels] * NUM_CLASSES + self.scan.label.ravel()[pixels]

    @cached_property
    def returns(self) -> np.ndarray:
        """How many returns each object has in each class, i64 [T, K]."""
        counts: np.ndarray = np.bincount(self._all[1], minlength=self.count * NUM_CLASSES)
        return counts.reshape(self.count, NUM_CLASSES)

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """Points f64 [N, 3] in the frame of the ego vehicle, and for each [N] the object times K plus its class.

        All points of objects with few returns; an even share of those with many.
        """
        pixels, keys = self._all
        counts = self.returns.ravel()
        need = (counts > _FEW).astype(np.int8) + (counts > _MANY)
        need[_VEGETATION::NUM_CLASSES] = np.minimum(need[_VEGETATION::NUM_CLASSES], 1)
        kept = _lattice(self.scan.sensor)[pixels] >= need[keys]
        pixels, keys = pixels[kept], keys[kept]
        directions, origins = _rays(self.scan.sensor)
        points = directions[pixels] * self.scan.depth.ravel()[pixels, None]
        if origins is not None:
            points += origins[pixels]
        return points @ self.pose[:3, :3].T + self.pose[:3, 3], keys


def owners_of(scene: Layout, objects: Sequence[PlacedObject]) -> np.ndarray:
    """The index [P + 1] of the object that each primitive is part of; -1 for ground, and last for no primitive."""
    index = {placed.id: number for number, placed in enumerate(objects)}
    owners = [index.get(object_of(primitive), -1) for primitive in scene]
    return np.array([*owners, -1], dtype=np.int32)


@lru_cache(maxsize=4)
def _rays(sensor: Sensor) -> tuple[np.ndarray, np.ndarray | None]:
    """Directions [H W, 3] and, where beams have some, origins of the rays in the sensor frame."""
    shifted = any((*sensor.origin_forwards, *sensor.origin_lefts, *sensor.origin_heights))
    directions = sensor.pattern.directions().reshape(-1, 3)
    return directions, sensor.pattern.origins().reshape(-1, 3) if shifted else None


@lru_cache(maxsize=4)
def _lattice(sensor: Sensor) -> np.ndarray:
    """i8 [H W]: 2 for one pixel in sixteen, 1 for three more, 0 for the others; spread over rows and columns."""
    rows, columns = np.indices(sensor.shape)
    fourth = (rows % 2 == 0) & ((columns + rows // 2) % 2 == 0)
    sixteenth = fourth & (rows % 4 == 0) & ((columns + rows // 2 + rows // 4) % 4 < 2)
    return (fourth.astype(np.int8) + sixteenth).ravel()
