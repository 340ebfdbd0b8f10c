"""The builder of one object: takes parts in the object's frame and makes primitives at its place."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from lidardraft.objects.mesh import MeshTemplate
from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.scene.layout import Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.pose import point_at

EMBEDMENT = 0.3  # m, the depth of posts, stems and walls in the ground, without gaps on slopes: an estimate


class ObjectBuilder:
    """Collects the `primitives` of one object, given in its frame: x forward, y left, z up from the ground."""

    def __init__(self, placed: PlacedObject) -> None:
        self.placed = placed
        self.primitives: list[Primitive] = []
        self._instance = placed.instance

    def next_instance(self) -> None:
        """Assign all further parts to the object's second instance: the vehicle of a rider."""
        self._instance += 1 if self._instance else 0

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
        extinction: float | None = None,
    ) -> None:
        """Add one primitive; `extinction` [1/m] makes it a medium.

        There are hundreds in a street: tests check their values, this does not.
        """
        placed = self.placed
        x, y, z = center
        name = f"{placed.id}.{len(self.primitives)}" if self.primitives else placed.id
        self.primitives.append(
            Primitive.unchecked(
                shape=shape,
                center=(*point_at(placed.place, x, y), placed.z + z),
                size=size,
                label=label,
                id=name,
                yaw=placed.yaw + yaw,
                instance=self._instance,
                material=material,
                mesh=mesh,
                extinction=extinction,
            )
        )

    def add_mesh(
        self,
        template: MeshTemplate,
        extents: Vector,
        label: str,
        material: str | None = None,
        *,
        at: Vector = (0.0, 0.0, 0.0),
        backward: bool = False,
    ) -> None:
        """Add a template stretched to `extents` [m] in a frame with its origin `at`, turned round if `backward`."""
        (a, b, c), (u, v, w), (x, y, z) = template.center, template.size, extents
        if backward:
            a, b = -a, -b
        self.add(
            "mesh",
            (at[0] + a * x, at[1] + b * y, at[2] + c * z),
            (u * x, v * y, w * z),
            label,
            material,
            mesh=template.mesh,
            yaw=math.pi if backward else 0.0,
        )


Add = Callable[[ObjectBuilder, np.random.Generator], None]  # adds the parts of one object


def built(add: Add, placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """The primitives that `add` makes for an object."""
    builder = ObjectBuilder(placed)
    add(builder, rng)
    return builder.primitives


def sample_name(shares: Mapping[str, float], rng: np.random.Generator) -> str:
    """One of the names of a table whose shares add up to 1."""
    return str(rng.choice(list(shares), p=list(shares.values())))
