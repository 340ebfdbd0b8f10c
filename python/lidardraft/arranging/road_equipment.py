"""Equipment of roads: traffic lights, guard rails, noise walls, sign bridges, delineators, road works."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.arranging.district import District
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.sizes import (
    CONE,
    DELINEATOR,
    MESH_FENCE_WIDTH,
    TRAFFIC_LIGHT,
    TRAFFIC_LIGHT_CLEARANCE,
    Range,
)
from lidardraft.scene.road import SIDES

# Width across and height [m]: a steel rail is 0.75 m high and some 0.3 m deep (EN 1317, system ESP); a concrete barrier
# 0.9 m high, 0.6 m wide. Numbers without a source are estimates, here and below.
_RAIL, _CONCRETE = (0.3, 0.75), (0.6, 0.9)
_PIECE, _PIECE_SEAM = 12.0, 0.02  # m: steel rails are 4 m long; a piece here is several
_PIECE_JUNCTION = 2.0  # m to a junction
_CONCRETE_MEDIANS = 0.4  # share; the others have a rail along each side
_MEDIAN_RAIL = 0.5  # m from the edge of the median

# m from the edge of the road
_RAIL_OFF, _SHORT_RAIL_OFF = (0.5, 1.0), 0.65
_NOISE_WALL_OFF, _DEER_FENCE_OFF = (4.0, 7.0), (8.0, 12.0)
_NOISE_WALL, _NOISE_WALL_WIDTH, _DEER_FENCE = (2.5, 6.0), 0.25, 1.6  # m of height, m, m of height
_SHORT_RAIL_BEGINS, _SHORT_RAIL = (-1.0, 0.3), (30.0, 90.0)  # of the half length of the street, m

# Traffic lights.
_LIGHT_AHEAD, _LIGHT_OFF = 0.6, 0.5  # m behind the kerbs of the side road and of the road
_LIGHT_ANGLE = 0.1  # rad, deviation

# Sign bridges.
_GANTRY_CLEARANCE = 5.5  # m; the German guides want at least 4.7 m
_GANTRY_LENGTH, _GANTRY_HEIGHT = 1.0, 2.6  # m along the road, m over the clearance
_GANTRY_OUT, _GANTRY_IN = 1.6, 0.3  # m from the edge of the road, from the middle of the median
_GANTRY_PLACE = 0.7  # of the half length of the street, at most
_HALF_MEDIAN, _HALF_GANTRIES = 3.5, 0.6  # m of a median for bridges over one carriageway, and their share

_DELINEATORS = 50.0  # m between them (HLB: 50 m on straight roads)
_DELINEATOR_OFF, _DELINEATOR_JUNCTION = 0.5, 1.0  # m from the edge (HLB), m to a junction

# Road works: a taper of cones closes part of the lane.
_TAPER_BEGINS, _CONE_SPACING, _CONES = (-30.0, 10.0), (2.0, 4.0), (6, 13)  # m along, m, from and to before
_CLOSED, _FIRST_CONE, _TAPER = (1.0, 2.0), 0.3, 0.35  # m from the kerb: the part, the first cone, each further one


def place_traffic_lights(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """Traffic lights at the corners of the junction."""
    road = occupancy.road
    assert road.junction is not None
    for side, ahead in ((-1, -1), (1, 1), (-1, 1), (1, -1)):
        along = road.junction + ahead * (road.edge + _LIGHT_AHEAD)
        across = side * (road.edge + _LIGHT_OFF)
        angle = (math.pi if side < 0 else 0.0) + rng.normal(0.0, _LIGHT_ANGLE)
        size, clearance = TRAFFIC_LIGHT.sample(rng), TRAFFIC_LIGHT_CLEARANCE
        occupancy.place("traffic_light", along, across, size, angle=angle, clearance=clearance)


def place_road_equipment(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """The equipment along a road of the district."""
    equipment = district.equipment
    if equipment.median_barrier:
        _place_median_barrier(occupancy, rng)
    for side in SIDES:
        _place_barriers(occupancy, district, side, rng)
    if _happens(equipment.gantries, rng):
        _place_gantry(occupancy, rng)
    for side in SIDES:
        if _happens(equipment.short_rails, rng):
            _place_short_rail(occupancy, side, rng)
    if equipment.delineators:
        _place_delineators(occupancy, rng)
    if _happens(equipment.cones, rng):
        _place_cones(occupancy, rng)


def _happens(probability: float, rng: np.random.Generator) -> bool:
    """Whether an event happens; an impossible one draws no random number, so that districts stay independent."""
    return probability > 0.0 and bool(rng.random() < probability)


def _facing_road(side: int) -> float:
    """The angle of an object beside a carriageway that faces it with its left (+y)."""
    return math.pi if side > 0 else 0.0


def _place_median_barrier(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """One wall of concrete in the middle, or a rail along each side of the median."""
    half = occupancy.road.median / 2
    if rng.random() < _CONCRETE_MEDIANS:
        _place_run(occupancy, "barrier", 0.0, _CONCRETE)
    else:
        for side in SIDES:
            _place_run(occupancy, "barrier", side * (half - _MEDIAN_RAIL), _RAIL, angle=_facing_road(-side))


def _place_barriers(occupancy: Occupancy, district: District, side: int, rng: np.random.Generator) -> None:
    """Rails along the whole road, a noise wall, or a deer fence."""
    edge, equipment = occupancy.road.edge, district.equipment
    if _happens(equipment.rails, rng):
        across = side * (edge + rng.uniform(*_RAIL_OFF))
        _place_run(occupancy, "barrier", across, _RAIL, angle=_facing_road(side))
    if _happens(equipment.noise_walls, rng):
        across = side * (edge + rng.uniform(*_NOISE_WALL_OFF))
        _place_run(occupancy, "wall", across, (_NOISE_WALL_WIDTH, rng.uniform(*_NOISE_WALL)))
    elif _happens(equipment.deer_fences, rng):
        across = side * (edge + rng.uniform(*_DEER_FENCE_OFF))
        _place_run(occupancy, "mesh_fence", across, (MESH_FENCE_WIDTH, _DEER_FENCE))


def _place_short_rail(occupancy: Occupancy, side: int, rng: np.random.Generator) -> None:
    road = occupancy.road
    start = rng.uniform(*_SHORT_RAIL_BEGINS) * road.half_length
    span = (start, start + rng.uniform(*_SHORT_RAIL))
    _place_run(occupancy, "barrier", side * (road.edge + _SHORT_RAIL_OFF), _RAIL, span=span, angle=_facing_road(side))


def _place_run(
    occupancy: Occupancy,
    kind: str,
    across: float,
    section: tuple[float, float],
    *,
    span: Range | None = None,
    angle: float = 0.0,
) -> None:
    """Pieces of a `section` (width, height) [m], one after another over a `span` [m along] or the whole road.

    Their faces look to the left (+y) at an `angle` of 0.
    """
    road = occupancy.road
    width, height = section
    low, high = span or (-road.half_length, road.half_length)
    along, high = low, min(high, road.half_length)
    # the outer side of a bend is longer than its middle
    bend = 1 - road.curvature * across
    while along < high:
        length = min(occupancy.ground.level_length(along, _PIECE), high - along)
        size = (length * bend - _PIECE_SEAM, width, height)
        # a last piece shorter than a seam is left out
        if size[0] > 0 and not road.in_junction(along + length / 2, length / 2 + _PIECE_JUNCTION):
            occupancy.place(kind, along + length / 2, across, size, angle=angle, margin=0.0)
        along += length


def _place_gantry(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """A sign bridge over one carriageway or both; signs face the traffic under them."""
    road = occupancy.road
    along, out = rng.uniform(-_GANTRY_PLACE, _GANTRY_PLACE) * road.half_length, road.edge + _GANTRY_OUT
    width, across = 2 * out, 0.0
    if road.median > _HALF_MEDIAN and rng.random() < _HALF_GANTRIES:
        side = SIDES[int(rng.integers(2))]
        width = out - _GANTRY_IN
        across = side * (_GANTRY_IN + width / 2)
        angle = math.pi if side < 0 else 0.0
    else:
        angle = math.pi if rng.random() < 0.5 else 0.0
    size = (_GANTRY_LENGTH, width, _GANTRY_CLEARANCE + _GANTRY_HEIGHT)
    occupancy.place("gantry", along, across, size, angle=angle, clearance=_GANTRY_CLEARANCE, margin=0.0)


def _place_delineators(occupancy: Occupancy, rng: np.random.Generator) -> None:
    road = occupancy.road
    first = -road.half_length + rng.uniform(0.0, _DELINEATORS)
    for along in np.arange(first, road.half_length, _DELINEATORS).tolist():
        for side in SIDES:
            if not road.in_junction(along, _DELINEATOR_JUNCTION):
                across = side * (road.edge + _DELINEATOR_OFF)
                occupancy.place("pole", along, across, DELINEATOR.sample(rng), margin=0.0)


def _place_cones(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """Road works on one side of the road."""
    road, side = occupancy.road, SIDES[int(rng.integers(2))]
    along, spacing = rng.uniform(*_TAPER_BEGINS), rng.uniform(*_CONE_SPACING)
    closed = rng.uniform(*_CLOSED)
    for number in range(int(rng.integers(*_CONES))):
        if road.in_junction(along + number * spacing):
            return
        in_from_kerb = min(_FIRST_CONE + _TAPER * number, closed)
        occupancy.place("cone", along + number * spacing, side * (road.edge - in_from_kerb), CONE.sample(rng))
