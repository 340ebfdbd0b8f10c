"""The kinds of quarter a street can lie in, and the road through one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.scene.road import LEFT, RIGHT, RING, Road

PARKING_STRIP = 2.2  # m, a parking bay along the kerb: RASt 06 has 2.0 m and 0.25 m to moving traffic
SIDES = (RIGHT, LEFT)


@dataclass(frozen=True, kw_only=True, slots=True)
class District:
    """What streets of one kind have in common.

    Pairs are ranges [m]. `share` is that of all streets, `heavy` that of trucks and buses in the traffic, `blocks` that
    of blocks among the buildings. `bend`, `junction`, `roundabout` and `lights` (of junctions), `oneway`, `lot`,
    `parked` (a side), `paved` (what lies beside the sidewalks), `built` (a plot), `fronts` (a side), `row_trees` (a
    side), `strip` (of grass beside the kerb),
    `ditch` and `bank` (a side) are probabilities; `people`, `thickets` (a side) and `wild_trees` mean numbers;
    `traffic_gap` is a mean [m], `speed` the limit [m/s]. `grade` and `hillside` are standard deviations of slopes along
    and beside the road, `rolling` is the height [m] of the land's waves.
    """

    share: float
    lanes: tuple[int, ...]
    lane_width: tuple[float, float]
    sidewalk: tuple[float, float]
    speed: float
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
    roundabout: float = 0.0
    lights: float = 0.0
    oneway: float = 0.0
    car_park: float = 0.0
    median: tuple[float, float] = (0.0, 0.0)
    shoulder: float = 0.0
    curvature: tuple[float, float] = (0.001, 0.009)
    grade: float = 0.015
    hillside: float = 0.02
    rolling: float = 0.25
    strip: float = 0.0
    paved: float = 0.0
    ditch: float = 0.0
    bank: float = 0.0


# Lane widths: the German design guides RASt 06 (3.0 to 3.5 m in towns), RAL (3.25 to 3.75 m outside) and RAA (3.5 to
# 3.75 m on motorways, median 4 m, hard shoulder 2.5 m). Sidewalks: RASt 06, 2.5 m and more where there is room.
# Heavy vehicles: the German road census of 2021 (BASt), 15 % of the traffic on motorways, 7 % on federal roads; fewer
# in towns. People, cars and plants: such that their shares of the returns lie between those of PandaSet and the class
# frequencies published with SemanticKITTI (cars 21 and 4 %, vegetation 13 and 27 %, people 0.2 and 0.05 %). Speeds:
# StVO. Grades stay under the limits of RASt 06 and RAL, 4.5 to 8 %. The shares of quarters, and probabilities and
# numbers without a source, are estimates of ours.
DISTRICTS: dict[str, District] = {
    "residential": District(
        share=0.44, lanes=(1,), lane_width=(2.5, 3.25), sidewalk=(1.5, 3.0), speed=30 / 3.6, bend=0.5, junction=0.45,
        parked=0.25, traffic_gap=70.0, heavy=0.015, people=0.25,
        built=0.82, blocks=0.1, setback=(3.5, 11.0), gap=(2.5, 9.0),
        fronts=0.95, row_trees=0.7, thickets=5.5, wild_trees=52,
        roundabout=0.14, oneway=0.12, car_park=0.04, grade=0.02, hillside=0.035, strip=0.15, bank=0.3,
    ),
    "urban": District(
        share=0.18, lanes=(1, 1, 2), lane_width=(2.75, 3.25), sidewalk=(2.2, 5.5), speed=50 / 3.6, bend=0.2,
        junction=0.55, parked=0.4, traffic_gap=40.0, heavy=0.035, people=0.8,
        built=0.95, blocks=0.95, setback=(0.0, 0.4), gap=(0.0, 0.0),
        fronts=0.0, row_trees=0.8, thickets=0.6, wild_trees=26,
        roundabout=0.08, lights=0.6, oneway=0.35, car_park=0.06, grade=0.014, hillside=0.015, rolling=0.1, paved=0.7,
    ),
    "avenue": District(
        share=0.15, lanes=(2, 2, 3), lane_width=(3.0, 3.5), sidewalk=(2.0, 4.0), speed=50 / 3.6, bend=0.25,
        junction=0.5, parked=0.2, traffic_gap=60.0, heavy=0.035, people=0.5,
        built=0.75, blocks=0.65, setback=(1.5, 7.0), gap=(1.0, 12.0),
        fronts=0.7, row_trees=0.9, thickets=6.0, wild_trees=40,
        roundabout=0.15, lights=0.75, car_park=0.12, median=(0.0, 4.0), grade=0.012, strip=0.4, bank=0.1, paved=0.4,
    ),
    "retail": District(
        share=0.06, lanes=(1, 1, 2), lane_width=(3.0, 3.5), sidewalk=(1.5, 2.5), speed=50 / 3.6, bend=0.2, junction=0.3,
        parked=0.1, traffic_gap=40.0, heavy=0.08, people=0.3,
        built=0.6, blocks=0.25, setback=(6.0, 14.0), gap=(6.0, 25.0),
        fronts=0.6, row_trees=0.65, thickets=5.0, wild_trees=32,
        roundabout=0.12, lights=0.4, car_park=1.0, strip=0.3, ditch=0.1, bank=0.1, paved=0.35,
    ),
    "country": District(
        share=0.10, lanes=(1, 1, 1, 2), lane_width=(2.75, 3.75), sidewalk=(0.0, 0.0), speed=100 / 3.6, bend=0.6,
        junction=0.3, parked=0.02, traffic_gap=70.0, heavy=0.07, people=0.1,
        built=0.18, blocks=0.0, setback=(8.0, 22.0), gap=(8.0, 40.0),
        fronts=0.4, row_trees=0.6, thickets=7.0, wild_trees=65,
        roundabout=0.35, grade=0.025, hillside=0.06, rolling=0.6, ditch=0.5, bank=0.4,
    ),
    "motorway": District(
        share=0.07, lanes=(2, 2, 3), lane_width=(3.5, 3.75), sidewalk=(0.0, 0.0), speed=130 / 3.6, bend=0.6,
        junction=0.0, parked=0.0, traffic_gap=50.0, heavy=0.15, people=0.0,
        built=0.05, blocks=0.2, setback=(20.0, 40.0), gap=(15.0, 60.0),
        fronts=0.0, row_trees=0.0, thickets=8.0, wild_trees=60,
        median=(2.5, 4.0), shoulder=2.5, curvature=(0.0003, 0.002), grade=0.014, hillside=0.05, rolling=0.5, ditch=0.35,
        bank=0.5,
    ),
}  # fmt: skip


def sample_road(
    district: District,
    parking: tuple[int, ...],
    half_length: float,
    rng: np.random.Generator,
    *,
    oneway: bool = False,
    car_park: bool = False,
) -> Road:
    """A road through the quarter, with parking bays on the sides in `parking`; it is straight beside a `lot`."""
    lanes = 1 if oneway else district.lanes[int(rng.integers(len(district.lanes)))]
    width = rng.uniform(*district.lane_width)
    if oneway:
        # RASt 06: 3.0 to 3.5 m between parked cars, and now and then room for two lanes
        width = max(2.0, rng.uniform(3.5, 4.2) / 2) if rng.random() < 0.7 else width
    if lanes == 1:
        width += PARKING_STRIP * len(parking) / 2
    sidewalk = rng.uniform(*district.sidewalk)
    median = rng.uniform(*district.median) if lanes > 1 else 0.0
    median = median if median > 1.5 else 0.0
    junction, roundabout_radius, curvature = None, None, 0.0
    side_roads: tuple[int, ...] = (LEFT, RIGHT)
    if rng.random() < district.junction:
        # a side road leaves at a right angle, so the road is straight there
        junction = float(rng.uniform(-0.4, 0.4) * half_length)
        side_roads = ((LEFT, RIGHT), (LEFT,), (RIGHT,))[int(rng.integers(3))]
        smallest = median / 2 + lanes * width + sidewalk + RING + 1.5
        # outer diameters of 26 to 50 m: the German guide to roundabouts (FGSV 242)
        if not car_park and rng.random() < district.roundabout and smallest < 25.0:
            roundabout_radius = rng.uniform(max(13.0, smallest), 25.0)
            junction *= 0.6
            median = 0.0
    elif not car_park and rng.random() < district.bend:
        low, high = district.curvature
        curvature = float(rng.choice((-1, 1)) * rng.uniform(low, min(high, 1.6 / half_length)))
    return Road(
        lanes=lanes,
        lane_width=width,
        parking=district.shoulder,
        sidewalk=sidewalk,
        curvature=curvature,
        junction=junction,
        side_roads=side_roads,
        half_length=half_length,
        median=median,
        roundabout_radius=roundabout_radius,
    )
