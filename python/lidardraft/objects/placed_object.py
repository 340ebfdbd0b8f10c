"""An object before it has a shape: its kind, place and size."""

from __future__ import annotations

from dataclasses import dataclass

from lidardraft.scene.pose import Place

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class PlacedObject:
    """An object at its place, from which a builder of `lidardraft.objects.kinds.KINDS` makes primitives.

    `kind` is a key of that table and `id` the prefix of the ids of its primitives. (`x`, `y`) is the middle of its
    footprint, `z` the ground there and `level` the height of a coarse layout with flat ground there [m]; `yaw` is its
    heading [rad]. `size` holds the extents (length, width, height) [m], and `clearance` the height under a crown, a
    plate or a roof [m], 0 if there is none. `instance` is 0 for stuff; a rider has `instance`, and its vehicle
    `instance + 1`.
    """

    kind: str
    id: str
    x: float
    y: float
    z: float
    level: float
    yaw: float
    size: Vector
    clearance: float = 0.0
    instance: int = 0

    @property
    def place(self) -> Place:
        """The place of its middle."""
        return self.x, self.y, self.yaw
