"""Street furniture and trees between the road and the gardens."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.arranging.car_parks import CarPark
from lidardraft.arranging.district import CALM, District
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.sizes import (
    BILLBOARD,
    BILLBOARD_CLEARANCE,
    HYDRANT,
    LAMP_WIDTH,
    POLE,
    SHELTER,
    SIGN_DEPTH,
    STREET_LETTERBOX,
    Size,
    sample_tree,
)
from lidardraft.objects.collision_boxes import CROWN_CORE
from lidardraft.scene.road import SIDES

# Shares of the kinds of furniture. Numbers without a source are estimates, here and below.
_FURNITURE = {
    "sign": 0.6,
    "pole": 0.26,
    "hydrant": 0.06,
    "letterbox": 0.03,
    "billboard": 0.05,
}
_KINDS, _SHARES = tuple(_FURNITURE), np.cumsum(tuple(_FURNITURE.values()))
_PIECES, _PIECES_OUTSIDE = 7, 4  # mean number a street, in towns and outside
_AT_KERB = 0.45  # m from the kerb to furniture
_SHOULDER = (1.2, 1.8)  # m behind the edge of a road without sidewalks
_ASKEW = 0.08  # rad, deviation
_JUNCTION_MARGIN, _GATE = 0.5, 4.5  # m to a junction, and from the middle of a car park's gate
# Signs: plates of 420, 600 or 750 mm (VwV-StVO), 2.0 to 2.5 m over the sidewalk.
_PLATES, _PLATE_CLEARANCE = (0.42, 0.6, 0.6, 0.75), (2.0, 2.5)  # m
_PLATES_OUTSIDE, _PLATE_CLEARANCE_OUTSIDE = (0.6, 1.5), (1.5, 2.0)  # m
_BILLBOARD_OFF = 2.4  # m behind the verge

# Lamps. For EN 13201, masts are 3.3 to 4.5 times as far apart as they are high.
_LAMP_SPACING = (3.3, 4.5)  # heights
_LIT, _LIT_OUTSIDE = 0.7, 0.12  # share of the sides with lamps, in towns and outside
_LAMP_HEIGHT, _CALM_LAMP_HEIGHT = (6.0, 10.0), (4.0, 6.5)  # m
_LAMP_LENGTH = (0.12, 0.2)  # m
LAMP_OFF, _LAMP_OFF_OUTSIDE = 0.45, 1.6  # m from the kerb, from the edge of a road without sidewalks
_LAMP_JUNCTION = 1.0  # m to a junction

# Bus stops.
_BUS_STOPS, _BUS_STOPS_EACH = 0.2, 0.01  # probability, and its increase for each of the district's people
_STOP_PLACE = 0.6  # of the half length of the street, at most
_STOP_JUNCTION = 8.0  # m to a junction
_SHELTER_OFF, _SHELTER_WALK = 0.85, 3.2  # m from its middle to the verge, behind or, on a sidewalk this wide, before
_STOP_SIGN, _STOP_SIGN_AHEAD, _STOP_SIGN_CLEARANCE = (SIGN_DEPTH, 0.5, 2.8), 3.6, 2.3  # m

# Street trees are planted 8 to 15 m apart (GALK).
_TREE_SPACING, _FIRST_TREE = (8.0, 15.0), (0.0, 10.0)  # m
TREE_OFF, WIDE_SIDEWALK = 0.8, 2.0  # m behind the kerb of sidewalks wider than this
_TREE_BEHIND, _TREE_ROOM = (3.0, 4.5), 9.0  # m behind the verge of others, and m of room there
_TO_WALL, _LEAST_CROWN, _LEAST_SHRINK = 0.6, 1.8, 0.6  # m from a crown's core to a wall, m, least share of the height
LEAST_STEM = 2.6  # m under the crown of a street tree
_GROWN, _OFF_PLACE, _KEPT = (0.8, 1.15), 0.3, 0.92  # size against the row's, m along (deviation), share not cut down
_LEAST_TOP = 1.5  # m from the stem to the top
_TREE_JUNCTION, _TREE_MARGIN, _ANY_ANGLE = 2.0, 0.05, (0.0, 3.0)  # m, m, rad
_PLANTED_MEDIAN, _MEDIAN_TREES = 2.4, 0.5  # m of a median that may have trees, and their frequency against sidewalks
_MEDIAN_SPACING, _MEDIAN_JUNCTION = (9.0, 15.0), 3.0  # m
_MEDIAN_TREE, _MEDIAN_STEM = 8.0, 4.5  # m: vehicles pass under the crowns (4.5 m: RASt 06)

# The island of a roundabout.
_ISLAND_RIM = 2.0  # m without bushes
_ISLAND_TREES, _ISLAND_STEM, _ISLAND_BUSHES = 0.4, 2.0, 4.0  # share with a tree, m of its stem, mean number
_ISLAND_BUSH, _ISLAND_BUSH_HEIGHT, _AROUND = (0.8, 2.4), 0.7, (0.0, 6.28)  # m, of the width, rad
_ISLAND_SIGN, _ISLAND_SIGN_CLEARANCE, _ISLAND_SIGN_OFF = (SIGN_DEPTH, 0.6, 1.5), 0.8, 0.8  # m, m, m from the rim

# High grass outside towns: a strip along the road [m], and spots in the fields.
_STRIPS, _STRIP_HEIGHT, _STRIP_WIDTH = 0.6, (0.12, 0.35), (0.5, 0.9)  # share of the sides
_STRIP_PIECE, _STRIP_KEPT, _STRIP_UNEVEN = (3.0, 7.0), 0.6, (0.7, 1.2)  # m, share not mown, factor of the height
_STRIP_ENDS, _STRIP_OFF = 0.7, 0.15  # of the half length of the street, m from the road
_SPOTS, _SPOT_SPREAD, _SPOT_OFF, _SPOT_FAR = 8, 35.0, 7.0, 10.0  # mean number a side, m along, m off the verge, mean m
_SPOT_LENGTH, _SPOT_WIDTH, _SPOT_HEIGHT, _SPOT_ANGLE = (1.5, 3.5), (1.2, 2.5), (0.2, 0.8), 0.3  # m, rad


def place_street_furniture(
    occupancy: Occupancy, district: District, car_park: CarPark | None, rng: np.random.Generator
) -> None:
    """Lamps at even spacing, signs and poles, and a bus stop."""
    town = occupancy.road.sidewalk > 0
    _place_lamps(occupancy, district, rng)
    for _ in range(rng.poisson(_PIECES if town else _PIECES_OUTSIDE)):
        _place_piece(occupancy, car_park, rng)
    if town and rng.random() < _BUS_STOPS + _BUS_STOPS_EACH * district.people:
        _place_bus_stop(occupancy, rng)


def _place_lamps(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    road = occupancy.road
    lit = _LIT_OUTSIDE if road.sidewalk == 0 else _LIT
    sides = [side for side in SIDES if rng.random() < lit]
    height = rng.uniform(*(_CALM_LAMP_HEIGHT if district.speed < CALM else _LAMP_HEIGHT))
    spacing = height * rng.uniform(*_LAMP_SPACING)
    off = road.edge + (LAMP_OFF if road.sidewalk > 0 else _LAMP_OFF_OUTSIDE)
    for side in sides:
        first = -road.half_length + rng.uniform(0, spacing)
        for along in np.arange(first, road.half_length, spacing).tolist():
            if not road.in_junction(along, _LAMP_JUNCTION):
                angle = 0.0 if side < 0 else math.pi
                size = (rng.uniform(*_LAMP_LENGTH), LAMP_WIDTH, height)
                occupancy.place("lamp", along, side * off, size, angle=angle)


def _place_piece(occupancy: Occupancy, car_park: CarPark | None, rng: np.random.Generator) -> None:
    """A piece of furniture somewhere; outside towns there are only signs."""
    road = occupancy.road
    side, along = SIDES[int(rng.integers(2))], rng.uniform(-road.half_length, road.half_length)
    gate = car_park is not None and side == car_park.side and abs(along - car_park.gate) < _GATE
    if road.in_junction(along, _JUNCTION_MARGIN) or gate:
        return
    town = road.sidewalk > 0
    kind = _KINDS[int(np.searchsorted(_SHARES, rng.random(), side="right"))] if town else "sign"
    angle = (math.pi if side < 0 else 0.0) + rng.normal(0.0, _ASKEW)
    size, clearance = _piece_size(kind, town, rng)
    off = road.edge + (_AT_KERB if town else rng.uniform(*_SHOULDER))
    if kind == "billboard":
        off = road.verge + _BILLBOARD_OFF
    occupancy.place(kind, along, side * off, size, angle=angle, clearance=clearance)


def _piece_size(kind: str, town: bool, rng: np.random.Generator) -> tuple[Size, float]:
    """Extents and clearance [m] of a piece of furniture; draws as many random numbers for any kind."""
    plate = _PLATES[int(rng.integers(len(_PLATES)))] if town else rng.uniform(*_PLATES_OUTSIDE)
    under = rng.uniform(*(_PLATE_CLEARANCE if town else _PLATE_CLEARANCE_OUTSIDE))
    sizes = {
        "sign": (SIGN_DEPTH, plate, under + plate),
        "pole": POLE.sample(rng),
        "hydrant": HYDRANT.sample(rng),
        "letterbox": STREET_LETTERBOX.sample(rng),
        "billboard": BILLBOARD.sample(rng),
    }
    return sizes[kind], {"sign": under, "billboard": BILLBOARD_CLEARANCE}.get(kind, 0.0)


def _place_bus_stop(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """A shelter, open (+y) to the road, and a place for people to wait."""
    road, side = occupancy.road, SIDES[int(rng.integers(2))]
    along = rng.uniform(-_STOP_PLACE, _STOP_PLACE) * road.half_length
    if road.in_junction(along, _STOP_JUNCTION):
        return
    off = road.verge + (_SHELTER_OFF if road.sidewalk < _SHELTER_WALK else -_SHELTER_OFF)
    angle = math.pi if side > 0 else 0.0
    if occupancy.place("shelter", along, side * off, SHELTER.sample(rng), angle=angle):
        across, angle = side * (road.edge + _AT_KERB), angle + math.pi / 2
        ahead = along + _STOP_SIGN_AHEAD
        occupancy.place("sign", ahead, across, _STOP_SIGN, angle=angle, clearance=_STOP_SIGN_CLEARANCE)
        occupancy.stops.append((along, float(side)))


def place_street_trees(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Trees in rows on the sides and in a wide median, with crowns as wide as their room."""
    for side in SIDES:
        if rng.random() <= district.street_trees:
            _place_tree_row(occupancy, district, side, rng)
    if occupancy.road.median > _PLANTED_MEDIAN and rng.random() < _MEDIAN_TREES * district.street_trees:
        _place_median_trees(occupancy, rng)


