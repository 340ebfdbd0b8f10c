"""Car parks: rows of bays beside the road, with an aisle between two rows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.sizes import LAMP_WIDTH, sample_person
from lidardraft.objects.cars import sample_car
from lidardraft.scene.road import LEFT, RIGHT, PavedArea, Road

# EAR 05 and RASt 06: bays of 2.5 x 5.0 m at right angles to an aisle of 6.0 m.
BAY_WIDTH, BAY_LENGTH, AISLE_WIDTH = 2.5, 5.0, 6.0
_MODULE = 2 * BAY_LENGTH + AISLE_WIDTH  # m, two rows of bays and the aisle between
# Estimates.
ACCESS_WIDTH = 6.0  # m of the way in
_SHORTEST = (26.0, 30.0)  # m of a car park at least, and the least upper limit of its length
_LONGEST, _LONGEST_SHARE = 70.0, 0.7  # m, and of the half length of the street
_BEGINS = (-0.75, -0.25)  # its start, in shares of its length from the middle of the street
_TO_SIDE_ROAD = 3.0  # m
_TO_VERGE = (0.6, 4.0)  # m
_GATE = (0.1, 0.9)  # the way in, in shares of the length
_OCCUPIED = (0.1, 0.65)  # share of the bays
_NOSE_IN = 0.75  # share of the cars
_ASKEW = 0.03  # rad, deviation
_OFF_MIDDLE = 0.12  # m along from the middle of a bay, deviation
_FORWARD = (-0.1, 0.4)  # m toward the aisle
_CAR_MARGIN = 0.05  # m
_LIT = 0.5  # share of the edges with lamps
_LAMP_HEIGHT, _LAMP_LENGTH = (4.5, 8.0), 0.15  # m
_FIRST_LAMP, _LAMP_SPACING, _LAMP_OFF = 5.0, (16.0, 24.0), 0.5  # m from the end, between two, off the edge
_LAMP_ANGLE = (0.0, 3.0)  # rad
_ANY_WAY = 6.28  # rad, once around
_WALKERS = 2.0  # mean number
_WALKER_OFF, _WALKER_MARGIN = 2.0, 0.1  # m off the middle of an aisle at most


@dataclass(frozen=True, kw_only=True, slots=True)
class CarPark:
    """A car park beside the road, on its `side`: cars stand on `paved_area`.

    The way in is `access`, with its middle at `gate` [m along]. `aisles` [m across] are driven. `rows` hold bays: the
    middle across [m], and the side of it on which the aisle lies.
    """

    side: int
    paved_area: PavedArea
    access: PavedArea
    gate: float
    aisles: tuple[float, ...]
    rows: tuple[tuple[float, int], ...]


def sample_car_park(road: Road, modules: int, rng: np.random.Generator) -> CarPark:
    """A car park of `modules` double rows, near the middle of a straight road and clear of its side roads."""
    side = LEFT if rng.random() < 0.5 else RIGHT
    length = rng.uniform(_SHORTEST[0], max(_SHORTEST[1], min(_LONGEST, _LONGEST_SHARE * road.half_length)))
    start = rng.uniform(*_BEGINS) * length
    if road.junction is not None:
        if len(road.side_roads) == 1:
            side = -road.side_roads[0]
        else:
            clear = road.verge + _TO_SIDE_ROAD
            start = road.junction + clear if road.junction < 0 else road.junction - clear - length
    near = road.verge + rng.uniform(*_TO_VERGE)
    far = near + modules * _MODULE
    gate = start + rng.uniform(*_GATE) * (length - ACCESS_WIDTH) + ACCESS_WIDTH / 2
    aisles, rows = [], []
    for module in range(modules):
        first = near + module * _MODULE
        aisles.append(side * (first + _MODULE / 2))
        rows.append((side * (first + BAY_LENGTH / 2), side))
        rows.append((side * (first + _MODULE - BAY_LENGTH / 2), -side))
    return CarPark(
        side=side,
        paved_area=PavedArea((start, start + length), (near, far) if side > 0 else (-far, -near)),
        access=PavedArea(
            (gate - ACCESS_WIDTH / 2, gate + ACCESS_WIDTH / 2), (road.edge, near) if side > 0 else (-near, -road.edge)
        ),
        gate=gate,
        aisles=tuple(aisles),
        rows=tuple(rows),
    )


def place_in_car_park(occupancy: Occupancy, car_park: CarPark, rng: np.random.Generator) -> None:
    """Cars in the bays, lamps along the edges, people on the way."""
    _place_cars(occupancy, car_park, rng)
    for edge in car_park.paved_area.across:
        if rng.random() < _LIT:
            _place_lamps(occupancy, car_park, edge, rng)
    for _ in range(rng.poisson(_WALKERS)):
        along = rng.uniform(*car_park.paved_area.along)
        across = car_park.aisles[int(rng.integers(len(car_park.aisles)))]
        size = sample_person(rng, standing=False)
        across += rng.uniform(-_WALKER_OFF, _WALKER_OFF)
        angle = rng.uniform(0.0, _ANY_WAY)
        occupancy.place("person", along, across, size, angle=angle, margin=_WALKER_MARGIN)


def _place_cars(occupancy: Occupancy, car_park: CarPark, rng: np.random.Generator) -> None:
    """Cars in the bays, with the nose or the rear to the aisle."""
    occupied = rng.uniform(*_OCCUPIED)
    start, end = car_park.paved_area.along
    for across, toward in car_park.rows:
        for bay in range(int((end - start) / BAY_WIDTH)):
            along = start + (bay + 0.5) * BAY_WIDTH
            if abs(along - car_park.gate) < (ACCESS_WIDTH + BAY_WIDTH) / 2 or rng.random() > occupied:
                continue
            kind, size = sample_car(rng)
            heading = -toward if rng.random() < _NOSE_IN else toward
            angle = heading * math.pi / 2 + rng.normal(0.0, _ASKEW)
            middle = along + rng.normal(0.0, _OFF_MIDDLE)
            forward = across + toward * rng.uniform(*_FORWARD)
            occupancy.place(kind, middle, forward, size, angle=angle, margin=_CAR_MARGIN)


def _place_lamps(occupancy: Occupancy, car_park: CarPark, edge: float, rng: np.random.Generator) -> None:
    height = rng.uniform(*_LAMP_HEIGHT)
    start, end = car_park.paved_area.along
    across = edge + math.copysign(_LAMP_OFF, edge - car_park.aisles[0])
    for along in np.arange(start + _FIRST_LAMP, end, rng.uniform(*_LAMP_SPACING)).tolist():
        size = (_LAMP_LENGTH, LAMP_WIDTH, height)
        occupancy.place("lamp", along, across, size, angle=rng.uniform(*_LAMP_ANGLE))
