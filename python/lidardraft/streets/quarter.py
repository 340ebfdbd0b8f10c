"""The kinds of quarter a street can lie in, and the road through one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.scene.road import Road

BAY = 2.2  # m, a parking bay along the kerb
SIDES = (-1, 1)  # right, left


@dataclass(frozen=True, kw_only=True, slots=True)
class Quarter:
    """What streets of one kind have in common.

    Pairs are ranges [m]. `share` is that of all streets, `heavy` that of trucks and buses in the traffic, `blocks` that
    of blocks among the buildings. `bend`, `junction`, `parked` (a side), `built` (a plot), `fronts` (a side) and
    `row_trees` (a side) are probabilities; `people`, `thickets` (a side) and `wild_trees` mean numbers; `traffic_gap`
    is a mean [m].
    """

    share: float
    lanes: tuple[int, ...]
    lane_width: tuple[float, float]
    sidewalk: tuple[float, float]
    bend: float
    junction: float
    parked: float
    traffic_gap: float
    heavy: float
    people: float
    built: float
    blocks: float
    setback: tuple[float, float]
    gap: tuple[float, float]
    fronts: float
    row_trees: float
    thickets: float
    wild_trees: int


# Lane widths: the German design guides RASt 06 (3.0 to 3.5 m in towns) and RAL (3.25 to 3.75 m outside).
QUARTERS: dict[str, Quarter] = {
    "residential": Quarter(
        share=0.36, lanes=(1,), lane_width=(2.9, 3.4), sidewalk=(1.5, 3.0), bend=0.4, junction=0.35,
        parked=0.35, traffic_gap=60.0, heavy=0.06, people=2.5,
        built=0.88, blocks=0.1, setback=(3.0, 8.0), gap=(2.5, 9.0),
        fronts=0.8, row_trees=0.4, thickets=1.2, wild_trees=34,
    ),
    "urban": Quarter(
        share=0.28, lanes=(1, 1, 2), lane_width=(3.0, 3.4), sidewalk=(2.2, 4.0), bend=0.2, junction=0.5,
        parked=0.4, traffic_gap=40.0, heavy=0.14, people=7.0,
        built=0.93, blocks=0.85, setback=(0.3, 1.5), gap=(0.0, 3.0),
        fronts=0.0, row_trees=0.5, thickets=0.4, wild_trees=12,
    ),
    "avenue": Quarter(
        share=0.18, lanes=(2, 2, 3), lane_width=(3.1, 3.6), sidewalk=(2.0, 4.0), bend=0.25, junction=0.45,
        parked=0.3, traffic_gap=32.0, heavy=0.2, people=4.5,
        built=0.75, blocks=0.65, setback=(1.5, 7.0), gap=(1.0, 12.0),
        fronts=0.35, row_trees=0.75, thickets=0.9, wild_trees=24,
    ),
    "country": Quarter(
        share=0.18, lanes=(1, 1, 2), lane_width=(3.2, 3.75), sidewalk=(0.0, 0.0), bend=0.6, junction=0.2,
        parked=0.04, traffic_gap=60.0, heavy=0.18, people=0.6,
        built=0.22, blocks=0.0, setback=(5.0, 20.0), gap=(8.0, 40.0),
        fronts=0.4, row_trees=0.5, thickets=1.8, wild_trees=50,
    ),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Lane:
    """A lane to drive in: its middle across the road [m] and direction, 1 as the road runs or -1."""

    across: float
    direction: int

    @property
    def turn(self) -> float:
        """The direction as an angle against the road [rad]."""
        return 0.0 if self.direction > 0 else math.pi


def draw_road(quarter: Quarter, parking: tuple[int, ...], reach: float, rng: np.random.Generator) -> Road:
    """A road through the quarter, with parking bays on the sides in `parking`."""
    lanes = int(rng.choice(quarter.lanes))
    width = rng.uniform(*quarter.lane_width) + (BAY if parking and lanes == 1 else 0.0)
    junction, curvature = None, 0.0
    arms: tuple[str, ...] = ("left", "right")
    if rng.random() < quarter.junction:
        # a side road leaves at a right angle, so the road is straight there
        junction = float(rng.uniform(-0.6, 0.6) * reach)
        arms = (("left", "right"), ("left",), ("right",))[int(rng.integers(3))]
    elif rng.random() < quarter.bend:
        curvature = float(rng.choice((-1, 1)) * rng.uniform(0.001, min(0.009, 1.6 / reach)))
    return Road(
        lanes=lanes,
        lane_width=width,
        sidewalk=rng.uniform(*quarter.sidewalk),
        curvature=curvature,
        junction=junction,
        arms=arms,
        reach=reach,
    )


def driven_lanes(road: Road, parking: tuple[int, ...]) -> tuple[Lane, ...]:
    """The lanes that are left to drive in: parked cars take the outermost of several, or a bay beside the only one."""
    lanes = []
    for direction in (1, -1):
        for number in range(road.lanes):
            if road.lanes == 1 and parking:
                lanes.append(Lane(-direction * (road.edge - BAY) / 2, direction))
            elif number > 0 or road.lanes == 1 or -direction not in parking:
                lanes.append(Lane(road.lane(number, direction), direction))
    return tuple(lanes)
