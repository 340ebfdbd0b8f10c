"""What stands along side roads: buildings, fences, parked cars, lamps, trees, people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lidardraft.objects.cars import sample_car
from lidardraft.streets.placement.building_rows import sample_building
from lidardraft.streets.placement.district import SIDES, District
from lidardraft.streets.placement.gardens import tree_size
from lidardraft.streets.placement.occupancy import Occupancy
from lidardraft.streets.placement.walkers import person_size

_FAR = 75.0  # m, side roads are furnished up to here
_CORNER = 17.0  # m behind the verge where the buildings of the road itself end


@dataclass(frozen=True, slots=True)
class SideRoadEdge:
    """One side of a side road: `junction` [m along], the side (1 or -1 across) on which it leaves the road, and the
    side (1 or -1) of it seen outwards, 1 being left.
    """

    junction: float
    side: int
    left: int

    def at(self, distance: float, off: float) -> tuple[float, float, float]:
        """Along, across [m] and outward angle [rad], `distance` from the road's middle, `off` from the side road's."""
        return self.junction - self.side * self.left * off, self.side * distance, self.side * math.pi / 2


def _side_road_edges(occupancy: Occupancy) -> Iterator[SideRoadEdge]:
    road = occupancy.road
    if road.junction is not None:
        for side in SIDES:
            if side in road.side_roads:
                yield from (SideRoadEdge(road.junction, side, left) for left in SIDES)


def place_side_road_buildings(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Buildings along the side roads, behind the corner; they look to them."""
    road = occupancy.road
    for edge in _side_road_edges(occupancy):
        setback = rng.uniform(*district.setback)
        distance = max(road.verge + _CORNER, 0.0 if road.roundabout_radius is None else road.roundabout_radius + 8.0)
        while distance < _FAR:
            kind, size, eaves = sample_building(district, rng)
            if rng.random() < district.built:
                along, across, angle = edge.at(distance + size[0] / 2, road.verge + setback + size[1] / 2)
                # the front (-y) looks to the side road
                angle += 0.0 if edge.left > 0 else math.pi
                occupancy.place(kind, along, across, size, angle=angle, clearance=eaves, margin=0.02, private=True)
            distance += size[0] + rng.uniform(*district.gap) + 0.05


def place_beside_side_roads(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Fences, lamps, trees, parked cars and people beside the side roads."""
    road = occupancy.road
    start = 6.0 + (road.verge if road.roundabout_radius is None else road.roundabout_radius + road.sidewalk)
    for edge in _side_road_edges(occupancy):
        if rng.random() < district.fronts:
            _front(occupancy, edge, start, rng)
        if road.sidewalk > 0:
            _lamps(occupancy, edge, start, rng)
        if rng.random() < district.row_trees:
            _trees(occupancy, edge, start, rng)
        if road.edge > 6.0 and rng.random() < district.parked:
            _parked(occupancy, edge, start, rng)
        for _ in range(rng.poisson(district.people / 6)):
            along, across, angle = edge.at(rng.uniform(start, 50.0), road.edge + 0.5 * road.sidewalk)
            angle += math.pi * (rng.random() < 0.5) + rng.normal(0.0, 0.2)
            occupancy.place("person", along, across, person_size(rng, standing=False), angle=angle)


def _front(occupancy: Occupancy, edge: SideRoadEdge, start: float, rng: np.random.Generator) -> None:
    distance, off = start, occupancy.road.verge + rng.uniform(0.4, 0.8)
    slope = abs(float(occupancy.ground.relief.hillside[0 if edge.side > 0 else 1]))
    longest = max(3.0, min(9.0, 0.25 / max(slope, 1e-3)))
    while distance < _FAR:
        kind = ("fence", "garden_wall", "hedge", "hedge")[int(rng.integers(4))]
        thick = {"fence": 0.1, "garden_wall": 0.3, "hedge": rng.uniform(0.6, 1.2)}[kind]
        length, height = rng.uniform(0.6, 1.0) * longest, rng.uniform(0.8, 1.8)
        along, across, angle = edge.at(distance + length / 2, off + thick / 2)
        occupancy.place(kind, along, across, (length, thick, height), angle=angle, margin=0.0, private=True)
        distance += length + (0.1 if rng.random() < 0.6 else rng.uniform(1.2, 5.0))


def _lamps(occupancy: Occupancy, edge: SideRoadEdge, start: float, rng: np.random.Generator) -> None:
    height = rng.uniform(4.5, 8.0)
    for distance in np.arange(start + rng.uniform(0.0, 15.0), _FAR, 4.0 * height).tolist():
        along, across, angle = edge.at(distance, occupancy.road.edge + 0.45)
        angle += math.pi if edge.left > 0 else 0.0  # the arm of the lamp is to its left
        occupancy.place("lamp", along, across, (0.15, 0.2, height), angle=angle)


def _trees(occupancy: Occupancy, edge: SideRoadEdge, start: float, rng: np.random.Generator) -> None:
    road = occupancy.road
    off = road.edge + 0.8 if road.sidewalk > 2.0 else road.verge + 3.5
    for distance in np.arange(start + rng.uniform(0.0, 8.0), _FAR, rng.uniform(8.0, 15.0)).tolist():
        (length, width, height), clearance = tree_size(rng)
        along, across, _ = edge.at(distance, off)
        size = (0.7 * length, 0.7 * width, height)
        occupancy.place(
            "tree", along, across, size, angle=rng.uniform(0.0, 3.0), clearance=max(clearance, 2.6), margin=0.05
        )


def _parked(occupancy: Occupancy, edge: SideRoadEdge, start: float, rng: np.random.Generator) -> None:
    distance, density = start, rng.uniform(0.3, 0.8)
    while distance < _FAR:
        kind, size = sample_car(rng)
        if rng.random() < density:
            along, across, angle = edge.at(distance + size[0] / 2, occupancy.road.edge - 0.2 - size[1] / 2)
            angle += (math.pi if edge.left > 0 else 0.0) + rng.normal(0.0, 0.015)
            occupancy.place(kind, along, across, size, angle=angle, margin=0.05)
        distance += size[0] + rng.uniform(0.6, 2.0)
