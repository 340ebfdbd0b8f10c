"""Buildings along a street: rows of houses, closed fronts of blocks with courtyards behind, halls behind car parks."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.arranging.car_parks import CarPark
from lidardraft.arranging.district import District
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.sizes import Extents, Size
from lidardraft.objects.buildings import STOREY
from lidardraft.scene.road import SIDES
from lidardraft.scene.solids import Solid

# Numbers without a source are estimates.
BUILDING_MARGIN = 0.02  # m
_BEGINS, _ENDS = (16.0, 30.0), 20.0  # m before the street, the start of a row, and behind it, of the last building

# Detached buildings [m].
_HALL = Extents((24.0, 50.0), (16.0, 30.0), (5.0, 8.0))
_HALL_OFF = (2.0, 5.0)  # m behind its car park
_BLOCK_STOREYS, _BLOCK_LENGTH, _BLOCK_WIDTH = (3, 7), (12.0, 30.0), (10.0, 15.0)  # storeys: from, to before
_PARAPET = 0.4  # m over the storeys of a block
_SHEDS = 0.12  # share of the others
_SHED = Extents((3.0, 12.0), (5.5, 9.0), (2.4, 4.0))
_HOUSE_STOREYS, _HOUSE_LENGTH, _HOUSE_WIDTH = (1, 4), (8.0, 16.0), (7.5, 11.0)
_KNEE_WALL = 0.2  # m from the ceiling of the top storey to the eaves
_PITCH = (0.25, 0.5)  # height of a roof over the width of its house

# Open views between the rows, each up to a building.
_OPEN, _OPEN_WIDTH, _OPEN_DEPTH = 0.8, (8.0, 18.0), (40.0, 85.0)  # mean number a side, m
_OPEN_FROM, _SKY = 1.6, 50.0  # m over the ground: lower things stand there

# Rows of houses.
_ROWS = 2
_BEHIND = (16.0, 30.0)  # m from the first row to the second
_OFF_LINE = (0.0, 1.0)  # m off the line of the row
_STEPPED = 0.3  # share of buildings that stand back from it
_STEP_BACK = (0.2, 1.2)  # m by which they do
_ASKEW, _TURNED = 0.06, 0.01  # rad that a row is turned against the road at most, and a house against it, deviation

# Closed fronts of blocks, and buildings behind their yards.
_DEPTH, _FRONT_LENGTH = (10.0, 13.0), (10.0, 24.0)  # m
_LEAST_STOREYS = 3
_SEAM = 0.05  # m between two fronts
_NO_ROOM = 2.0  # m to the next place to try
_YARD = (10.0, 18.0)  # m
_YARD_STOREYS, _YARD_LENGTH, _YARD_WIDTH = (2, 6), (10.0, 26.0), (8.0, 12.0)
_YARD_BUILT, _YARD_GAP = 0.6, (2.0, 14.0)  # share of the places, m between two

_GAP = (3.2, 14.0)  # m in a closed front


def place_buildings(
    occupancy: Occupancy, district: District, car_park: CarPark | None, rng: np.random.Generator
) -> None:
    """Two rows of buildings on both sides, with views between, and the hall of a car park."""
    if car_park is not None:
        _place_hall(occupancy, car_park, rng)
    _place_views(occupancy, district, rng)
    for side in SIDES:
        if district.closed_fronts:
            _place_closed_front(occupancy, district, side, rng)
        else:
            _place_rows(occupancy, district, side, rng)


def _place_views(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Keep views open between the rows, each up to a building."""
    road = occupancy.road
    if not district.built_up:
        return
    for side in SIDES:
        for _ in range(rng.poisson(_OPEN)):
            along, size = rng.uniform(-0.8, 0.8) * road.half_length, _sample_block(rng)
            width, depth = rng.uniform(*_OPEN_WIDTH), rng.uniform(*_OPEN_DEPTH)
            across = side * (road.verge + depth + size[1] / 2)
            occupancy.place("block", along, across, size, angle=_facing(side), margin=BUILDING_MARGIN, private=True)
            x, y, yaw = road.at(along, side * (road.verge + depth / 2))
            occupancy.reserve(Solid.box(x, y, yaw, (width, depth), _OPEN_FROM, _SKY))


def _sample_block(rng: np.random.Generator) -> Size:
    return rng.uniform(*_BLOCK_LENGTH), rng.uniform(*_BLOCK_WIDTH), _block_height(int(rng.integers(*_BLOCK_STOREYS)))


def _facing(side: int) -> float:
    """The angle of a building that faces the road."""
    return 0.0 if side > 0 else math.pi


