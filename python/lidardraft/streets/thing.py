"""A thing of a street: what it is and where it stands, and the parts it is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.scene.layout import Primitive
from lidardraft.scene.mesh import TriangleMesh


@dataclass(frozen=True, kw_only=True, slots=True)
class Thing:
    """Something that stands in a street, before it has a shape.

    (`x`, `y`) is the middle of its footprint, `z` the ground there and `level` the height of the flat surface that a
    drawing has there [m]. `size` holds full extents; `stem` the height under a crown, a plate or a roof. `instance` is
    0 for stuff; a rider has `instance`, what is ridden `instance + 1`.
    """

    kind: str
    id: str
    x: float
    y: float
    z: float
    level: float
    yaw: float
    size: tuple[float, float, float]
    stem: float = 0.0
    instance: int = 0


class Parts:
    """The primitives of one thing, given in its own frame: x forward, y left, z up from the ground under its middle."""

    def __init__(self, thing: Thing) -> None:
        self.thing = thing
        self.primitives: list[Primitive] = []
        self._cos, self._sin = math.cos(thing.yaw), math.sin(thing.yaw)

    def add(
        self,
        shape: str,
        center: tuple[float, float, float],
        size: tuple[float, float, float],
        label: str,
        material: str | None = None,
        *,
        yaw: float = 0.0,
        mesh: TriangleMesh | None = None,
        rank: int = 0,
    ) -> None:
        """Add one primitive; `rank` is what is added to the thing's instance."""
        thing = self.thing
        x, y, z = center
        self.primitives.append(
            Primitive(
                shape=shape,
                center=(thing.x + self._cos * x - self._sin * y, thing.y + self._sin * x + self._cos * y, thing.z + z),
                size=size,
                yaw=thing.yaw + yaw,
                label=label,
                id=f"{thing.id}.{len(self.primitives)}" if self.primitives else thing.id,
                instance=thing.instance + rank if thing.instance else 0,
                material=material,
                mesh=mesh,
            )
        )

    def add_mesh(
        self, vertices: np.ndarray, faces: np.ndarray, label: str, material: str | None = None, *, rank: int = 0
    ) -> None:
        """Add triangles [F, 3] over vertices [V, 3] of the thing's frame."""
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        center, size = (low + high) / 2, high - low
        mesh = TriangleMesh((vertices - center) / np.where(size > 0, size, 1.0), faces)
        self.add("mesh", tuple(center.tolist()), tuple(size.tolist()), label, material, mesh=mesh, rank=rank)
