"""Lanes and what regulates them: the parts of a road network."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LayoutError, check_choice, check_choices, check_that
from lidardraft.files import named
from lidardraft.json_fields import is_number
from lidardraft.scene.line import Line
from lidardraft.scene.pose import Place

LANE_KINDS = ("driving", "aisle", "parking", "shoulder", "cycling", "sidewalk")
_TURNING, _SIDEWAYS, _EASING = 5.0, 2.5, 1.5  # m/s in a turn at most, m/s2 sideways in it, and braking before it


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Lane:
    """A lane of a road, or a way through several (`RoadNetwork.ways`): its center `line` in the direction of travel.

    `kind` is one of LANE_KINDS, `width` [m] the full width, `speed` [m/s] the limit. `left` and `right` are the ids of
    adjacent lanes of the same direction, `successors` those of the lanes that begin at its end. `junction` is the id of
    the junction that it leads through. Traffic that gives way waits at `stop` [m] along it. A lane that turns, "left"
    or "right", does so between the two places of `bend` [m] along it. A `closed` lane ends without a way on, as at a
    kerb. Raises `LayoutError` naming the lane and an invalid value.
    """

    id: str
    line: Line
    width: float
    speed: float
    road: str = "road"
    kind: str = "driving"
    left: str | None = None
    right: str | None = None
    successors: tuple[str, ...] = ()
    junction: str | None = None
    stop: float | None = None
    turn: str | None = None
    bend: tuple[float, float] = (0.0, 0.0)
    closed: bool = False

    def __post_init__(self) -> None:
        with named(f"lane {self.id}"):
            for name in ("width", "speed"):
                value = getattr(self, name)
                check_that(is_number(value) and value > 0.0, name, value, "a number over 0")
            check_choice("kind", self.kind, LANE_KINDS)
            check_choices(self, {"turn": ("left", "right")})
            on_it = self.stop is None or (is_number(self.stop) and 0.0 <= self.stop <= self.line.length)
            check_that(on_it, "stop", self.stop, f"0 to {self.line.length:.1f} m")

    def limit(self, along: float) -> float:
        """The speed [m/s] at a place `along` [m] from which the turn can still be taken."""
        if along >= self.bend[1]:
            return math.inf
        radius = (self.bend[1] - self.bend[0]) / (math.pi / 2)
        turning = min(_TURNING**2, _SIDEWAYS * radius)
        return math.sqrt(turning + 2 * _EASING * max(0.0, self.bend[0] - along))

    def leads_along(self, lane: Lane) -> bool:
        """Whether this way leads through `lane`."""
        along, left = self.line.along_across(lane.line.spaced(5)[1:-1])
        return bool((np.abs(left) < lane.width / 4).all() and (np.diff(along) > 0.0).all())


@dataclass(frozen=True, kw_only=True, slots=True)
class Junction:
    """A meeting of lanes: `lanes` are the ids of those that lead through it, its turns."""

    id: str
    lanes: tuple[str, ...]

    def __post_init__(self) -> None:
        if not self.lanes:
            raise LayoutError(f"junction {self.id} has no lanes through it; it needs one for each turn")


@dataclass(frozen=True, kw_only=True, slots=True)
class Crossing:
    """A crossing for people: a rectangle around `place`, with its extents [m] in that frame."""

    id: str
    place: Place
    size: tuple[float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class Signal:
    """A light or a sign at `place` (x, y [m], yaw) that traffic in `lanes` obeys, and waits at."""

    id: str
    place: Place
    lanes: tuple[str, ...]
    kind: str = "traffic-light"


@dataclass(frozen=True, kw_only=True, slots=True)
class Pavement:
    """A paved rectangle around `place`, with its length and width [m] and the label "road" or "sidewalk"."""

    place: Place
    size: tuple[float, float]
    label: str
