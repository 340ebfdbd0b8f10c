"""What a scan saw of a street: how much of each thing, and where."""

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

_FEW = 200  # returns; of more, one in four says as much
_MANY = 1200  # returns; of more, one in sixteen
_VEGETATION = BY_NAME["vegetation"].id  # of which every part counts


@dataclass(frozen=True, eq=False)
class VisibleObjects:
    """The returns of one scan on things, from a sensor at `pose` [4, 4] over the ego vehicle at `place` (x, y, yaw).

    `scan` says which primitive each return is of; `owners` i32 [P + 1] is `owners_of` the scene, and `things` says how
    many there are.
    """

    place: tuple[float, float, float]
    pose: np.ndarray
    scan: RangeImage
    owners: np.ndarray
    objects: int

    @cached_property
    def _all(self) -> tuple[np.ndarray, np.ndarray]:
        """Pixels [M] that show a thing, and the number [M] of that thing's part of that class."""
        assert self.scan.primitive is not None
        owner = self.owners[self.scan.primitive.ravel()]
        pixels = np.flatnonzero((owner >= 0) & (self.scan.depth.ravel() > 0))
        return pixels, owner[pixels] * NUM_CLASSES + self.scan.label.ravel()[pixels]

    @cached_property
    def returns(self) -> np.ndarray:
        """How many returns each thing has in each class, i64 [T, K]."""
        counts: np.ndarray = np.bincount(self._all[1], minlength=self.objects * NUM_CLASSES)
        return counts.reshape(self.objects, NUM_CLASSES)

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """Points f64 [N, 3] in the frame of the ego vehicle, and for each, [N], thing times K plus class.

        All of what returned little; of what returned much an even share.
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
    """The index [P + 1] of the thing that each primitive is a part of, -1 for ground and for the last, no primitive."""
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