def _place_tree_row(occupancy: Occupancy, district: District, side: int, rng: np.random.Generator) -> None:
    road = occupancy.road
    wide = road.sidewalk > WIDE_SIDEWALK
    off = road.edge + TREE_OFF if wide else road.verge + rng.uniform(*_TREE_BEHIND)
    (length, width, height), stem = sample_tree(rng)
    room = 2 * (road.verge - off + district.setback[0] - _TO_WALL) / CROWN_CORE if wide else _TREE_ROOM
    shrink = min(1.0, max(room, _LEAST_CROWN) / width)
    length, width, height = length * shrink, width * shrink, height * max(shrink, _LEAST_SHRINK)
    stem = max(stem, LEAST_STEM)
    first = -road.half_length + rng.uniform(*_FIRST_TREE)
    for along in np.arange(first, road.half_length, rng.uniform(*_TREE_SPACING)).tolist():
        grown = rng.uniform(*_GROWN)
        place = along + rng.normal(0.0, _OFF_PLACE)
        if not road.in_junction(place, _TREE_JUNCTION) and rng.random() < _KEPT:
            size = (length * grown, width * grown, max(height * grown, stem + _LEAST_TOP))
            angle = rng.uniform(*_ANY_ANGLE)
            occupancy.place("tree", place, side * off, size, angle=angle, clearance=stem, margin=_TREE_MARGIN)


