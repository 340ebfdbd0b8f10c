"""What stands along side roads."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft.scene.road import LEFT, RIGHT, Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.ground.relief import Land
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.occupancy import Occupancy
from lidardraft.streets.placement.side_roads import (
    SideRoadEdge,
    place_beside_side_roads,
    place_side_road_buildings,
)

FLAT = Land(grade=0.0, hillside=0.0, rolling=0.0)


def empty(road: Road) -> Occupancy:
    return Occupancy(road, Ground(road, np.random.default_rng(0), FLAT))


def test_an_edge_is_a_frame_of_its_side_road():
    # the left edge of a side road that leaves to the left is behind the junction
    assert SideRoadEdge(10.0, LEFT, LEFT).at(30.0, 4.0) == pytest.approx((6.0, 30.0, math.pi / 2))
    assert SideRoadEdge(10.0, LEFT, RIGHT).at(30.0, 4.0) == pytest.approx((14.0, 30.0, math.pi / 2))
    assert SideRoadEdge(10.0, RIGHT, LEFT).at(30.0, 4.0) == pytest.approx((14.0, -30.0, -math.pi / 2))


@pytest.mark.parametrize("sides", [(LEFT,), (RIGHT,), (LEFT, RIGHT)])
def test_there_are_objects_beside_the_side_roads_only(sides: tuple[int, ...]):
    district = replace(DISTRICTS["residential"], built=1.0, people=20.0, parked=1.0, street_trees=1.0)
    road = Road(junction=10.0, side_roads=sides, lane_width=6.0)
    occupancy = empty(road)
    place_side_road_buildings(occupancy, district, np.random.default_rng(0))
    place_beside_side_roads(occupancy, district, np.random.default_rng(0))
    kinds = {placed.kind for placed in occupancy._placed}
    assert {"house", "lamp", "tree", "person"} <= kinds
    assert {np.sign(placed.across) for placed in occupancy._placed} == set(sides)
    for placed in occupancy._placed:
        off = abs(placed.along - 10.0)
        if placed.kind in ("house", "shed", "block"):
            assert off - placed.size[1] / 2 > road.verge
            # the front (-y) looks to the side road
            assert math.sin(placed.angle) * (placed.along - 10.0) < 0
        if placed.kind == "lamp":
            assert road.edge < off < road.verge
            # the arm (+y) reaches over the side road
            assert -math.sin(placed.angle) * (10.0 - placed.along) > 0


def test_there_is_nothing_without_a_junction():
    occupancy = empty(Road())
    place_side_road_buildings(occupancy, DISTRICTS["residential"], np.random.default_rng(0))
    place_beside_side_roads(occupancy, DISTRICTS["residential"], np.random.default_rng(0))
    assert occupancy._placed == []
