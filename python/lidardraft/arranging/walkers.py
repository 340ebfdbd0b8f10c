"""People on foot: walking, standing together, waiting at stops and lights, crossing."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.arranging.district import District
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.sizes import sample_person
from lidardraft.scene.road import SIDES

# All numbers are estimates.
_MARGIN = 0.05  # m
_AT_STOP = 1.5  # mean number of people waiting at a bus stop
# Walkers per standing group, per crossing person, and per person waiting at each corner with lights
_GROUPS, _CROSSING, _WAITING = 0.7, 2.2, 4.5
_MOST_WAITING = 1.0  # mean number at a corner, at most

# On the sidewalks.
_ENDS = 0.8  # of the half length of the street, at most
_EDGE = 0.6  # m to both edges of the sidewalk
_LEAST_ROOM = 1.2  # m from the kerb, if the sidewalk is narrow or missing
_IN_COMPANY, _IN_THREES = 0.3, 0.1  # shares of people with a companion, and with one more
_SIDE_BY_SIDE = 0.65  # m between them
_OFF_WAY = 0.2  # rad against the street, deviation

# Groups in a ring.
_GROUP = (2, 5)  # people: from, to before
_GROUP_AHEAD = (0.22, 0.5)  # of the half length, either way from the middle of the street, near which scans are made
_RING, _RING_EACH = 0.35, 0.12  # m of its radius: a constant, and a part for each person
_OFF_RING = 0.15  # rad off even places, deviation
_GROUP_KERB = 0.3  # m behind the kerb, at least
_GROUP_JUNCTION = 1.0  # m to a junction
_GROUP_MARGIN = 0.03  # m

# At a bus stop.
_STOP_KERB, _STOP_BACK = 0.5, 1.9  # m to the kerb, and to the back of the sidewalk with the shelter
_STOP_ROOM = 0.9  # m from the kerb, if the sidewalk is narrow
_STOP_SPREAD = 2.0  # m along, deviation
_STOP_OFF = 0.6  # rad off looking to the road, deviation

# People who cross.
_CROSSING_SPREAD = 25.0  # m along from the middle of a street without a junction, deviation
_OFF_CORNER = 0.8  # m from the corner, deviation
_OFF_CROSSING = 0.15  # rad off the straight way, deviation

# People who wait at a corner with lights.
_CORNER, _CORNER_BACK, _CORNER_LEAST = 1.0, 0.3, 1.3  # m behind the kerb of the side road, before the verge, at least
_CORNER_KERB = (0.5, 1.0)  # m behind the kerb of the road
_OFF_WAITING = 0.3  # rad off the way across, deviation


def place_people(occupancy: Occupancy, district: District, lights: bool, rng: np.random.Generator) -> None:
    """People on the sidewalks, alone or together, and some who cross the road."""
    for _ in range(rng.poisson(district.people)):
        _place_walkers(occupancy, rng)
    for _ in range(rng.poisson(district.people / _GROUPS)):
        ahead = (1 if rng.random() < 0.5 else -1) * rng.uniform(*_GROUP_AHEAD) * occupancy.road.half_length
        spot = (ahead, _spot(occupancy, rng)[1])
        _place_group(occupancy, spot, int(rng.integers(*_GROUP)), rng)
    for along, side in occupancy.stops:
        _place_at_stop(occupancy, along, side, rng)
    for _ in range(rng.poisson(district.people / _CROSSING)):
        _place_crossing(occupancy, rng)
    if lights:
        _place_waiting(occupancy, district, rng)


def _spot(occupancy: Occupancy, rng: np.random.Generator) -> tuple[float, float]:
    """A random place on a sidewalk, along and across [m]."""
    road = occupancy.road
    low, high = road.edge + _EDGE, max(road.verge - _EDGE, road.edge + _LEAST_ROOM)
    return rng.uniform(-_ENDS, _ENDS) * road.half_length, SIDES[int(rng.integers(2))] * rng.uniform(low, high)


def _place_walkers(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """One to three people side by side."""
    along, across = _spot(occupancy, rng)
    road = occupancy.road
    angle = (0.0 if rng.random() < 0.5 else math.pi) + rng.normal(0.0, _OFF_WAY)
    inward = -_SIDE_BY_SIDE if abs(across) > (road.edge + road.verge) / 2 else _SIDE_BY_SIDE
    for companion in range(1 + int(rng.random() < _IN_COMPANY) + int(rng.random() < _IN_THREES)):
        beside = across + companion * math.copysign(inward, inward * across)
        if not road.in_junction(along):
            size = sample_person(rng, standing=False)
            occupancy.place("person", along, beside, size, angle=angle, margin=_MARGIN)


def _place_group(occupancy: Occupancy, spot: tuple[float, float], count: int, rng: np.random.Generator) -> None:
    """A group in a ring that faces its middle."""
    if occupancy.road.in_junction(spot[0], _GROUP_JUNCTION):
        return
    first, radius = rng.uniform(0.0, 2 * math.pi), _RING + _RING_EACH * count
    for number in range(count):
        heading = first + number * 2 * math.pi / count + rng.normal(0.0, _OFF_RING)
        along, across = spot[0] + radius * math.cos(heading), spot[1] + radius * math.sin(heading)
        if abs(across) > occupancy.road.edge + _GROUP_KERB:
            size = sample_person(rng, standing=True)
            occupancy.place("person", along, across, size, angle=heading + math.pi, margin=_GROUP_MARGIN)


def _place_at_stop(occupancy: Occupancy, along: float, side: float, rng: np.random.Generator) -> None:
    """People who wait for a bus and face the road."""
    road = occupancy.road
    for _ in range(rng.poisson(_AT_STOP)):
        across = side * (road.edge + rng.uniform(_STOP_KERB, max(_STOP_ROOM, road.sidewalk - _STOP_BACK)))
        angle = -side * math.pi / 2 + rng.normal(0.0, _STOP_OFF)
        size = sample_person(rng, standing=True)
        occupancy.place("person", along + rng.normal(0.0, _STOP_SPREAD), across, size, angle=angle, margin=_MARGIN)


def _place_crossing(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """A person who crosses the road, at a corner of the junction if there is one."""
    road = occupancy.road
    if road.junction is None:
        along = rng.normal(0.0, _CROSSING_SPREAD)
    else:
        corner = road.verge if road.roundabout_radius is None else road.roundabout_radius + road.sidewalk
        along = road.junction + corner * (1 if rng.random() < 0.5 else -1)
    along += rng.normal(0.0, _OFF_CORNER)
    angle = (1 if rng.random() < 0.5 else -1) * math.pi / 2 + rng.normal(0.0, _OFF_CROSSING)
    size = sample_person(rng, standing=False)
    occupancy.place("person", along, rng.uniform(-road.edge, road.edge), size, angle=angle)


def _place_waiting(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """People at the corners of a junction with lights, facing across."""
    road = occupancy.road
    assert road.junction is not None
    for side in SIDES:
        for ahead in SIDES:
            for _ in range(rng.poisson(min(district.people / _WAITING, _MOST_WAITING))):
                behind = rng.uniform(_CORNER, max(_CORNER_LEAST, road.sidewalk - _CORNER_BACK))
                along = road.junction + ahead * (road.edge + behind)
                across = side * (road.edge + rng.uniform(*_CORNER_KERB))
                angle = -side * math.pi / 2 + rng.normal(0.0, _OFF_WAITING)
                size = sample_person(rng, standing=True)
                occupancy.place("person", along, across, size, angle=angle, margin=_MARGIN)
