"""A road as a frame (along, across), shared by all code that places objects beside one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any, overload

import numpy as np

from lidardraft.errors import LayoutError

LEFT, RIGHT = 1, -1  # sides of a road: the sign of `across`
SIDES = (RIGHT, LEFT)
PARKING_STRIP = 2.2  # m, room for cars parked along the kerb: RASt 06 has 2.0 m and 0.25 m to moving traffic
TERRAIN_HEIGHT = -0.05  # below the road, so that the road covers it
KERB_HEIGHT = 0.12  # usual European kerb face, 10 to 15 cm
_STRAIGHT = 1e-9  # 1/m, the curvature below which a road is straight
_LIMITS = {
    "lanes": (1, 6),
    "lane_width": (2, 6),  # m, as all below
    "parking": (0, 5),
    "sidewalk": (0, 10),
    "median": (0, 20),
    "half_length": (1, 10_000),
}
RING = 8.0  # m, the width of a roundabout's lane: 6.5 to 9 m in the German guide of 2006 (FGSV 242)


@dataclass(frozen=True, slots=True)
class PavedArea:
    """A paved rectangle beside a road, in the road's frame: from and to along, from and to across [m]."""

    along: tuple[float, float]
    across: tuple[float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class Road:
    """A road of constant curvature under the ego vehicle, right-hand traffic, with at most one crossing road.

    `along` [m] runs in the ego's direction with the ego at 0; `across` [m] is positive to the left with the centreline
    at 0. `lanes` counts the ego's direction, and the other one too unless `oncoming_lanes` differs (then the centreline
    is the middle of all lanes). The ego drives in lane `ego_lane`, counted from the kerb. `parking` is the width [m] of
    the strip for parked vehicles (or of the hard shoulder) along each kerb. `curvature` [1/m] is positive for a left
    bend.

    `junction` is the `along` of the middle of the crossing road, or None; `side_roads` are the sides on which it
    leaves, `LEFT` or `RIGHT`. The road extends `half_length` [m] either way. `median` is the width [m] of the strip
    between the directions. `roundabout_radius` is the outer radius [m] of a roundabout in the junction, or None.
    `paved_areas` are beside the road, such as a car park. With `one_way` all `lanes` lead in the ego's direction, on
    both sides of the centreline.
    """

    lanes: int = 1
    oncoming_lanes: int | None = None
    ego_lane: int = 0
    lane_width: float = 3.5
    parking: float = 0.0
    sidewalk: float = 2.0
    curvature: float = 0.0
    junction: float | None = None
    side_roads: tuple[int, ...] = (LEFT, RIGHT)
    half_length: float = 80.0
    median: float = 0.0
    roundabout_radius: float | None = None
    paved_areas: tuple[PavedArea, ...] = ()
    one_way: bool = False

    def __post_init__(self) -> None:
        for name, (low, high) in _LIMITS.items():
            if not low <= getattr(self, name) <= high:
                raise LayoutError(f"{name} is {getattr(self, name)}; it must be {low} to {high}")
        if self.oncoming_lanes is not None and not 1 <= self.oncoming_lanes <= 6:
            raise LayoutError(f"oncoming_lanes is {self.oncoming_lanes}; it must be 1 to 6")
        if self.oncoming_lanes is not None and (self.one_way or self.median):
            raise LayoutError(f"oncoming_lanes is {self.oncoming_lanes}; it goes with neither one_way nor a median")
        if not 0 <= self.ego_lane < self.lanes:
            raise LayoutError(f"ego_lane is {self.ego_lane}; the road has {self.lanes} lanes in each direction")
        if not abs(self.curvature) * self.half_length <= 2.0:
            raise LayoutError(f"curvature {self.curvature} over {self.half_length} m turns the road back on itself")
        if not set(self.side_roads) <= {LEFT, RIGHT}:
            raise LayoutError(f"side_roads is {self.side_roads}; sides are {LEFT} (left) and {RIGHT} (right)")
        if self.one_way and self.median:
            raise LayoutError(f"median is {self.median} m; a one-way road has none")
        if self.roundabout_radius is not None:
            self._check_roundabout(self.roundabout_radius)

    def _check_roundabout(self, radius: float) -> None:
        if self.junction is None or self.curvature:
            raise LayoutError("a roundabout needs a junction on a straight road")
        if not self.verge + RING < radius <= 40.0:
            raise LayoutError(
                f"roundabout_radius is {radius} m; for this road it must be over {self.verge + RING} and up to 40 m"
            )

    @property
    def edge(self) -> float:
        """Distance from the centreline to the kerb [m]."""
        return self.median / 2 + self._half_lanes * self.lane_width + self.parking

    @property
    def oncoming(self) -> int:
        """The number of lanes against the ego's direction."""
        return 0 if self.one_way else self.lanes if self.oncoming_lanes is None else self.oncoming_lanes

    @property
    def _half_lanes(self) -> float:
        """Half the number of all lanes."""
        return (self.lanes + self.oncoming) / 2

    @property
    def island(self) -> float:
        """Radius of the island of the roundabout [m], 0 without one."""
        return 0.0 if self.roundabout_radius is None else self.roundabout_radius - RING

    @property
    def verge(self) -> float:
        """Distance from the centreline to the outer edge of the sidewalk [m]."""
        return self.edge + self.sidewalk

    def lane(self, number: int, direction: int = 1) -> float:
        """`across` of the middle of a lane: number 0 is the outermost, direction 1 the ego's and -1 the opposite."""
        lanes = self.lanes if direction > 0 else self.oncoming
        if not 0 <= number < lanes:
            raise LayoutError(f"lane {number} of a road with {lanes} lanes in that direction")
        return -direction * (self.median / 2 + (self._half_lanes - number - 0.5) * self.lane_width) + 0.0

    @overload
    def at(self, along: float, across: float) -> tuple[float, float, float]: ...
    @overload
    def at(self, along: np.ndarray, across: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]: ...
    def at(self, along: Any, across: Any) -> tuple[Any, Any, Any]:
        """x, y [m] and heading [rad] of the layout's frame; the ego is in the middle of its lane at x = y = 0.

        Takes numbers, or arrays that broadcast.
        """
        bend, ego = self.curvature, self.lane(self.ego_lane)
        heading = bend * along
        if abs(bend) < _STRAIGHT:
            return along, across - ego, heading + 0.0  # never minus zero
        functions = _functions(heading)
        sin, cos = functions.sin(heading), functions.cos(heading)
        return sin / bend - sin * across, (1.0 - cos) / bend + cos * across - ego, heading

    @overload
    def along_across(self, x: float, y: float) -> tuple[float, float]: ...
    @overload
    def along_across(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]: ...
    def along_across(self, x: Any, y: Any) -> tuple[Any, Any]:
        """The inverse of `at`: along and across [m] of places x, y [m] on this side of a bend's centre."""
        bend, ego = self.curvature, self.lane(self.ego_lane)
        if abs(bend) < _STRAIGHT:
            return x, y + ego
        functions, sign = _functions(x), math.copysign(1.0, bend)
        inward = 1.0 / bend - (y + ego)
        arc_tangent = np.arctan2 if functions is np else math.atan2
        return arc_tangent(sign * x, sign * inward) / bend, 1.0 / bend - sign * functions.hypot(x, inward)

    def points(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """x, y [..., 2] in the layout's frame of places along and across [m], which broadcast."""
        return np.stack(np.broadcast_arrays(*self.at(along, across)[:2]), axis=-1)

    def in_junction(self, along: float, margin: float = 0.0) -> bool:
        """Whether `along` is within the crossing road or the roundabout (with sidewalks)."""
        half = self.verge if self.roundabout_radius is None else self.roundabout_radius + self.sidewalk
        return self.junction is not None and abs(along - self.junction) < half + margin

    def sidewalks(self) -> list[tuple[tuple[float, float], tuple[float, float]]]:
        """From and to along, and from and to across [m], of each sidewalk."""
        whole = (-self.half_length, self.half_length)
        strips = []
        for side, across in ((RIGHT, (-self.verge, -self.edge)), (LEFT, (self.edge, self.verge))):
            if self.junction is None or (side not in self.side_roads and self.roundabout_radius is None):
                strips.append((whole, across))
                continue
            gap = self.edge if self.roundabout_radius is None else self.roundabout_radius
            spans = ((whole[0], self.junction - gap), (self.junction + gap, whole[1]))
            strips += [(span, across) for span in spans if span[1] - span[0] > 1.0]
        return strips


def _functions(value: float | np.ndarray) -> ModuleType:
    """The module of sines for a number or an array: for a single number, numpy takes ten times as long."""
    return np if isinstance(value, np.ndarray) else math
