"""People on foot: walking, standing together, waiting at stops and lights, crossing."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.streets.placement.district import SIDES, District
from lidardraft.streets.placement.occupancy import Occupancy

_STANDING = 0.28  # m, the length of one who stands


def person_size(rng: np.random.Generator, *, standing: bool) -> tuple[float, float, float]:
    """Extents of a person: the length is that of the stride, at most 0.3 m of one who stands."""
    # stature of adults, 1.72 +- 0.09 m (NCD-RisC, 2016, Europe), and some children
    height = rng.normal(1.72, 0.09) if rng.random() < 0.9 else rng.uniform(1.0, 1.45)
    height = min(max(height, 1.0), 2.0)
    stride = _STANDING if standing else rng.uniform(0.35, 0.7) * height / 1.72
    return stride, 0.28 * height, height


def place_people(occupancy: Occupancy, district: District, lights: bool, rng: np.random.Generator) -> None:
    """People on the sidewalks, alone or together, and some who cross the road."""
    for _ in range(rng.poisson(district.people)):
        _walkers(occupancy, rng)
    for _ in range(rng.poisson(district.people / 5)):
        _cluster(occupancy, _spot(occupancy, rng), int(rng.integers(2, 5)), rng)
    for along, side in occupancy.stops:
        for _ in range(rng.poisson(1.5)):
            across = side * (occupancy.road.edge + rng.uniform(0.5, max(0.9, occupancy.road.sidewalk - 1.9)))
            angle = -side * math.pi / 2 + rng.normal(0.0, 0.6)
            size = person_size(rng, standing=True)
            occupancy.place("person", along + rng.normal(0.0, 2.0), across, size, angle=angle, margin=0.05)
    for _ in range(rng.poisson(district.people / 8)):
        _crosser(occupancy, rng)
    if lights:
        _waiting(occupancy, district, rng)


def _spot(occupancy: Occupancy, rng: np.random.Generator) -> tuple[float, float]:
    road = occupancy.road
    low, high = road.edge + 0.6, max(road.verge - 0.6, road.edge + 1.2)
    return rng.normal(0.0, 30.0), SIDES[int(rng.integers(2))] * rng.uniform(low, high)


def _walkers(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """One to three side by side; three in ten walk in company: an estimate of ours."""
    along, across = _spot(occupancy, rng)
    road = occupancy.road
    angle = (0.0 if rng.random() < 0.5 else math.pi) + rng.normal(0.0, 0.2)
    inward = -0.65 if abs(across) > (road.edge + road.verge) / 2 else 0.65
    for companion in range(1 + int(rng.random() < 0.3) + int(rng.random() < 0.1)):
        beside = across + companion * math.copysign(inward, inward * across)
        if not road.in_junction(along):
            occupancy.place("person", along, beside, person_size(rng, standing=False), angle=angle, margin=0.05)


def _cluster(occupancy: Occupancy, spot: tuple[float, float], count: int, rng: np.random.Generator) -> None:
    """A group that stands in a ring and looks to its middle."""
    if occupancy.road.in_junction(spot[0], 1.0):
        return
    first, radius = rng.uniform(0.0, 2 * math.pi), 0.35 + 0.12 * count
    for number in range(count):
        heading = first + number * 2 * math.pi / count + rng.normal(0.0, 0.15)
        along, across = spot[0] + radius * math.cos(heading), spot[1] + radius * math.sin(heading)
        if abs(across) > occupancy.road.edge + 0.3:
            size = person_size(rng, standing=True)
            occupancy.place("person", along, across, size, angle=heading + math.pi, margin=0.03)


def _crosser(occupancy: Occupancy, rng: np.random.Generator) -> None:
    road = occupancy.road
    gap = road.verge if road.roundabout_radius is None else road.roundabout_radius + road.sidewalk
    along = (
        road.junction + gap * (1 if rng.random() < 0.5 else -1) if road.junction is not None else rng.normal(0.0, 25.0)
    )
    along += rng.normal(0.0, 0.8)
    angle = (1 if rng.random() < 0.5 else -1) * math.pi / 2 + rng.normal(0.0, 0.15)
    size = person_size(rng, standing=False)
    occupancy.place("person", along, rng.uniform(-road.edge, road.edge), size, angle=angle)


def _waiting(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """People at the corners of a junction with lights, who look across."""
    road = occupancy.road
    assert road.junction is not None
    for side in SIDES:
        for ahead in SIDES:
            for _ in range(rng.poisson(min(district.people / 8, 1.0))):
                along = road.junction + ahead * (road.edge + rng.uniform(1.0, max(1.3, road.sidewalk - 0.3)))
                across = side * (road.edge + rng.uniform(0.5, 1.0))
                angle = -side * math.pi / 2 + rng.normal(0.0, 0.3)
                size = person_size(rng, standing=True)
                occupancy.place("person", along, across, size, angle=angle, margin=0.05)
