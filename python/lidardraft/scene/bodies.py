"""Shapes compiled for casting, with their surfaces. Sets of them are joined and moved without a new compilation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lidardraft import _core
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.pose import upright
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import cast_scans, compiled
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.surfaces import Surfaces


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """Shapes [P] as given, their compiled scene, and their surfaces.

    Brightness and free paths follow from ids: a shape keeps them wherever it is and whatever is beside it. Only such
    shapes that are `as_given` can be pickled; the copy is compiled again.
    """

    primitives: tuple[Primitive, ...]
    scene: _core.Scene
    surfaces: Surfaces
    as_given: bool = False

    @classmethod
    def of(cls, layout: Layout, wetness: float = 0.0, *, by_id: bool = True) -> Bodies:
        """The shapes of a layout, with a `wetness` of its ground from 0 to 1. Unless `by_id`, brightness follows from
        the places of shapes, and free paths from their order."""
        surfaces = Surfaces.from_layout(layout, wetness=wetness, by_id=by_id)
        return cls(layout.primitives, compiled(layout.primitives, by_id=by_id), surfaces, as_given=by_id)

    @classmethod
    def _again(
        cls, primitives: tuple[Primitive, ...], surfaces: Surfaces, origin: tuple[float, float, float]
    ) -> Bodies:
        whole = cls(primitives, compiled(primitives, by_id=True), surfaces)
        return replace(cls.joined([whole], surfaces, origin), as_given=True)

    def __reduce__(self) -> tuple[Any, ...]:
        if not self.as_given:
            raise TypeError("bodies that were joined, moved or not made by ids cannot be pickled; pickle their sources")
        return Bodies._again, (self.primitives, self.surfaces, self.origin)

    @classmethod
    def joined(cls, parts: Sequence[Bodies], surfaces: Surfaces, origin: tuple[float, float, float]) -> Bodies:
        """All bodies of some sets, in order, on `surfaces`, which may hold more entries after theirs. The result is a
        function of the shapes, their poses and `origin` alone, byte for byte."""
        every = [np.arange(len(part.primitives), dtype=np.uint32) for part in parts]
        scene = _core.Scene.joined([part.scene for part in parts], every, origin)
        primitives = tuple(primitive for part in parts for primitive in part.primitives)
        return cls(primitives, scene, surfaces)

    def some(self, indices: Sequence[int], origin: tuple[float, float, float] | None = None) -> Bodies:
        """The shapes of these indices."""
        kept = np.array(indices, dtype=np.uint32)
        scene = _core.Scene.joined([self.scene], [kept], origin)
        return Bodies(tuple(self.primitives[i] for i in indices), scene, self.surfaces.some(kept), self.as_given)

    @property
    def origin(self) -> tuple[float, float, float]:
        """The point around which the coordinates are most precise [m]."""
        x, y, z = self.scene.origin
        return x, y, z

    def moved(self, by: np.ndarray) -> Bodies:
        """All shapes moved by a rigid motion [4, 4] from their given poses."""
        homes = np.array([upright(p.center, p.yaw) for p in self.primitives])
        every = np.arange(len(self.primitives), dtype=np.uint32)
        return Bodies(self.primitives, self.scene.moved(every, by @ homes), self.surfaces)

    def scan(self, sensor: Sensor, poses: np.ndarray, seed: int, threads: int | None) -> RangeImage:
        """The scan of `sensor` at world_from_sensor `poses`, one [4, 4] or one for each column [W, 4, 4]: depth, label,
        instance, primitive and incidence."""
        shape = (1, -1, 4, 4)
        return cast_scans(self.scene, sensor, poses.reshape(shape), None, (True, True, False), seed, threads)[0]
