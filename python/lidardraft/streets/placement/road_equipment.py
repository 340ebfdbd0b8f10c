"""What road authorities build: traffic lights, guard rails, noise walls, sign gantries, delineators, road works."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.streets.placement.district import SIDES
from lidardraft.streets.placement.gardens import piece_length
from lidardraft.streets.placement.occupancy import Occupancy

# A steel rail is 0.75 m high and some 0.3 m deep (EN 1317, system ESP); a concrete barrier 0.9 m high, 0.6 m wide.
_RAIL, _CONCRETE = (0.3, 0.75), (0.6, 0.9)
_GANTRY_CLEAR = 5.5  # m under a sign bridge; the German guides want at least 4.7 m
_DELINEATORS = 50.0  # m between them (HLB: 50 m on straight roads), 0.5 m from the edge, 1 m high


def place_traffic_lights(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """Traffic lights at the corners of the junction; the lens is 2.1 to 3.3 m over the sidewalk (RiLSA: over 2.1 m)."""
    road = occupancy.road
    assert road.junction is not None
    for side, ahead in ((-1, -1), (1, 1), (-1, 1), (1, -1)):
        angle = math.pi if side < 0 else 0.0
        along = road.junction + ahead * (road.edge + 0.6)
        across = side * (road.edge + 0.5)
        angle += rng.normal(0.0, 0.1)
        occupancy.place("traffic_light", along, across, (0.25, 0.32, 3.3), angle=angle, clearance=2.4)


def place_road_equipment(occupancy: Occupancy, district: str, rng: np.random.Generator) -> None:
    """What stands along a motorway or a country road; and road works anywhere."""
    road = occupancy.road
    if district == "motorway":
        _median(occupancy, rng)
        for side in SIDES:
            if rng.random() < 0.55:
                _row(occupancy, "barrier", side * (road.edge + rng.uniform(0.5, 1.0)), *_RAIL, angle=_to_road(side))
            if rng.random() < 0.4:
                _row(occupancy, "wall", side * (road.edge + rng.uniform(4.0, 7.0)), 0.25, rng.uniform(2.5, 6.0))
            elif rng.random() < 0.3:
                _row(occupancy, "mesh_fence", side * (road.edge + rng.uniform(8.0, 12.0)), 0.06, 1.6)
        if rng.random() < 0.5:
            _gantry(occupancy, rng)
    elif district == "country":
        for side in SIDES:
            if rng.random() < 0.25:
                start = rng.uniform(-1.0, 0.3) * road.half_length
                span = (start, start + rng.uniform(30.0, 90.0))
                _row(occupancy, "barrier", side * (road.edge + 0.65), *_RAIL, span=span, angle=_to_road(side))
    if district in ("motorway", "country"):
        _delineate(occupancy, rng)
    elif rng.random() < 0.06:
        _cones(occupancy, rng)


def _to_road(side: int) -> float:
    """The angle of what stands beside a carriageway and looks to it with its left (+y)."""
    return math.pi if side > 0 else 0.0


def _median(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """One wall of concrete in the middle, or a rail along each side of the median."""
    half = occupancy.road.median / 2
    if rng.random() < 0.4:
        _row(occupancy, "barrier", 0.0, *_CONCRETE)
    else:
        for side in SIDES:
            _row(occupancy, "barrier", side * (half - 0.5), *_RAIL, angle=_to_road(-side))


def _row(
    occupancy: Occupancy,
    kind: str,
    across: float,
    thick: float,
    height: float,
    *,
    span: tuple[float, float] | None = None,
    angle: float = 0.0,
) -> None:
    """Pieces one after another along the road, their faces to the left (+y) with a `angle` of 0.

    Steel rails come in lengths of 4 m; some of them make one piece here.
    """
    low, high = span or (-occupancy.road.half_length, occupancy.road.half_length)
    along, high = low, min(high, occupancy.road.half_length)
    # the outer side of a bend is longer than its middle
    bend = 1 - occupancy.road.curvature * across
    while along < high:
        length = min(piece_length(occupancy, along, 12.0), high - along)
        if not occupancy.road.in_junction(along + length / 2, length / 2 + 2.0):
            size = (length * bend - 0.02, thick, height)
            occupancy.place(kind, along + length / 2, across, size, angle=angle, margin=0.0)
        along += length


def _gantry(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """A sign bridge over one carriageway or both; signs face the traffic under them."""
    road = occupancy.road
    along, out = rng.uniform(-0.7, 0.7) * road.half_length, road.edge + 1.6
    size_over = (1.0, 2 * out, _GANTRY_CLEAR + 2.6)
    if road.median > 3.5 and rng.random() < 0.6:
        side = SIDES[int(rng.integers(2))]
        width = out - 0.3
        across = side * (0.3 + width / 2)
        angle = math.pi if side < 0 else 0.0
        occupancy.place(
            "gantry", along, across, (1.0, width, size_over[2]), angle=angle, clearance=_GANTRY_CLEAR, margin=0.0
        )
    else:
        angle = math.pi if rng.random() < 0.5 else 0.0
        occupancy.place("gantry", along, 0.0, size_over, angle=angle, clearance=_GANTRY_CLEAR, margin=0.0)


def _delineate(occupancy: Occupancy, rng: np.random.Generator) -> None:
    road = occupancy.road
    first = -road.half_length + rng.uniform(0.0, _DELINEATORS)
    for along in np.arange(first, road.half_length, _DELINEATORS).tolist():
        for side in SIDES:
            if not road.in_junction(along, 1.0):
                occupancy.place("pole", along, side * (road.edge + 0.5), (0.12, 0.12, 1.0), margin=0.0)


def _cones(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """Road works on one side: a taper of cones, 0.75 m high, 2 to 4 m apart, closes part of the lane."""
    road, side = occupancy.road, SIDES[int(rng.integers(2))]
    along, spacing = rng.uniform(-30.0, 10.0), rng.uniform(2.0, 4.0)
    closed = rng.uniform(1.0, 2.0)
    for number in range(int(rng.integers(6, 13))):
        if road.in_junction(along + number * spacing):
            return
        in_from_kerb = min(0.3 + 0.35 * number, closed)
        occupancy.place("cone", along + number * spacing, side * (road.edge - in_from_kerb), (0.36, 0.36, 0.75))
