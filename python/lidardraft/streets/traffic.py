"""What moves or is parked on the public way: vehicles, riders, people."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.streets.quarter import SIDES, Lane, Quarter
from lidardraft.streets.site import Site
from lidardraft.streets.vehicles import car_body


def park(site: Site, parking: tuple[int, ...], rng: np.random.Generator) -> None:
    """Parked vehicles along the kerbs of the sides in `parking`, a few of them the wrong way round."""
    road = site.road
    for side in parking:
        along, density = -road.reach + rng.uniform(0, 6), rng.uniform(0.1, 0.65)
        while along < road.reach - 3.0:
            kind, size = car_body(rng)
            if rng.random() < 0.04:
                kind, size = "truck", (rng.uniform(5.5, 7.5), 2.1, rng.uniform(2.6, 3.0))
            elif rng.random() < 0.025:
                kind, size = "motorcycle", (2.1, 0.8, 1.2)
            middle = along + size[0] / 2
            if rng.random() < density and not (_has_arm(site, side) and road.in_junction(middle, 5.0)):
                across = side * (road.edge - rng.uniform(0.12, 0.3) - size[1] / 2)
                turn = (0.0 if side < 0 else math.pi) + math.pi * (rng.random() < 0.08) + rng.normal(0.0, 0.015)
                site.place(kind, middle, across, size, turn=turn, margin=0.05)
            along += size[0] + rng.uniform(0.6, 2.0)


def drive(site: Site, quarter: Quarter, lanes: tuple[Lane, ...], rng: np.random.Generator) -> None:
    """Vehicles and riders in the lanes, now and then a tram."""
    road = site.road
    if road.curvature == 0.0 and road.lanes > 1 and rng.random() < 0.15:
        lane = lanes[-1]
        site.place(
            "tram", rng.uniform(-45, 45), lane.across, (rng.uniform(20.0, 30.0), 2.4, 3.5), turn=lane.turn, margin=0.1
        )
    for lane in lanes:
        along = -road.reach + rng.exponential(quarter.traffic_gap)
        while along < road.reach - 6.0:
            kind, size = _vehicle(rng, quarter.heavy)
            # queues now and then
            gap = rng.uniform(1.5, 4.0) if rng.random() < 0.2 else 5.0 + rng.exponential(quarter.traffic_gap)
            across = lane.across + float(np.clip(rng.normal(0.0, 0.12), -0.25, 0.25))
            turn = lane.turn + rng.normal(0.0, 0.015)
            site.place(kind, along + size[0] / 2, across, size, turn=turn, margin=0.2)
            along += size[0] + gap
    for _ in range(rng.poisson(1.2)):
        lane = lanes[int(rng.integers(len(lanes)))]
        across = lane.across - lane.direction * 0.8
        site.place("cyclist", rng.uniform(-60, 60), across, (1.75, 0.58, rng.uniform(1.65, 1.8)), turn=lane.turn)


def _vehicle(rng: np.random.Generator, heavy: float) -> tuple[str, tuple[float, float, float]]:
    """Kind and extents of a vehicle in traffic."""
    pick = rng.random()
    if pick < heavy * 0.6:
        return "truck", (rng.uniform(6.0, 11.0), 2.5, rng.uniform(2.8, 3.8))
    if pick < heavy:
        return "bus", (rng.uniform(10.0, 12.5), 2.55, rng.uniform(3.0, 3.3))
    if pick < heavy + 0.02:
        return "motorcyclist", (2.1, 0.8, rng.uniform(1.5, 1.65))
    return car_body(rng)


def _person_size(rng: np.random.Generator) -> tuple[float, float, float]:
    # stature of adults, 1.72 +- 0.09 m (NCD-RisC, 2016, Europe), and some children
    height = rng.normal(1.72, 0.09) if rng.random() < 0.9 else rng.uniform(1.0, 1.45)
    return rng.uniform(0.3, 0.65) * height / 1.72, 0.28 * height, float(np.clip(height, 1.0, 2.0))


def walk(site: Site, quarter: Quarter, rng: np.random.Generator) -> None:
    """People on the sidewalks, alone or together, and some who cross the road."""
    road = site.road
    strip = (road.edge + 0.5, max(road.verge - 0.4, road.edge + 1.2))
    for _ in range(rng.poisson(quarter.people)):
        side, along, across = int(rng.choice(SIDES)), rng.normal(0.0, 30.0), rng.uniform(*strip)
        turn = float(rng.choice((0.0, math.pi))) + rng.normal(0.0, 0.25)
        for companion in range(1 + int(rng.random() < 0.3) + int(rng.random() < 0.1)):
            beside = across + companion * 0.65 * (-1 if across > sum(strip) / 2 else 1)
            if not road.in_junction(along):
                site.place("person", along, side * beside, _person_size(rng), turn=turn, margin=0.05)
    for _ in range(rng.poisson(quarter.people / 8)):
        along = road.junction + road.edge + 2.0 if road.junction is not None else rng.normal(0.0, 25.0)
        along += rng.normal(0.0, 0.8)
        turn = float(rng.choice((-1, 1))) * math.pi / 2 + rng.normal(0.0, 0.15)
        site.place("person", along, rng.uniform(-road.edge, road.edge), _person_size(rng), turn=turn)


def _has_arm(site: Site, side: int) -> bool:
    return site.road.junction is not None and ("left" if side > 0 else "right") in site.road.arms


def fill_junction(site: Site, rng: np.random.Generator) -> None:
    """Traffic lights at the corners, and vehicles in the side roads."""
    road = site.road
    if road.junction is None:
        return
    if rng.random() < 0.6:
        for side, ahead in ((-1, -1), (1, 1), (-1, 1), (1, -1)):
            turn = math.pi if side < 0 else 0.0
            site.place(
                "traffic_light",
                road.junction + ahead * (road.edge + 0.6),
                side * (road.edge + 0.5),
                (0.25, 0.32, 3.3),
                turn=turn + rng.normal(0.0, 0.1),
                stem=2.4,
            )
    for side in SIDES:
        if not _has_arm(site, side):
            continue
        for way in (-1, 1):
            off = road.edge + rng.uniform(4.0, 25.0)
            while off < road.reach - 6.0:
                kind, size = _vehicle(rng, 0.1)
                middle = off + size[0] / 2
                site.place(
                    kind, road.junction + way * road.edge / 2, side * middle, size, turn=way * math.pi / 2, margin=0.4
                )
                off += size[0] + 4.0 + rng.exponential(30.0)
