"""Street furniture and trees between the road and the gardens."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.streets.placement.car_parks import CarPark
from lidardraft.streets.placement.district import SIDES, District
from lidardraft.streets.placement.gardens import BIN, tree_size
from lidardraft.streets.placement.occupancy import Occupancy

# Kinds, extents [m] and how often beside a street of a town: the numbers are estimates of ours.
# Signs: plates of 420, 600 or 750 mm (VwV-StVO), 2.0 to 2.5 m over the sidewalk. Cabinets: usual for telephone lines.
# Hydrants stand 0.9 m over the ground (EN 14384). Large posters are 3.56 x 2.52 m.
_KINDS = ("sign", "pole", "bin", "bench", "hydrant", "cabinet", "letterbox", "billboard")
_OFTEN = np.cumsum((0.42, 0.2, 0.14, 0.07, 0.04, 0.08, 0.02, 0.03))


def place_street_furniture(
    occupancy: Occupancy, district: District, car_park: CarPark | None, rng: np.random.Generator
) -> None:
    """Lamps at even spacing, signs, poles, bins, benches, cabinets, and a bus stop."""
    _lamps(occupancy, district, rng)
    for _ in range(rng.poisson(9 if occupancy.road.sidewalk > 0 else 4)):
        _post(occupancy, car_park, rng)
    if occupancy.road.sidewalk > 0 and rng.random() < 0.2 + 0.02 * district.people:
        _bus_stop(occupancy, rng)
    if district.people > 4.0:
        _bicycle_stands(occupancy, rng)


def _lamps(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    road = occupancy.road
    chance = 0.12 if road.sidewalk == 0 else 0.7
    lit = [side for side in SIDES if rng.random() < chance]
    # lighting to EN 13201 comes to masts 3.3 to 4.5 times as far apart as they are high
    height = rng.uniform(4.0, 6.5) if district.speed < 10.0 else rng.uniform(6.0, 10.0)
    spacing = height * rng.uniform(3.3, 4.5)
    off = road.edge + (0.45 if road.sidewalk > 0 else 1.6)
    for side in lit:
        for along in np.arange(-road.half_length + rng.uniform(0, spacing), road.half_length, spacing).tolist():
            if not road.in_junction(along, 1.0):
                angle = 0.0 if side < 0 else math.pi
                occupancy.place("lamp", along, side * off, (rng.uniform(0.12, 0.2), 0.2, height), angle=angle)


def _post(occupancy: Occupancy, car_park: CarPark | None, rng: np.random.Generator) -> None:
    road = occupancy.road
    side, along = SIDES[int(rng.integers(2))], rng.uniform(-road.half_length, road.half_length)
    if road.in_junction(along, 0.5) or (
        car_park is not None and side == car_park.side and abs(along - car_park.gate) < 4.5
    ):
        return
    town = road.sidewalk > 0
    kind = _KINDS[int(np.searchsorted(_OFTEN, rng.random(), side="right"))] if town else "sign"
    angle = (math.pi if side < 0 else 0.0) + rng.normal(0.0, 0.08)
    plate = (0.42, 0.6, 0.6, 0.75)[int(rng.integers(4))] if town else rng.uniform(0.6, 1.5)
    clearance = rng.uniform(2.0, 2.5) if town else rng.uniform(1.5, 2.0)
    size = {
        "sign": (0.12, plate, clearance + plate),
        "pole": (rng.uniform(0.08, 0.3), 0.2, rng.uniform(0.9, 7.0)),
        "bin": BIN if rng.random() < 0.4 else (0.4, 0.4, 0.9),  # else a litter bin
        "bench": (1.8, 0.6, 0.85),
        "hydrant": (0.3, 0.3, 0.9),
        "cabinet": (rng.uniform(0.7, 1.6), 0.4, rng.uniform(1.0, 1.6)),
        "letterbox": (0.4, 0.5, 1.3),
        "billboard": (0.3, 3.6, 2.4 + 2.6),
    }[kind]
    off = road.edge + 0.45 if town else road.edge + rng.uniform(1.2, 1.8)
    if kind == "bench":
        angle += math.pi  # it looks to the road
    if kind in ("bin", "bench", "cabinet") and town:
        off = road.verge - 0.45
    if kind == "billboard":
        off, clearance = road.verge + 2.4, 2.4
    occupancy.place(
        kind, along, side * off, size, angle=angle, clearance=clearance if kind in ("sign", "billboard") else 0.0
    )


def _bus_stop(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """A shelter, open (+y) to the road, and a place for people to wait."""
    road, side = occupancy.road, SIDES[int(rng.integers(2))]
    along = rng.uniform(-0.6, 0.6) * road.half_length
    if road.in_junction(along, 8.0):
        return
    off = road.verge + 0.85 if road.sidewalk < 3.2 else road.verge - 0.85
    angle = math.pi if side > 0 else 0.0
    if occupancy.place("shelter", along, side * off, (rng.uniform(3.5, 5.0), 1.5, 2.5), angle=angle):
        occupancy.place(
            "sign", along + 3.6, side * (road.edge + 0.45), (0.12, 0.5, 2.8), angle=angle + math.pi / 2, clearance=2.3
        )
        occupancy.stops.append((along, float(side)))


def _bicycle_stands(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """Rows of parked bicycles, 0.8 m apart (FGSV: 0.8 m and more), across the back of a wide sidewalk."""
    road = occupancy.road
    for _ in range(rng.poisson(1.0)):
        side, along = SIDES[int(rng.integers(2))], rng.normal(0.0, 30.0)
        upright = road.sidewalk > 3.4
        across = side * (road.verge - (1.0 if upright else 0.4))
        for number in range(int(rng.integers(2, 8))):
            step = 0.8 if upright else 2.1
            angle = math.pi / 2 if upright else 0.0
            if not road.in_junction(along + number * step) and rng.random() < 0.8:
                size = (1.78, 0.58, 1.06)
                occupancy.place(
                    "bicycle", along + number * step, across, size, angle=angle + rng.normal(0.0, 0.06), margin=0.03
                )


def place_street_trees(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Trees in rows, 8 to 15 m apart as street trees are planted (GALK), with the crowns that there is room for."""
    road = occupancy.road
    for side in SIDES:
        if rng.random() > district.row_trees:
            continue
        off = road.edge + 0.8 if road.sidewalk > 2.0 else road.verge + rng.uniform(3.0, 4.5)
        (length, width, height), clearance = tree_size(rng)
        room = 2 * (road.verge - off + district.setback[0] - 1.3) if road.sidewalk > 2.0 else 9.0
        shrink = min(1.0, max(room, 1.8) / width)
        length, width, height = length * shrink, width * shrink, height * max(shrink, 0.6)
        clearance = max(clearance, 2.6)
        for along in np.arange(
            -road.half_length + rng.uniform(0, 10), road.half_length, rng.uniform(8.0, 15.0)
        ).tolist():
            grown = rng.uniform(0.8, 1.15)
            place = along + rng.normal(0.0, 0.3)
            if not road.in_junction(place, 2.0) and rng.random() < 0.92:
                size = (length * grown, width * grown, max(height * grown, clearance + 1.5))
                occupancy.place(
                    "tree", place, side * off, size, angle=rng.uniform(0, 3.0), clearance=clearance, margin=0.05
                )
    if road.median > 2.4 and rng.random() < 0.5 * district.row_trees:
        for along in np.arange(-road.half_length, road.half_length, rng.uniform(9.0, 15.0)).tolist():
            size, clearance = tree_size(rng)
            if not road.in_junction(along, 3.0):
                # the crowns stay over what drives under them (4.5 m: RASt 06)
                size = (size[0], size[1], max(size[2], 8.0))
                occupancy.place(
                    "tree", along, 0.0, size, angle=rng.uniform(0, 3.0), clearance=max(clearance, 4.5), margin=0.05
                )


