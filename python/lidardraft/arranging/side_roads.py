"""Objects along side roads: buildings, fences, parked cars, lamps, trees, people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lidardraft.arranging.building_rows import BUILDING_MARGIN, sample_building
from lidardraft.arranging.district import District
from lidardraft.arranging.gardens import piece_across
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.roadside import LAMP_OFF, LEAST_STEM, TREE_OFF, WIDE_SIDEWALK
from lidardraft.arranging.sizes import (
    LAMP_WIDTH,
    sample_enclosure,
    sample_person,
    sample_tree,
)
from lidardraft.objects.cars import sample_car
from lidardraft.scene.road import SIDES

# All numbers are estimates.
_FAR = 75.0  # m from the middle of the road to the last objects
_CORNER = 17.0  # m behind the verge, at which the buildings of the road itself end
_ROUNDABOUT_CORNER = 8.0  # m behind the outer edge of a roundabout, likewise
_BUILDING_SEAM = 0.05  # m
_START = 6.0  # m behind the verge or the roundabout to the first other objects

# Fences, walls and hedges in front of gardens.
_FENCE_OFF = (0.4, 0.8)  # m from the verge
_FENCE_LENGTHS = (3.0, 9.0)  # m, limits of the longest piece
_FENCE_RISE = 0.25  # m of rise of the ground under a piece at most
_FENCE_LENGTH = (0.6, 1.0)  # of the longest
_ADJOINING, _FENCE_SEAM, _FENCE_GAP = 0.6, 0.1, (1.2, 5.0)  # share of pieces that adjoin, m between them, and others

_LAMP_HEIGHT = (4.5, 8.0)  # m
_LAMP_SPACING = 4.0  # heights
_FIRST_LAMP = (0.0, 15.0)  # m from the start
_LAMP_LENGTH = 0.15  # m

_TREE_SPACING = (8.0, 15.0)  # m: as street trees are planted (GALK)
_FIRST_TREE = (0.0, 8.0)  # m from the start
_TREE_VERGE = 3.5  # m from the verge, if the sidewalk is narrow
_TREE_CROWN = 0.7  # of the width of a crown with more room
_TREE_MARGIN, _TREE_ANGLE = 0.05, (0.0, 3.0)  # m, rad

_PARKING_EDGE = 6.0  # m from the middle of the road to its kerb, for room to park
_PARKED = (0.3, 0.8)  # share of the places
_PARKING_GAP, _TO_KERB = (0.6, 2.0), 0.2  # m between two cars, and to the kerb
_ASKEW, _PARKED_MARGIN = 0.015, 0.05  # rad, deviation; m

_PEOPLE = 12  # people of the road itself for one on an edge of a side road
_PEOPLE_FAR = 50.0  # m from the middle of the road
_OFF_WAY = 0.2  # rad against the side road, deviation


@dataclass(frozen=True, slots=True)
class SideRoadEdge:
    """One edge of a side road, to place objects by: the `junction` [m along], the `side` (1 or -1 across) on which the
    side road leaves, and whether this edge is on its left (1) or right (-1), seen outwards.
    """

    junction: float
    side: int
    left: int

    def at(self, distance: float, off: float) -> tuple[float, float, float]:
        """Along, across [m] and outward angle [rad], `distance` [m] from the middle of the road and `off` [m] from that
        of the side road."""
        return self.junction - self.side * self.left * off, self.side * distance, self.side * math.pi / 2

    @property
    def turned(self) -> float:
        """The turn [rad] that makes an object for the right edge face the side road at this edge."""
        return math.pi if self.left > 0 else 0.0


def _side_road_edges(occupancy: Occupancy) -> Iterator[SideRoadEdge]:
    """The edges of a straight road's side roads; the frame of a bend widens outwards."""
    road = occupancy.road
    if road.junction is not None and not road.curvature:
        for side in SIDES:
            if side in road.side_roads:
                yield from (SideRoadEdge(road.junction, side, left) for left in SIDES)


