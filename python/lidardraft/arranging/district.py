"""The kinds of district for streets, and the road through one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lidardraft.arranging.relief import Land
from lidardraft.arranging.sizes import Range
from lidardraft.errors import check_choice
from lidardraft.scene.road import LEFT, PARKING_STRIP, RIGHT, RING, SIDES, Road

FAST, CALM = 25.0, 10.0  # m/s: over 90 km/h on motorways and country roads, under 36 km/h in 30 km/h zones

_ONE_WAY = (3.5, 4.2)  # m of a narrow one-way street; RASt 06: 3.0 to 3.5 m between parked cars
_NARROW = 0.7  # share of one-way streets; the others have room for two lanes: an estimate
_LEAST_LANE = 2.0  # m
_LEAST_MEDIAN = 1.5  # m, a narrower one is left out: an estimate
_JUNCTION = 0.4  # of the half length, from the middle to a junction at most: an estimate
_ROUNDABOUT = 0.6  # of that for a roundabout: an estimate
_RADII = (13.0, 25.0)  # m, outer: diameters of 26 to 50 m in the German guide to roundabouts (FGSV 242)
_CORNERS = 1.5  # m that the corners around a roundabout need: an estimate
_MOST_BEND = 1.6  # rad that half of a street turns at most, so that it does not come back to itself


@dataclass(frozen=True, kw_only=True, slots=True)
class RoadEquipment:
    """The equipment that road authorities put along the roads of a district, as probabilities.

    `median_barrier` is a barrier in the median. `rails` (a side) are guard rails along the whole road, `short_rails` (a
    side) along a part of it. `noise_walls` are a side, `deer_fences` a side without a noise wall, `gantries` a sign
    bridge. `delineators` is whether the road has them. `cones` are road works.
    """

    median_barrier: bool = False
    rails: float = 0.0
    noise_walls: float = 0.0
    deer_fences: float = 0.0
    gantries: float = 0.0
    short_rails: float = 0.0
    delineators: bool = False
    cones: float = 0.06


@dataclass(frozen=True, kw_only=True, slots=True)
class District:
    """The properties that streets of one kind share.

    Pairs are ranges [m]. `share` is that of all streets, `heavy` that of trucks and buses in the traffic, `blocks` that
    of blocks among the buildings. Probabilities of the road are `bend`, `junction`, `roundabout`, `lights` (of
    junctions), `oneway`, `car_park`, `parked` (a side) and `strip` (of grass beside the kerb). Those beside it are
    `paved` (the land), `built` (a plot), `front_fences` (a side), `green` (of fences: hedges), `street_trees` (a side)
    and `adjoining` (a block to the next in closed fronts). `people`, `thickets` (a side) and `wild_trees` are mean
    numbers; `traffic_gap` is a mean [m]. `speed` is the limit [m/s], `riders` a factor of the usual number of riders.
    `shoulder` is the width of a hard shoulder [m], `curvature` a range [1/m]. `short_front` is the length [m] of the
    blocks that close a front without room for longer ones.
    """

    share: float
    lanes: tuple[int, ...]
    lane_width: Range
    sidewalk: Range
    speed: float
    bend: float
    junction: float
    parked: float
    traffic_gap: float
    heavy: float
    people: float
    built: float
    blocks: float
    setback: Range
    gap: Range
    front_fences: float
    green: float
    street_trees: float
    thickets: float
    wild_trees: int
    land: Land
    roundabout: float = 0.0
    lights: float = 0.0
    oneway: float = 0.0
    car_park: float = 0.0
    median: Range = (0.0, 0.0)
    shoulder: float = 0.0
    curvature: Range = (0.001, 0.009)
    strip: float = 0.0
    paved: float = 0.0
    adjoining: float = 0.72
    short_front: float = 10.0
    riders: float = 1.0
    equipment: RoadEquipment = RoadEquipment()

    @property
    def closed_fronts(self) -> bool:
        """Whether its buildings stand wall to wall."""
        return self.gap[1] == 0.0

    @property
    def front_gardens(self) -> bool:
        """Whether there is land between the sidewalk and the buildings."""
        return self.setback[1] > 2.0

    @property
    def built_up(self) -> bool:
        """Whether most plots have a building."""
        return self.built > 0.5


# Guard rails, walls, fences, sign bridges and road works: estimates.
_MOTORWAY = RoadEquipment(
    median_barrier=True, rails=0.55, noise_walls=0.4, deer_fences=0.3, gantries=0.5, delineators=True, cones=0.0
)
_COUNTRY_ROAD = RoadEquipment(short_rails=0.25, delineators=True, cones=0.0)

# Lane widths: the German design guides RASt 06 (3.0 to 3.5 m in towns), RAL (3.25 to 3.75 m outside) and RAA (3.5 to
# 3.75 m on motorways, median 4 m, hard shoulder 2.5 m). Sidewalks: RASt 06, 2.5 m and more if there is room.
# Heavy vehicles: the German road census of 2021 (BASt), 15 % of the traffic on motorways, 7 % on federal roads; fewer
# in towns. People, cars and plants: such that their shares of the returns lie between those of PandaSet and the class
# frequencies published with SemanticKITTI (cars 21 and 4 %, vegetation 13 and 27 %, people 0.2 and 0.05 %). Speeds:
# StVO. Grades stay under the limits of RASt 06 and RAL, 4.5 to 8 %. The shares of districts, and probabilities and
# numbers without a source, are estimates.
DISTRICTS: dict[str, District] = {
    "residential": District(
        share=0.44, lanes=(1,), lane_width=(2.5, 3.25), sidewalk=(1.5, 3.0), speed=30 / 3.6, bend=0.5, junction=0.45,
        parked=0.25, traffic_gap=70.0, heavy=0.015, people=0.6,
        built=0.82, blocks=0.1, setback=(3.5, 11.0), gap=(2.5, 9.0),
        front_fences=0.95, green=0.88, street_trees=0.7, thickets=5.5, wild_trees=52,
        roundabout=0.14, oneway=0.12, car_park=0.04, strip=0.15,
        land=Land(grade=0.036, hillside=0.035, bank=0.3),
    ),
    "urban": District(
        share=0.18, lanes=(1, 1, 2), lane_width=(2.75, 3.25), sidewalk=(2.2, 5.5), speed=50 / 3.6, bend=0.2,
        junction=0.55, parked=0.4, traffic_gap=40.0, heavy=0.035, people=1.5,
        built=0.95, blocks=0.95, setback=(0.0, 0.4), gap=(0.0, 0.0),
        front_fences=0.8, green=0.2, adjoining=0.62, street_trees=0.8, thickets=0.6, wild_trees=26,
        roundabout=0.08, lights=0.6, oneway=0.35, car_park=0.06, paved=0.7,
        land=Land(grade=0.025, hillside=0.015, rolling=0.1),
    ),
    "avenue": District(
        share=0.15, lanes=(2, 2, 3), lane_width=(3.0, 3.5), sidewalk=(2.0, 4.0), speed=50 / 3.6, bend=0.25,
        junction=0.5, parked=0.2, traffic_gap=60.0, heavy=0.035, people=1.1,
        built=0.75, blocks=0.65, setback=(1.5, 7.0), gap=(1.0, 12.0),
        front_fences=0.9, green=0.2, street_trees=0.9, thickets=6.0, wild_trees=40,
        roundabout=0.15, lights=0.75, car_park=0.12, median=(0.0, 4.0), strip=0.4, paved=0.4,
        land=Land(grade=0.022, bank=0.1),
    ),
    "retail": District(
        share=0.06, lanes=(1, 1, 2), lane_width=(3.0, 3.5), sidewalk=(1.5, 2.5), speed=50 / 3.6, bend=0.2, junction=0.3,
        parked=0.1, traffic_gap=40.0, heavy=0.08, people=0.9,
        built=0.6, blocks=0.25, setback=(6.0, 14.0), gap=(6.0, 25.0),
        front_fences=0.75, green=0.2, street_trees=0.65, thickets=5.0, wild_trees=32,
        roundabout=0.12, lights=0.4, car_park=1.0, strip=0.3, paved=0.35,
        land=Land(ditch=0.1, bank=0.1),
    ),
    "country": District(
        share=0.10, lanes=(1, 1, 1, 2), lane_width=(2.75, 3.75), sidewalk=(0.0, 0.0), speed=100 / 3.6, bend=0.6,
        junction=0.3, parked=0.02, traffic_gap=70.0, heavy=0.07, people=0.2,
        built=0.18, blocks=0.0, setback=(8.0, 22.0), gap=(8.0, 40.0),
        front_fences=0.4, green=0.7, street_trees=0.6, thickets=7.0, wild_trees=65,
        roundabout=0.35,
        land=Land(grade=0.045, hillside=0.06, rolling=0.6, ditch=0.5, bank=0.4),
        equipment=_COUNTRY_ROAD,
    ),
    "motorway": District(
        share=0.07, lanes=(2, 2, 3), lane_width=(3.5, 3.75), sidewalk=(0.0, 0.0), speed=130 / 3.6, bend=0.6,
        junction=0.0, parked=0.0, traffic_gap=50.0, heavy=0.15, people=0.0,
        built=0.05, blocks=0.2, setback=(20.0, 40.0), gap=(15.0, 60.0),
        front_fences=0.0, green=0.7, street_trees=0.0, thickets=8.0, wild_trees=60,
        median=(2.5, 4.0), shoulder=2.5, curvature=(0.0003, 0.002),
        land=Land(grade=0.025, hillside=0.05, rolling=0.5, ditch=0.35, bank=0.5),
        equipment=_MOTORWAY,
    ),
}  # fmt: skip

_URBAN, _RESIDENTIAL, _RETAIL, _COUNTRY = (DISTRICTS[name] for name in ("urban", "residential", "retail", "country"))
# The districts that a sentence can ask for: those above, and variants. All numbers are estimates.
SETTINGS: dict[str, District] = {
    **DISTRICTS,
    "urban": replace(_URBAN, setback=(0.5, 3.0), street_trees=0.9, wild_trees=40),  # sidewalks of sentences are narrow
    "alley": replace(
        _URBAN,
        lanes=(1,),
        lane_width=(2.6, 3.0),
        sidewalk=(0.0, 0.0),
        setback=(0.1, 0.4),
        street_trees=0.0,
        wild_trees=4,
        thickets=0.0,
        traffic_gap=120.0,
        adjoining=0.93,
        short_front=3.0,
    ),
    "village": replace(_RESIDENTIAL, setback=(1.0, 6.0), gap=(1.0, 7.0), built=0.75, front_fences=0.8),
    "industrial": replace(_RETAIL, blocks=1.0, built=0.75, heavy=0.35, people=0.3, street_trees=0.3, wild_trees=14),
    "forest": replace(_COUNTRY, built=0.0, front_fences=0.0, street_trees=0.0, thickets=14.0, wild_trees=240),
    "school": replace(_RESIDENTIAL, people=3.5, blocks=0.7, setback=(6.0, 14.0)),
    "roadworks": replace(_URBAN, equipment=RoadEquipment(cones=1.0)),
}
STREET_DISTRICTS = {**SETTINGS, **DISTRICTS}  # districts that streets can ask for


def setting(name: str) -> District:
    """One of SETTINGS; raises `LayoutError` for another name, such as from a file."""
    check_choice("intent: district", name, SETTINGS)
    return SETTINGS[name]


def only_district(road: Road, kind: str | None) -> str | None:
    """The only district that fits a road of a spec's `kind`, or None if several fit."""
    if road.paved_areas:
        return "retail"
    if road.sidewalk == 0:
        return "motorway" if road.median > 0 or kind == "motorway" else "country"
    return None