def place_island_plants(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """A tree or some bushes in the middle of a roundabout, and the signs that lead around it."""
    road = occupancy.road
    if road.roundabout_radius is None or road.junction is None:
        return
    room = road.island - 2.0
    if rng.random() < 0.4:
        size, clearance = tree_size(rng)
        occupancy.place("tree", road.junction, 0.0, size, clearance=max(clearance, 2.0), margin=0.05)
    for _ in range(rng.poisson(4.0)):
        angle, out, width = rng.uniform(0.0, 6.28), rng.uniform(0.0, room), rng.uniform(0.8, 2.4)
        along, across = road.junction + (out - width / 2) * math.cos(angle), (out - width / 2) * math.sin(angle)
        occupancy.place("bush", along, across, (width, width, 0.7 * width), angle=rng.uniform(0, 3), margin=0.0)
    for angle in (0.0, math.pi / 2, math.pi, 1.5 * math.pi):
        along, across = road.junction + (road.island - 0.8) * math.cos(angle), (road.island - 0.8) * math.sin(angle)
        occupancy.place("sign", along, across, (0.12, 0.6, 1.5), angle=angle, clearance=0.8)


def place_high_grass(occupancy: Occupancy, rng: np.random.Generator) -> None:
    """High grass beside roads without sidewalks, in strips on the shoulder and patches in the fields."""
    road = occupancy.road
    if road.sidewalk > 0:
        return
    for side in SIDES:
        if rng.random() < 0.6:
            height, width = rng.uniform(0.12, 0.35), rng.uniform(0.5, 0.9)
            along = -0.7 * road.half_length
            while along < 0.7 * road.half_length:
                length = rng.uniform(3.0, 7.0)
                across = side * (road.edge + 0.15 + width / 2)
                if rng.random() < 0.6:
                    size = (length, width, height * rng.uniform(0.7, 1.2))
                    occupancy.place("grass", along + length / 2, across, size, margin=0.0, private=True)
                along += length
        for _ in range(rng.poisson(8)):
            along, across = rng.normal(0.0, 35.0), side * (road.verge + 7.0 + rng.exponential(10.0))
            size = (rng.uniform(1.5, 3.5), rng.uniform(1.2, 2.5), rng.uniform(0.2, 0.8))
            occupancy.place("grass", along, across, size, angle=rng.normal(0.0, 0.3), margin=0.0, private=True)
