"""Car parks: rows of bays beside the road, with an aisle between two rows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.objects.cars import sample_car
from lidardraft.scene.road import PavedArea, Road
from lidardraft.streets.placement.occupancy import Occupancy
from lidardraft.streets.placement.walkers import person_size

# EAR 05 and RASt 06: bays of 2.5 x 5.0 m at right angles to an aisle of 6.0 m.
BAY_WIDTH, BAY_LENGTH, AISLE = 2.5, 5.0, 6.0
_MODULE = 2 * BAY_LENGTH + AISLE
ACCESS = 6.0  # m, the width of the way in


@dataclass(frozen=True, kw_only=True, slots=True)
class CarPark:
    """A car park beside the road: `paved_area` is where cars stand, `side` 1 (left) or -1. The way in is `access`,
    with its middle at `gate` [m along]; `aisles` are driven, `rows` hold bays: middle across [m] and side (1 or -1) of
    the aisle.
    """

    side: int
    paved_area: PavedArea
    access: PavedArea
    gate: float
    aisles: tuple[float, ...]
    rows: tuple[tuple[float, int], ...]


def sample_car_park(road: Road, modules: int, rng: np.random.Generator) -> CarPark:
    """A car park of so many double rows, near the middle of a straight road and clear of its side roads."""
    side = 1 if rng.random() < 0.5 else -1
    length = rng.uniform(26.0, max(30.0, min(70.0, 0.7 * road.half_length)))
    start = rng.uniform(-0.75, -0.25) * length
    if road.junction is not None:
        if len(road.side_roads) == 1:
            side = -road.side_roads[0]
        else:
            clear = road.verge + 3.0
            start = road.junction + clear if road.junction < 0 else road.junction - clear - length
    near = road.verge + rng.uniform(0.6, 4.0)
    far = near + modules * _MODULE
    gate = start + rng.uniform(0.1, 0.9) * (length - ACCESS) + ACCESS / 2
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
            (gate - ACCESS / 2, gate + ACCESS / 2), (road.edge, near) if side > 0 else (-near, -road.edge)
        ),
        gate=gate,
        aisles=tuple(aisles),
        rows=tuple(rows),
    )


def place_in_car_park(occupancy: Occupancy, car_park: CarPark, rng: np.random.Generator) -> None:
    """Cars in the bays, nose to the aisle or from it; lamps and trees between the rows; people on the way."""
    occupied = rng.uniform(0.1, 0.65)
    count = int((car_park.paved_area.along[1] - car_park.paved_area.along[0]) / BAY_WIDTH)
    for across, toward in car_park.rows:
        for bay in range(count):
            along = car_park.paved_area.along[0] + (bay + 0.5) * BAY_WIDTH
            if abs(along - car_park.gate) < (ACCESS + BAY_WIDTH) / 2 or rng.random() > occupied:
                continue
            kind, size = sample_car(rng)
            # nose-in: three in four, an estimate of ours
            heading = -toward if rng.random() < 0.75 else toward
            angle = heading * math.pi / 2 + rng.normal(0.0, 0.03)
            off = rng.normal(0.0, 0.12)
            occupancy.place(kind, along + off, across + toward * rng.uniform(-0.1, 0.4), size, angle=angle, margin=0.05)
    for edge in car_park.paved_area.across:
        if rng.random() < 0.5:
            height = rng.uniform(4.5, 8.0)
            for along in np.arange(
                car_park.paved_area.along[0] + 5.0, car_park.paved_area.along[1], rng.uniform(16.0, 24.0)
            ).tolist():
                out = edge + math.copysign(0.5, edge - car_park.aisles[0])
                occupancy.place("lamp", along, out, (0.15, 0.2, height), angle=rng.uniform(0.0, 3.0))
    for _ in range(rng.poisson(2.0)):
        along, across = (
            rng.uniform(*car_park.paved_area.along),
            car_park.aisles[int(rng.integers(len(car_park.aisles)))],
        )
        size = person_size(rng, standing=False)
        occupancy.place("person", along, across + rng.uniform(-2.0, 2.0), size, angle=rng.uniform(0, 6.28), margin=0.1)