def sample_road(
    district: District,
    parking: tuple[int, ...],
    half_length: float,
    rng: np.random.Generator,
    *,
    oneway: bool = False,
    car_park: bool = False,
) -> Road:
    """A road through the district, with parked cars on the sides in `parking`; it is straight beside a car park."""
    lanes = 1 if oneway else district.lanes[int(rng.integers(len(district.lanes)))]
    width = rng.uniform(*district.lane_width)
    if oneway:
        width = max(_LEAST_LANE, rng.uniform(*_ONE_WAY) / 2) if rng.random() < _NARROW else width
    if lanes == 1:
        width += PARKING_STRIP * len(parking) / 2
    sidewalk = rng.uniform(*district.sidewalk)
    median = rng.uniform(*district.median) if lanes > 1 else 0.0
    median = median if median > _LEAST_MEDIAN else 0.0
    junction, radius, curvature = None, None, 0.0
    side_roads: tuple[int, ...] = (LEFT, RIGHT)
    if rng.random() < district.junction:
        # a side road leaves at a right angle, so the road is straight there
        junction = float(rng.uniform(-_JUNCTION, _JUNCTION) * half_length)
        side_roads = ((LEFT, RIGHT), (LEFT,), (RIGHT,))[int(rng.integers(3))]
        smallest = median / 2 + lanes * width + sidewalk + RING + _CORNERS
        if not car_park and rng.random() < district.roundabout and smallest < _RADII[1]:
            radius = rng.uniform(max(_RADII[0], smallest), _RADII[1])
            junction *= _ROUNDABOUT
            median = 0.0
    elif not car_park and rng.random() < district.bend:
        low, high = district.curvature
        curvature = float(rng.choice(SIDES) * rng.uniform(low, min(high, _MOST_BEND / half_length)))
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
        roundabout_radius=radius,
    )