def place_side_road_buildings(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Buildings along the side roads, behind the corner; they face them."""
    road = occupancy.road
    corner = 0.0 if road.roundabout_radius is None else road.roundabout_radius + _ROUNDABOUT_CORNER
    for edge in _side_road_edges(occupancy):
        setback = rng.uniform(*district.setback)
        distance = max(road.verge + _CORNER, corner)
        while distance < _FAR:
            kind, size, eaves = sample_building(district, rng)
            if rng.random() < district.built:
                along, across, angle = edge.at(distance + size[0] / 2, road.verge + setback + size[1] / 2)
                # the front (-y) looks to the side road
                angle += 0.0 if edge.left > 0 else math.pi
                occupancy.place(
                    kind, along, across, size, angle=angle, clearance=eaves, margin=BUILDING_MARGIN, private=True
                )
            distance += size[0] + rng.uniform(*district.gap) + _BUILDING_SEAM


def place_beside_side_roads(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Fences, lamps, trees, parked cars and people beside the side roads."""
    road = occupancy.road
    start = _START + (road.verge if road.roundabout_radius is None else road.roundabout_radius + road.sidewalk)
    for edge in _side_road_edges(occupancy):
        if rng.random() < district.front_fences:
            _place_fences(occupancy, edge, start, district.green, rng)
        if road.sidewalk > 0:
            _place_lamps(occupancy, edge, start, rng)
        if rng.random() < district.street_trees:
            _place_trees(occupancy, edge, start, rng)
        if road.edge > _PARKING_EDGE and rng.random() < district.parked:
            _place_parked_cars(occupancy, edge, start, rng)
        for _ in range(rng.poisson(district.people / _PEOPLE)):
            along, across, angle = edge.at(rng.uniform(start, _PEOPLE_FAR), road.edge + 0.5 * road.sidewalk)
            angle += math.pi * (rng.random() < 0.5) + rng.normal(0.0, _OFF_WAY)
            occupancy.place("person", along, across, sample_person(rng, standing=False), angle=angle)


def _place_fences(
    occupancy: Occupancy, edge: SideRoadEdge, start: float, green: float, rng: np.random.Generator
) -> None:
    distance, off = start, occupancy.road.verge + rng.uniform(*_FENCE_OFF)
    longest = piece_across(occupancy, edge.side, *_FENCE_LENGTHS, _FENCE_RISE)
    while distance < _FAR:
        kind, width, height = sample_enclosure(green, rng)
        length = rng.uniform(*_FENCE_LENGTH) * longest
        along, across, angle = edge.at(distance + length / 2, off + width / 2)
        occupancy.place(kind, along, across, (length, width, height), angle=angle, margin=0.0, private=True)
        distance += length + (_FENCE_SEAM if rng.random() < _ADJOINING else rng.uniform(*_FENCE_GAP))


def _place_lamps(occupancy: Occupancy, edge: SideRoadEdge, start: float, rng: np.random.Generator) -> None:
    height = rng.uniform(*_LAMP_HEIGHT)
    for distance in np.arange(start + rng.uniform(*_FIRST_LAMP), _FAR, _LAMP_SPACING * height).tolist():
        along, across, angle = edge.at(distance, occupancy.road.edge + LAMP_OFF)
        # the arm of the lamp is to its left
        size = (_LAMP_LENGTH, LAMP_WIDTH, height)
        occupancy.place("lamp", along, across, size, angle=angle + edge.turned)


def _place_trees(occupancy: Occupancy, edge: SideRoadEdge, start: float, rng: np.random.Generator) -> None:
    road = occupancy.road
    off = road.edge + TREE_OFF if road.sidewalk > WIDE_SIDEWALK else road.verge + _TREE_VERGE
    for distance in np.arange(start + rng.uniform(*_FIRST_TREE), _FAR, rng.uniform(*_TREE_SPACING)).tolist():
        (length, width, height), stem = sample_tree(rng)
        along, across, _ = edge.at(distance, off)
        size, stem = (_TREE_CROWN * length, _TREE_CROWN * width, height), max(stem, LEAST_STEM)
        angle = rng.uniform(*_TREE_ANGLE)
        occupancy.place("tree", along, across, size, angle=angle, clearance=stem, margin=_TREE_MARGIN)


def _place_parked_cars(occupancy: Occupancy, edge: SideRoadEdge, start: float, rng: np.random.Generator) -> None:
    distance, taken = start, rng.uniform(*_PARKED)
    while distance < _FAR:
        kind, size = sample_car(rng)
        if rng.random() < taken:
            off = occupancy.road.edge - _TO_KERB - size[1] / 2
            along, across, angle = edge.at(distance + size[0] / 2, off)
            angle += edge.turned + rng.normal(0.0, _ASKEW)
            occupancy.place(kind, along, across, size, angle=angle, margin=_PARKED_MARGIN)
        distance += size[0] + rng.uniform(*_PARKING_GAP)
