"""A street as annotators would mark it: tight boxes around everything, crowns and poles as simple shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lidardraft.scene.shape_table import ShapeTable
from lidardraft.streets.coarse.coarse_street import CoarseStreet


@dataclass(frozen=True, kw_only=True, slots=True)
class BoxStyle:
    """`relief` is whether the ground rises and falls or is flat."""

    source: ClassVar[str] = "boxes"
    coverage: ClassVar[tuple[float, float] | None] = None
    relief: bool = False


def as_boxes(street: CoarseStreet, style: BoxStyle, pose: np.ndarray) -> ShapeTable:
    """Everything at its place and size, in the frame of the ego vehicle at street_from_ego `pose` [4, 4]."""
    everything = np.ones(len(street.objects), dtype=bool)
    ground = street.ground(pose, relief=style.relief)
    return ShapeTable.join(ground, street.standing(street.exact, everything, pose, relief=style.relief))