def _place_hall(occupancy: Occupancy, car_park: CarPark, rng: np.random.Generator) -> None:
    size = _HALL.sample(rng)
    far = max(abs(edge) for edge in car_park.paved_area.across)
    middle = (car_park.paved_area.along[0] + car_park.paved_area.along[1]) / 2
    across = car_park.side * (far + rng.uniform(*_HALL_OFF) + size[1] / 2)
    angle = _facing(car_park.side)
    occupancy.place("shed", middle, across, size, angle=angle, margin=BUILDING_MARGIN, private=True)


def _place_rows(occupancy: Occupancy, district: District, side: int, rng: np.random.Generator) -> None:
    """Detached buildings in rows, one behind the other."""
    road = occupancy.road
    for row in range(_ROWS):
        setback = rng.uniform(*district.setback) + row * rng.uniform(*_BEHIND)
        askew = rng.uniform(-_ASKEW, _ASKEW)
        along = -road.half_length - rng.uniform(*_BEGINS)
        while along < road.half_length + _ENDS:
            kind, size, eaves = sample_building(district, rng)
            across = side * (road.verge + setback + rng.uniform(*_OFF_LINE) + _step_back(rng) + size[1] / 2)
            if rng.random() < district.built:
                angle = _facing(side) + askew + rng.normal(0.0, _TURNED)
                middle = along + size[0] / 2
                occupancy.place(
                    kind, middle, across, size, angle=angle, clearance=eaves, margin=BUILDING_MARGIN, private=True
                )
            along += size[0] + rng.uniform(*district.gap) * (1 if row == 0 else 2)


def sample_building(district: District, rng: np.random.Generator) -> tuple[str, Size, float]:
    """Kind, extents and eaves [m] of a detached building."""
    if rng.random() < district.blocks:
        return "block", _sample_block(rng), 0.0
    if rng.random() < _SHEDS:
        return "shed", _SHED.sample(rng), 0.0
    eaves = int(rng.integers(*_HOUSE_STOREYS)) * STOREY + _KNEE_WALL
    width = rng.uniform(*_HOUSE_WIDTH)
    return "house", (rng.uniform(*_HOUSE_LENGTH), width, eaves + width * rng.uniform(*_PITCH)), eaves


def _block_height(storeys: int) -> float:
    return storeys * STOREY + _PARAPET


def _place_closed_front(occupancy: Occupancy, district: District, side: int, rng: np.random.Generator) -> None:
    """Blocks wall to wall close to the sidewalk, with gaps, and buildings behind the yards.

    If a block has no room, a shorter one is tried.
    """
    road = occupancy.road
    setback = rng.uniform(*district.setback)
    storeys, depth = int(rng.integers(*_BLOCK_STOREYS)), rng.uniform(*_DEPTH)
    along = -road.half_length - rng.uniform(*_BEGINS)
    while along < road.half_length + _ENDS:
        length = rng.uniform(*_FRONT_LENGTH)
        height = _block_height(max(_LEAST_STOREYS, storeys + int(rng.integers(-1, 2))))
        across = side * (road.verge + setback + _step_back(rng) + depth / 2)
        for extent in (length, district.short_front):
            size, middle, angle = (extent, depth, height), along + extent / 2, _facing(side)
            if occupancy.place("block", middle, across, size, angle=angle, margin=BUILDING_MARGIN, private=True):
                break
        else:
            along += _NO_ROOM
            continue
        along += extent + _SEAM
        if rng.random() > district.adjoining:
            along += rng.uniform(*_GAP)
    _place_yard_buildings(occupancy, side, road.verge + setback + depth, rng)


def _place_yard_buildings(occupancy: Occupancy, side: int, back: float, rng: np.random.Generator) -> None:
    """Buildings behind the yards of a closed front whose back is `back` [m] across."""
    road = occupancy.road
    yard = rng.uniform(*_YARD)
    along = -road.half_length
    while along < road.half_length:
        length, width = rng.uniform(*_YARD_LENGTH), rng.uniform(*_YARD_WIDTH)
        size = (length, width, _block_height(int(rng.integers(*_YARD_STOREYS))))
        across = side * (back + yard + width / 2)
        if rng.random() < _YARD_BUILT:
            middle, angle = along + length / 2, _facing(side)
            occupancy.place("block", middle, across, size, angle=angle, margin=BUILDING_MARGIN, private=True)
        along += length + rng.uniform(*_YARD_GAP)


def _step_back(rng: np.random.Generator) -> float:
    return rng.uniform(*_STEP_BACK) if rng.random() < _STEPPED else 0.0
