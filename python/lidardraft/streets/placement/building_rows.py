"""Buildings along a street: rows of houses, closed fronts of blocks with courtyards behind, halls behind car parks."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.objects.buildings import STOREY
from lidardraft.streets.placement.car_parks import CarPark
from lidardraft.streets.placement.district import SIDES, District
from lidardraft.streets.placement.occupancy import Occupancy

_CLOSED = 0.72  # share of blocks in a closed front that adjoin the next
_STEPPED = 0.3  # share of buildings that stand back from the line of their row, and m by which they do: estimates
_STEP_BACK = (0.2, 1.2)
_ASKEW = 0.06  # rad by which the buildings of a row are turned at most against the road


def place_buildings(
    occupancy: Occupancy, district: District, car_park: CarPark | None, rng: np.random.Generator
) -> None:
    """Two rows of buildings on both sides, and the hall that a car park belongs to."""
    if car_park is not None:
        _hall(occupancy, car_park, rng)
    for side in SIDES:
        if district.gap[1] == 0.0:
            _closed_front(occupancy, district, side, rng)
        else:
            _open_rows(occupancy, district, side, rng)


def _facing(side: int) -> float:
    """The angle of a building that looks to the road."""
    return 0.0 if side > 0 else math.pi


def _hall(occupancy: Occupancy, car_park: CarPark, rng: np.random.Generator) -> None:
    size = (rng.uniform(24.0, 50.0), rng.uniform(16.0, 30.0), rng.uniform(5.0, 8.0))
    far = max(abs(edge) for edge in car_park.paved_area.across)
    middle = (car_park.paved_area.along[0] + car_park.paved_area.along[1]) / 2
    across = car_park.side * (far + rng.uniform(2.0, 5.0) + size[1] / 2)
    occupancy.place("shed", middle, across, size, angle=_facing(car_park.side), margin=0.02, private=True)


def _open_rows(occupancy: Occupancy, district: District, side: int, rng: np.random.Generator) -> None:
    road = occupancy.road
    for row in range(2):
        setback = rng.uniform(*district.setback) + row * rng.uniform(16.0, 30.0)
        askew = rng.uniform(-_ASKEW, _ASKEW)
        along = -road.half_length - rng.uniform(0.0, 8.0)
        while along < road.half_length:
            kind, size, eaves = sample_building(district, rng)
            across = side * (road.verge + setback + rng.uniform(0.0, 1.0) + _step_back(rng) + size[1] / 2)
            if rng.random() < district.built:
                angle = _facing(side) + askew + rng.normal(0.0, 0.01)
                occupancy.place(
                    kind, along + size[0] / 2, across, size, angle=angle, clearance=eaves, margin=0.02, private=True
                )
            along += size[0] + rng.uniform(*district.gap) * (1 if row == 0 else 2)


def sample_building(district: District, rng: np.random.Generator) -> tuple[str, tuple[float, float, float], float]:
    """Kind, extents and eaves of a building that stands alone."""
    if rng.random() < district.blocks:
        storeys = int(rng.integers(3, 7))
        return "block", (rng.uniform(12.0, 30.0), rng.uniform(10.0, 15.0), storeys * STOREY + 0.4), 0.0
    if rng.random() < 0.12:
        return "shed", (rng.uniform(3.0, 12.0), rng.uniform(5.5, 9.0), rng.uniform(2.4, 4.0)), 0.0
    eaves = int(rng.integers(1, 4)) * STOREY + 0.2
    width = rng.uniform(7.5, 11.0)
    return "house", (rng.uniform(8.0, 16.0), width, eaves + width * rng.uniform(0.25, 0.5)), eaves


def _closed_front(occupancy: Occupancy, district: District, side: int, rng: np.random.Generator) -> None:
    """Blocks wall to wall close to the sidewalk, gaps with courtyard walls between, and buildings behind the yards."""
    road = occupancy.road
    setback = rng.uniform(*district.setback)
    storeys, depth = int(rng.integers(3, 7)), rng.uniform(10.0, 13.0)
    along = -road.half_length - rng.uniform(0.0, 8.0)
    while along < road.half_length:
        length = rng.uniform(10.0, 24.0)
        height = max(3, storeys + int(rng.integers(-1, 2))) * STOREY + 0.4
        across = side * (road.verge + setback + _step_back(rng) + depth / 2)
        angle = _facing(side)
        # before a side road a shorter one fits
        for tried in (length, 10.0, 0.0):
            size, middle = (tried, depth, height), along + tried / 2
            if tried and occupancy.place("block", middle, across, size, angle=angle, margin=0.02, private=True):
                break
        length = tried
        if length == 0.0:
            along += 2.0
            continue
        along += length + 0.05
        if rng.random() > _CLOSED:
            along = _gap(occupancy, along, side, setback, rng)
    yard = rng.uniform(10.0, 18.0)
    along = -road.half_length
    while along < road.half_length:
        size = (rng.uniform(10.0, 26.0), rng.uniform(8.0, 12.0), int(rng.integers(2, 6)) * STOREY + 0.4)
        across = side * (road.verge + setback + depth + yard + size[1] / 2)
        if rng.random() < 0.6:
            occupancy.place("block", along + size[0] / 2, across, size, angle=_facing(side), margin=0.02, private=True)
        along += size[0] + rng.uniform(2.0, 14.0)


def _step_back(rng: np.random.Generator) -> float:
    return rng.uniform(*_STEP_BACK) if rng.random() < _STEPPED else 0.0


def _gap(occupancy: Occupancy, along: float, side: int, setback: float, rng: np.random.Generator) -> float:
    """A gap between blocks, open, walled or fenced off as a building site; where it ends."""
    width = rng.uniform(3.2, 12.0)
    pick = rng.random()
    across = side * (occupancy.road.verge + setback + 0.3)
    if pick < 0.4:
        size = (width - 0.3, 0.3, rng.uniform(1.8, 2.8))
        occupancy.place("wall", along + width / 2, across, size, margin=0.0, private=True)
    elif pick < 0.6:
        # mobile site fences are 3.5 x 2.0 m
        count = max(1, int(width / 3.55))
        for number in range(count):
            middle = along + (number + 0.5) * width / count
            size = (min(3.5, width / count - 0.05), 0.06, 2.0)
            occupancy.place("mesh_fence", middle, across, size, margin=0.0, private=True)
    return along + width
