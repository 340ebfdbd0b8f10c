"""A thing of a street: what it is and where it stands, and the parts it is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.scene.layout import Primitive
from lidardraft.scene.mesh import TriangleMesh

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class PlacedObject:
    """Something that stands in a street, before it has a shape.

    (`x`, `y`) is the middle of its footprint, `z` the ground there and `level` the height of the flat surface that a
    drawing has there [m]. `size` holds full extents; `clearance` the height under a crown, a plate or a roof.
    `instance` is 0 for stuff; a rider has `instance`, what is ridden `instance + 1`.
    """

    kind: str
    id: str
    x: float
    y: float
    z: float
    level: float
    yaw: float
    size: tuple[float, float, float]
    clearance: float = 0.0
    instance: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A mesh within the unit box, and where that box lies in shares of the extents of what it is a piece of.

    Pieces are made once for each form and stretched to every thing of it, so that no mesh is made for each thing.
    """

    mesh: TriangleMesh
    center: Vector
    size: Vector

    @classmethod
    def from_triangles(cls, vertices: np.ndarray, faces: np.ndarray) -> Piece:
        """Triangles [F, 3] over vertices [V, 3] given in shares."""
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        center, size = (low + high) / 2, high - low
        unit = np.clip((vertices - center) / np.where(size > 0, size, 1.0), -0.5, 0.5)
        return cls(TriangleMesh(unit, faces), tuple(center.tolist()), tuple(size.tolist()))


class Parts:
    """The primitives of one thing, given in its own frame: x forward, y left, z up from the ground under its middle."""

    def __init__(self, placed: PlacedObject) -> None:
        self.placed = placed
        self.primitives: list[Primitive] = []
        self._cos, self._sin = math.cos(placed.yaw), math.sin(placed.yaw)

    def add(
        self,
        shape: str,
        center: Vector,
        size: Vector,
        label: str,
        material: str | None = None,
        *,
        yaw: float = 0.0,
        mesh: TriangleMesh | None = None,
        rank: int = 0,
        extinction: float | None = None,
    ) -> None:
        """Add one primitive; `rank` is what is added to the thing's instance, `extinction` [1/m] makes it porous.

        A street has hundreds: tests check that they are right, not this.
        """
        placed = self.placed
        x, y, z = center
        name = f"{placed.id}.{len(self.primitives)}" if self.primitives else placed.id
        self.primitives.append(
            Primitive.unchecked(
                shape=shape,
                center=(
                    placed.x + self._cos * x - self._sin * y,
                    placed.y + self._sin * x + self._cos * y,
                    placed.z + z,
                ),
                size=size,
                label=label,
                id=name,
                yaw=placed.yaw + yaw,
                instance=placed.instance + rank if placed.instance else 0,
                material=material,
                mesh=mesh,
                extinction=extinction,
            )
        )

    def add_piece(
        self,
        piece: Piece,
        scale: Vector,
        label: str,
        material: str | None = None,
        *,
        at: Vector = (0.0, 0.0, 0.0),
        rank: int = 0,
        extinction: float | None = None,
    ) -> None:
        """Add a piece stretched by `scale` [m] in the frame whose origin is `at`."""
        (a, b, c), (u, v, w), (x, y, z) = piece.center, piece.size, scale
        self.add(
            "mesh",
            (at[0] + a * x, at[1] + b * y, at[2] + c * z),
            (u * x, v * y, w * z),
            label,
            material,
            mesh=piece.mesh,
            rank=rank,
            extinction=extinction,
        )
