"""Vehicles and riders: parked along the kerb, following one another, waiting at lights."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.objects.cars import sample_car
from lidardraft.streets.placement.car_parks import CarPark
from lidardraft.streets.placement.district import District
from lidardraft.streets.placement.lanes import Lane
from lidardraft.streets.placement.occupancy import Occupancy

_QUEUED = (1.5, 3.0)  # m between standing vehicles: some 7.5 m a car (Highway Capacity Manual)
# Time gaps of followers [s]: a median of 1.4 s and a spread of 0.45 in its logarithm, an estimate of ours within the
# 1 to 2 s that are usual on German roads (drivers are told 1.8 s, half the speedometer).
_GAP_MEDIAN, _GAP_SPREAD = 1.4, 0.45


# Of parked vehicles some 2.5 % are small trucks and as many motorcycles: estimates of ours, under the shares of
# registered vehicles in Germany (KBA, 2023: 6 % trucks with vans, 8 % motorcycles), since fewer are left in streets.


def place_parked_vehicles(
    occupancy: Occupancy, parking: tuple[int, ...], car_park: CarPark | None, rng: np.random.Generator
) -> None:
    """Parked vehicles along the kerbs of the sides in `parking`, a few of them the wrong way round."""
    road = occupancy.road
    for side in parking:
        along, density = -road.half_length + rng.uniform(0, 6), rng.uniform(0.1, 0.75)
        while along < road.half_length - 3.0:
            kind, size = sample_car(rng)
            if rng.random() < 0.025:
                kind, size = "truck", (rng.uniform(5.5, 7.5), 2.1, rng.uniform(2.6, 3.0))
            elif rng.random() < 0.025:
                kind, size = "motorcycle", (2.1, 0.8, 1.2)
            middle = along + size[0] / 2
            gate = car_park is not None and car_park.side == side and abs(middle - car_park.gate) < 6.5
            # StVO: no parking within 5 m of a junction
            if rng.random() < density and not gate and not road.in_junction(middle, 5.0):
                across = side * (road.edge - rng.uniform(0.12, 0.3) - size[1] / 2)
                angle = (0.0 if side < 0 else math.pi) + math.pi * (rng.random() < 0.08) + rng.normal(0.0, 0.015)
                occupancy.place(kind, middle, across, size, angle=angle, margin=0.05)
            along += size[0] + rng.uniform(0.6, 2.0)


def place_traffic(occupancy: Occupancy, district: District, lanes: tuple[Lane, ...], rng: np.random.Generator) -> None:
    """Vehicles and riders in all lanes, now and then a tram; at a red light they wait in a queue."""
    road = occupancy.road
    if road.curvature == 0.0 and road.lanes > 1 and road.sidewalk > 0 and rng.random() < 0.1:
        inner = [lane for lane in lanes if lane.name == "road" and not lane.outer]
        if inner:
            size = (rng.uniform(20.0, 30.0), 2.4, 3.5)  # BOStrab: at most 2.65 m wide; low-floor cars of 20 to 30 m
            _put(occupancy, inner[-1], "tram", size, rng.uniform(0.3, 0.7) * inner[-1].length, rng)
    # lights are green for the road or for the side roads
    red = "arm" if rng.random() < 0.5 else "road"
    for lane in lanes:
        if lane.stop is not None and lane.name == red:
            _queue(occupancy, district, lane, rng)
        _flow(occupancy, district, lane, rng)
    for _ in range(rng.poisson(0.7 if road.sidewalk > 0 else 0.2)):
        outer = [lane for lane in lanes if lane.outer and lane.name == "road"]
        lane = outer[int(rng.integers(len(outer)))]
        distance = np.clip(rng.normal(0.5, 0.25), 0.05, 0.95) * lane.length
        along, across, angle = lane.at(float(distance), -0.9)
        occupancy.place("cyclist", along, across, (1.75, 0.58, rng.uniform(1.65, 1.8)), angle=angle)


def _queue(occupancy: Occupancy, district: District, lane: Lane, rng: np.random.Generator) -> None:
    """Vehicles that wait before the line."""
    assert lane.stop is not None
    distance = lane.stop - rng.uniform(0.0, 1.0)
    for _ in range(rng.poisson(3.0)):
        kind, size = _vehicle(rng, district, lane)
        if distance - size[0] < 0.0:
            return
        _put(occupancy, lane, kind, size, distance - size[0] / 2, rng)
        distance -= size[0] + rng.uniform(*_QUEUED)


def _flow(occupancy: Occupancy, district: District, lane: Lane, rng: np.random.Generator) -> None:
    """Free vehicles and groups of followers, at the distances that belong to their speed."""
    speed = lane.speed * rng.uniform(0.4, 1.0)
    free = {"road": district.traffic_gap, "arm": 45.0, "ring": 40.0, "aisle": 60.0}[lane.name]
    distance = rng.exponential(free)
    while distance < lane.length - 6.0:
        kind, size = _vehicle(rng, district, lane)
        if distance + size[0] < lane.length:
            _put(occupancy, lane, kind, size, distance + size[0] / 2, rng)
        if rng.random() < 0.4:
            gap = max(2.0, speed * _GAP_MEDIAN * math.exp(rng.normal(0.0, _GAP_SPREAD)))
        else:
            gap = max(5.0, 0.8 * speed) + rng.exponential(free)
        distance += size[0] + gap


def _put(
    occupancy: Occupancy,
    lane: Lane,
    kind: str,
    size: tuple[float, float, float],
    distance: float,
    rng: np.random.Generator,
) -> None:
    left = min(max(rng.normal(0.0, 0.12), -0.25), 0.25)
    along, across, angle = lane.at(distance, left)
    occupancy.place(kind, along, across, size, angle=angle + rng.normal(0.0, 0.012), margin=0.2)


def _vehicle(rng: np.random.Generator, district: District, lane: Lane) -> tuple[str, tuple[float, float, float]]:
    """Kind and extents of a vehicle in traffic; sizes up to the limits of directive 96/53/EC."""
    pick = rng.random()
    heavy = district.heavy if lane.outer and lane.name == "road" else 0.04 if lane.name == "arm" else 0.01
    if lane.name in ("ring", "aisle"):
        return sample_car(rng)
    long_haul = 0.55 if district.speed > 25.0 else 0.12
    if pick < heavy * long_haul:
        return "trailer_truck", (rng.uniform(15.5, 16.5), 2.55, rng.uniform(3.7, 4.0))
    if pick < heavy * 0.7:
        return "truck", (rng.uniform(6.0, 11.0), 2.5, rng.uniform(2.8, 3.8))
    if pick < heavy:
        return "bus", (rng.uniform(10.0, 12.5), 2.55, rng.uniform(3.0, 3.3))
    if pick < heavy + 0.02:
        return "motorcyclist", (2.1, 0.8, rng.uniform(1.5, 1.65))
    return sample_car(rng)
