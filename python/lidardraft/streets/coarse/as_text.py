"""A street as a sentence would describe it and the solver of sentences would place it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.streets.coarse.coarse_street import CoarseStreet, place_of
from lidardraft.streets.coarse.families import FAMILIES
from lidardraft.streets.coarse.limits import check_limits


@dataclass(frozen=True, kw_only=True, slots=True)
class TextStyle:
    """What the sentence names: vehicles, and of `FAMILIES` those in `named`, within `reach` [m] of the ego vehicle.

    `sidewalks` and `poles` say whether there are any. Raises `LayoutError` on an unknown family or a reach that is not
    1 to 1000 m.
    """

    source: ClassVar[str] = "text"
    coverage: ClassVar[tuple[float, float] | None] = None
    named: tuple[str, ...] = tuple(FAMILIES)
    sidewalks: bool = True
    poles: bool = True
    reach: float = 200.0

    def __post_init__(self) -> None:
        for family in self.named:
            if family not in FAMILIES:
                raise LayoutError(f"named holds {family!r}; it must be of {', '.join(FAMILIES)}")
        check_limits(self, reach=(1.0, 1000.0))


def as_text(street: CoarseStreet, style: TextStyle, pose: np.ndarray) -> ShapeTable:
    """Sizes of the solver, objects in the middle of their lanes and along the road, flat ground.

    In the frame of the ego vehicle at street_from_ego `pose` [4, 4].
    """
    x, y, _ = place_of(pose)
    # the last one is for the kinds of no family, vehicles
    named = np.array([family in style.named for family in FAMILIES] + [True])
    near = np.hypot(*(street.places[:, :2] - (x, y)).T) <= style.reach
    chosen = named[street.families] & near & (style.poles | ~street.poles)
    ground = street.ground(pose, relief=False, sidewalks=style.sidewalks)
    return ShapeTable.join(ground, street.standing(street.solved, chosen, pose, relief=False))
