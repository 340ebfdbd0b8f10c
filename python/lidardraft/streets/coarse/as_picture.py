"""A street as a camera or a hand would picture it: what is visible ahead, a little misjudged."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lidardraft.objects.coarse_shapes import MOST_LOBES
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.streets.coarse.coarse_street import CoarseStreet, place_of
from lidardraft.streets.coarse.limits import check_limits
from lidardraft.streets.coarse.visible import VisibleObjects

_NOTICED = 5  # returns of an object that is noticed in a picture: an estimate of ours


@dataclass(frozen=True, kw_only=True, slots=True)
class PictureStyle:
    """What is in the picture, and how well it is judged.

    The picture shows what is within `reach` [m] and `view` [rad] around straight ahead; `omit` is the share of small
    objects left out, `sidewalks` and `poles` say whether there are any, `relief` whether the ground rises and falls.
    `lobes` is the number of ellipsoids in a crown. `error` is the standard deviation of sizes in shares of them and of
    places in shares of the distance, `turn` that of yaw [rad]. Raises `LayoutError` on a value out of its limits.
    """

    source: ClassVar[str] = "picture"
    relief: bool = False
    sidewalks: bool = True
    poles: bool = True
    omit: float = 0.0
    lobes: int = 1
    error: float = 0.0
    turn: float = 0.0
    reach: float = 200.0
    view: float = math.tau

    def __post_init__(self) -> None:
        check_limits(
            self,
            omit=(0.0, 1.0),
            lobes=(1, MOST_LOBES),
            error=(0.0, 0.3),
            turn=(0.0, 1.0),
            reach=(1.0, 1000.0),
            view=(0.1, math.tau),
        )

    @property
    def coverage(self) -> tuple[float, float] | None:
        """The azimuths [rad] that the picture shows, as `Layout.coverage` has them."""
        return None if self.view >= math.tau else (-self.view / 2, self.view / 2)


def as_picture(
    street: CoarseStreet, style: PictureStyle, rng: np.random.Generator, pose: np.ndarray, visible: VisibleObjects
) -> ShapeTable:
    """What the picture shows, in the frame of the ego vehicle at street_from_ego `pose` [4, 4]."""
    chosen = _in_picture(street, style, rng, visible)
    errors = _errors(street, style, rng, pose)
    ground = street.ground(pose, relief=style.relief, sidewalks=style.sidewalks)
    shapes = street.standing(street.exact, chosen, pose, relief=style.relief, lobes=style.lobes, errors=errors)
    return ShapeTable.join(ground, shapes)


def _in_picture(
    street: CoarseStreet, style: PictureStyle, rng: np.random.Generator, visible: VisibleObjects
) -> np.ndarray:
    """Which objects [T] are in the picture."""
    x, y, yaw = visible.place
    ahead = street.places[:, :2] - (x, y)
    bearing = np.arctan2(ahead[:, 1], ahead[:, 0]) - yaw
    inside = np.cos(bearing) >= math.cos(style.view / 2)
    near = np.hypot(ahead[:, 0], ahead[:, 1]) <= style.reach
    omitted = street.small & (rng.random(len(street.objects)) < style.omit)
    noticed = visible.returns.sum(axis=1) >= _NOTICED
    shown: np.ndarray = inside & near & noticed & (style.poles | ~street.poles) & ~omitted
    return shown


def _errors(
    street: CoarseStreet, style: PictureStyle, rng: np.random.Generator, pose: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How far off the places [T, 3] (x, y, yaw) are, further along the line of sight, and the scales [T, 3]."""
    count = len(street.objects)
    sight = street.places[:, :2] - place_of(pose)[:2]
    off = np.column_stack([sight * rng.normal(0.0, style.error, (count, 1)), rng.normal(0.0, style.turn, count)])
    return off, np.exp(rng.normal(0.0, style.error, (count, 3)))
