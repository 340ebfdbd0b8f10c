"""What streets have and nobody draws."""

from __future__ import annotations

from lidardraft.scene.layout import Layout, Primitive
from lidardraft.simulation.road_strip import RoadStrip


def clutter_around(layout: Layout, strips: tuple[RoadStrip, ...], seed: int, amount: float) -> list[Primitive]:
    """Nothing yet."""
    return []
