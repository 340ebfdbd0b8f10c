"""Vehicles and riders: parked along the kerb, in flows, in queues at lights."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.arranging.car_parks import CarPark
from lidardraft.arranging.district import FAST, District
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.sizes import (
    BUS,
    CYCLIST,
    MOTORCYCLE,
    MOTORCYCLIST,
    PARKED_TRUCK,
    TRAILER_TRUCK,
    TRAM,
    TRUCK,
    Size,
)
from lidardraft.objects.cars import sample_car
from lidardraft.scene.street import AISLE, MAIN_ROAD, ROUNDABOUT, SIDE_ROAD, Path

# Parked vehicles. Numbers without a source are estimates, here and below.
_TAKEN = (0.1, 0.75)  # share of the places along a kerb
_FIRST = (0.0, 6.0)  # m from the end of the street to the first
_LAST = 3.0  # m before the other end, in which no vehicle begins
_PARKING_GAP = (0.6, 2.0)  # m between two
_TO_KERB = (0.12, 0.3)  # m
_WRONG_WAY = 0.08  # share that faces the other way
_ASKEW = 0.015  # rad, deviation
_PARKED_MARGIN = 0.05  # m
# Some 2.5 % are small trucks and as many motorcycles, under the shares of registered vehicles in Germany (KBA, 2023:
# 6 % trucks with vans, 8 % motorcycles), since fewer are left in streets.
_PARKED_TRUCKS = 0.025
_PARKED_MOTORCYCLES = 0.025
_NO_PARKING = 5.0  # m before a junction (StVO)
_GATE = 6.5  # m either way of the middle of a car park's gate

# Trams run on straight roads of several lanes in towns.
_TRAMS = 0.1  # share of these with one
_TRAM_PLACE = (0.3, 0.7)  # share of the lane's length

# Mean number a street, in towns and outside: such that 0.9 riders return in a scan, as in PandaSet (11 in 12 scans).
_CYCLISTS, _CYCLISTS_OUTSIDE = 1.1, 0.35
_CYCLIST_PLACE = (0.5, 0.25)  # mean and deviation, in shares of the lane's length
_CYCLIST_PLACES = (0.05, 0.95)  # and the limits
_CYCLIST_LEFT = -0.9  # m of the middle of the lane

# Queues at a red light.
_RED_FOR_SIDE_ROADS = 0.5  # else for the road itself
_TO_LINE = (0.0, 1.0)  # m from the first vehicle
_QUEUE = 3.0  # mean number of vehicles
_QUEUED = (1.5, 3.0)  # m between standing vehicles: some 7.5 m a car (Highway Capacity Manual)

# Flows.
_FLOW_SPEED = (0.4, 1.0)  # share of the limit
_LANE_END = 6.0  # m in which no vehicle begins
_FOLLOWERS = 0.4  # share
# Time gaps of followers [s]: a median of 1.4 s and a spread of 0.45 in its logarithm, within the 1 to 2 s that are
# usual on German roads (the rule of half the speedometer is 1.8 s).
_GAP_MEDIAN, _GAP_SPREAD = 1.4, 0.45
_LEAST_GAP = 2.0  # m, of followers
_FREE_GAP, _FREE_TIME = 5.0, 0.8  # m and s, of free vehicles
_OFF_MIDDLE, _MOST_OFF = 0.12, 0.25  # m off the middle of the lane: deviation and limit
_TO_EDGE = 0.2  # m from a vehicle to the edge of its lane, where the lane is wide enough
_WEAVE = 0.012  # rad against the lane, deviation
_TRAFFIC_MARGIN = 0.2  # m

# The room around the ego vehicle that is mostly free [m], and the share of scenes without it: as many scans as in
# KITTI, 9 of 25, have over 500 returns within 3.3 m.
EGO_ROOM, HUGGED = (6.6, 6.6, 1.6), 0.7

# Shares of vehicles in traffic.
_HEAVY_INSIDE = 0.01  # share of trucks and buses in inner lanes
_LONG_HAUL, _SHORT_HAUL = 0.55, 0.12  # share of those with trailers among these, on fast roads and others
_TRUCKS = 0.7  # share of all trucks among these; the others are buses
_MOTORCYCLES = 0.02  # share


@dataclass(frozen=True, kw_only=True, slots=True)
class LaneUse:
    """The use of lanes of one kind: estimates.

    `ego_share` is the weight of a place in such a lane for the ego vehicle, against one of the road; `ego_stands`
    is the probability that it stands there. `free_gap` is the mean distance [m] of vehicles that follow none, None for
    that of the district. `heavy` is the share of trucks and buses in the traffic, None for that of the district. With
    `only_cars` there are neither these nor riders.
    """

    ego_share: float
    ego_stands: float
    free_gap: float | None = None
    heavy: float | None = None
    only_cars: bool = False


USES = {
    MAIN_ROAD: LaneUse(ego_share=1.0, ego_stands=0.12),
    SIDE_ROAD: LaneUse(ego_share=0.5, ego_stands=0.3, free_gap=45.0, heavy=0.04),
    ROUNDABOUT: LaneUse(ego_share=1.0, ego_stands=0.1, free_gap=40.0, only_cars=True),
    AISLE: LaneUse(ego_share=0.7, ego_stands=0.25, free_gap=60.0, only_cars=True),
}


def place_parked_vehicles(
    occupancy: Occupancy, parking: tuple[int, ...], car_park: CarPark | None, rng: np.random.Generator
) -> None:
    """Parked vehicles along the kerbs of the sides in `parking`, a few of them the wrong way round."""
    road = occupancy.road
    for side in parking:
        along, taken = -road.half_length + rng.uniform(*_FIRST), rng.uniform(*_TAKEN)
        while along < road.half_length - _LAST:
            kind, size = _parked_vehicle(rng)
            middle = along + size[0] / 2
            gate = car_park is not None and car_park.side == side and abs(middle - car_park.gate) < _GATE
            if rng.random() < taken and not gate and not road.in_junction(middle, _NO_PARKING):
                across = side * (road.edge - rng.uniform(*_TO_KERB) - size[1] / 2)
                backwards = math.pi * (rng.random() < _WRONG_WAY)
                angle = (0.0 if side < 0 else math.pi) + backwards + rng.normal(0.0, _ASKEW)
                occupancy.place(kind, middle, across, size, angle=angle, margin=_PARKED_MARGIN)
            along += size[0] + rng.uniform(*_PARKING_GAP)


def _parked_vehicle(rng: np.random.Generator) -> tuple[str, Size]:
    kind, size = sample_car(rng)
    if rng.random() < _PARKED_TRUCKS:
        return "truck", PARKED_TRUCK.sample(rng)
    if rng.random() < _PARKED_MOTORCYCLES:
        return "motorcycle", MOTORCYCLE.sample(rng)
    return kind, size


def place_traffic(occupancy: Occupancy, district: District, lanes: tuple[Path, ...], rng: np.random.Generator) -> None:
    """Vehicles and riders in all lanes, now and then a tram; at a red light they wait in a queue."""
    _place_tram(occupancy, lanes, rng)
    # lights are green for the road or for the side roads
    red = SIDE_ROAD if rng.random() < _RED_FOR_SIDE_ROADS else MAIN_ROAD
    for lane in lanes:
        if lane.stop is not None and lane.kind == red:
            _place_queue(occupancy, district, lane, rng)
        _place_flow(occupancy, district, lane, rng)
    _place_cyclists(occupancy, district, lanes, rng)


def _place_tram(occupancy: Occupancy, lanes: tuple[Path, ...], rng: np.random.Generator) -> None:
    road = occupancy.road
    if road.curvature == 0.0 and road.lanes > 1 and road.sidewalk > 0 and rng.random() < _TRAMS:
        inner = [lane for lane in lanes if lane.kind == MAIN_ROAD and not lane.outer]
        if inner:
            size = TRAM.sample(rng)
            _place_in_lane(occupancy, inner[-1], "tram", size, rng.uniform(*_TRAM_PLACE) * inner[-1].length, rng)


def _place_cyclists(
    occupancy: Occupancy, district: District, lanes: tuple[Path, ...], rng: np.random.Generator
) -> None:
    outer = [lane for lane in lanes if lane.outer and lane.kind == MAIN_ROAD]
    for _ in range(rng.poisson(district.riders * (_CYCLISTS if occupancy.road.sidewalk > 0 else _CYCLISTS_OUTSIDE))):
        lane = outer[int(rng.integers(len(outer)))]
        distance = np.clip(rng.normal(*_CYCLIST_PLACE), *_CYCLIST_PLACES) * lane.length
        along, across, angle = lane.at(float(distance), _CYCLIST_LEFT)
        occupancy.place("cyclist", along, across, CYCLIST.sample(rng), angle=angle)


def _place_queue(occupancy: Occupancy, district: District, lane: Path, rng: np.random.Generator) -> None:
    """Vehicles that wait before the line."""
    assert lane.stop is not None
    distance = lane.stop - rng.uniform(*_TO_LINE)
    for _ in range(rng.poisson(_QUEUE)):
        kind, size = _vehicle(rng, district, lane)
        if distance - size[0] < 0.0:
            return
        _place_in_lane(occupancy, lane, kind, size, distance - size[0] / 2, rng)
        distance -= size[0] + rng.uniform(*_QUEUED)


def _place_flow(occupancy: Occupancy, district: District, lane: Path, rng: np.random.Generator) -> None:
    """Free vehicles and groups of followers, at distances for their speed."""
    speed = lane.speed * rng.uniform(*_FLOW_SPEED)
    usual = USES[lane.kind].free_gap
    free = district.traffic_gap if usual is None else usual
    distance = rng.exponential(free)
    while distance < lane.length - _LANE_END:
        kind, size = _vehicle(rng, district, lane)
        if distance + size[0] < lane.length:
            _place_in_lane(occupancy, lane, kind, size, distance + size[0] / 2, rng)
        if rng.random() < _FOLLOWERS:
            gap = max(_LEAST_GAP, speed * _GAP_MEDIAN * math.exp(rng.normal(0.0, _GAP_SPREAD)))
        else:
            gap = max(_FREE_GAP, _FREE_TIME * speed) + rng.exponential(free)
        distance += size[0] + gap


def _place_in_lane(
    occupancy: Occupancy, lane: Path, kind: str, size: Size, distance: float, rng: np.random.Generator
) -> None:
    most = min(_MOST_OFF, max(0.0, (lane.width - size[1]) / 2 - _TO_EDGE))
    left = min(max(rng.normal(0.0, _OFF_MIDDLE), -most), most)
    along, across, angle = lane.at(distance, left)
    occupancy.place(kind, along, across, size, angle=angle + rng.normal(0.0, _WEAVE), margin=_TRAFFIC_MARGIN)


def _vehicle(rng: np.random.Generator, district: District, lane: Path) -> tuple[str, Size]:
    """Kind and extents of a vehicle in traffic."""
    pick = rng.random()
    if USES[lane.kind].only_cars:
        return sample_car(rng)
    heavy = USES[lane.kind].heavy
    if heavy is None:
        heavy = district.heavy if lane.outer else _HEAVY_INSIDE
    if pick < heavy * (_LONG_HAUL if district.speed > FAST else _SHORT_HAUL):
        return "trailer_truck", TRAILER_TRUCK.sample(rng)
    if pick < heavy * _TRUCKS:
        return "truck", TRUCK.sample(rng)
    if pick < heavy:
        return "bus", BUS.sample(rng)
    if pick < heavy + _MOTORCYCLES * district.riders:
        return "motorcyclist", MOTORCYCLIST.sample(rng)
    return sample_car(rng)