def _place_median_trees(occupancy: Occupancy, rng: np.random.Generator) -> None:
    road = occupancy.road
    for along in np.arange(-road.half_length, road.half_length, rng.uniform(*_MEDIAN_SPACING)).tolist():
        (length, width, height), stem = sample_tree(rng)
        if not road.in_junction(along, _MEDIAN_JUNCTION):
            size, stem = (length, width, max(height, _MEDIAN_TREE)), max(stem, _MEDIAN_STEM)
            angle = rng.uniform(*_ANY_ANGLE)
            occupancy.place("tree", along, 0.0, size, angle=angle, clearance=stem, margin=_TREE_MARGIN)


def place_island_plants(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """A tree or some bushes in the middle of a roundabout, and the signs that lead around it."""
    road = occupancy.road
    if road.roundabout_radius is None or road.junction is None:
        return
    room = road.island - _ISLAND_RIM
    if rng.random() < _ISLAND_TREES:
        size, stem = sample_tree(rng)
        occupancy.place("tree", road.junction, 0.0, size, clearance=max(stem, _ISLAND_STEM), margin=_TREE_MARGIN)
    for _ in range(rng.poisson(_ISLAND_BUSHES)):
        heading, out, width = rng.uniform(*_AROUND), rng.uniform(0.0, room), rng.uniform(*_ISLAND_BUSH)
        along, across = road.junction + (out - width / 2) * math.cos(heading), (out - width / 2) * math.sin(heading)
        size = (width, width, _ISLAND_BUSH_HEIGHT * width)
        occupancy.place("bush", along, across, size, angle=rng.uniform(*_ANY_ANGLE), margin=0.0)
    out = road.island - _ISLAND_SIGN_OFF
    for heading in (0.0, math.pi / 2, math.pi, 1.5 * math.pi):
        along, across = road.junction + out * math.cos(heading), out * math.sin(heading)
        occupancy.place("sign", along, across, _ISLAND_SIGN, angle=heading, clearance=_ISLAND_SIGN_CLEARANCE)


def place_high_grass(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """High grass beside roads without sidewalks, in strips on the shoulder and spots in the fields."""
    road = occupancy.road
    if road.sidewalk > 0:
        return
    for side in SIDES:
        if rng.random() < _STRIPS:
            _place_grass_strip(occupancy, side, rng)
        for _ in range(rng.poisson(_SPOTS)):
            along, across = rng.normal(0.0, _SPOT_SPREAD), side * (road.verge + _SPOT_OFF + rng.exponential(_SPOT_FAR))
            size = (rng.uniform(*_SPOT_LENGTH), rng.uniform(*_SPOT_WIDTH), rng.uniform(*_SPOT_HEIGHT))
            angle = rng.normal(0.0, _SPOT_ANGLE)
            occupancy.place("grass", along, across, size, angle=angle, margin=0.0, private=True)


def _place_grass_strip(occupancy: Occupancy, side: int, rng: np.random.Generator) -> None:
    road = occupancy.road
    height, width = rng.uniform(*_STRIP_HEIGHT), rng.uniform(*_STRIP_WIDTH)
    along = -_STRIP_ENDS * road.half_length
    across = side * (road.edge + _STRIP_OFF + width / 2)
    while along < _STRIP_ENDS * road.half_length:
        length = rng.uniform(*_STRIP_PIECE)
        if rng.random() < _STRIP_KEPT:
            size = (length, width, height * rng.uniform(*_STRIP_UNEVEN))
            occupancy.place("grass", along + length / 2, across, size, margin=0.0, private=True)
        along += length
