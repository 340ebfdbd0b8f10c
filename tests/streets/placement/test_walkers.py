"""People on foot."""

import math
from dataclasses import replace

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.ground.relief import Land
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.occupancy import Occupancy, _Placement
from lidardraft.streets.placement.walkers import place_people

FLAT = Land(grade=0.0, hillside=0.0, rolling=0.0)


def people(road: Road, number: float, *, lights: bool = False, seed: int = 0) -> list[_Placement]:
    occupancy = Occupancy(road, Ground(road, np.random.default_rng(0), FLAT))
    place_people(occupancy, replace(DISTRICTS["urban"], people=number), lights, np.random.default_rng(seed))
    return occupancy._placed


def test_nobody_is_where_no_people_are():
    assert people(Road(), 0.0) == []


def test_who_is_on_the_road_crosses_it():
    road = Road(sidewalk=4.0)
    found = [placed for seed in range(10) for placed in people(road, 12.0, seed=seed)]
    on_road = [placed for placed in found if abs(placed.across) < road.edge]
    assert 0 < len(on_road) < 0.2 * len(found)
    assert all(abs(math.cos(placed.angle)) < 0.6 for placed in on_road)
    assert all(abs(placed.across) < road.verge + 1.0 for placed in found)


def test_people_wait_at_all_corners_with_lights_and_look_across():
    road = Road(junction=10.0, sidewalk=3.0)
    corners = set()
    for seed in range(20):
        for placed in people(road, 8.0, lights=True, seed=seed):
            ahead, side = placed.along - 10.0, placed.across
            if abs(ahead) < road.verge and road.edge < abs(side) < road.edge + 1.0:
                corners.add((ahead > 0, side > 0))
                assert math.sin(placed.angle) * side < 0
    assert len(corners) == 4


def test_people_wait_at_a_bus_stop():
    road = Road(sidewalk=4.0)
    occupancy = Occupancy(road, Ground(road, np.random.default_rng(0), FLAT))
    occupancy.stops.append((15.0, -1.0))
    for seed in range(5):
        place_people(occupancy, replace(DISTRICTS["urban"], people=0.0), False, np.random.default_rng(seed))
    assert occupancy._placed
    assert all(abs(p.along - 15.0) < 8.0 and -road.verge < p.across < -road.edge for p in occupancy._placed)
