"""Buildings along a street."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft.scene.road import Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.ground.relief import Land
from lidardraft.streets.placement.building_rows import place_buildings, sample_building
from lidardraft.streets.placement.car_parks import sample_car_park
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.occupancy import Occupancy

FLAT = Land(grade=0.0, hillside=0.0, rolling=0.0)


def empty(road: Road) -> Occupancy:
    return Occupancy(road, Ground(road, np.random.default_rng(0), FLAT))


@pytest.mark.parametrize("name", ["residential", "urban", "retail"])
def test_buildings_look_to_the_road_from_behind_the_verge(name: str):
    occupancy = empty(Road())
    place_buildings(occupancy, DISTRICTS[name], None, np.random.default_rng(0))
    sides = set()
    for placed in occupancy._placed:
        if placed.kind not in ("house", "block", "shed"):
            continue
        sides.add(placed.across > 0)
        # the front is -y
        assert math.cos(placed.angle) * placed.across > 0
        assert abs(math.sin(placed.angle)) < 0.1
        assert abs(placed.across) - placed.size[1] / 2 > occupancy.road.verge - 0.5
    assert sides == {True, False}


def test_closed_fronts_stand_wall_to_wall_and_open_rows_do_not():
    def gaps(name: str) -> np.ndarray:
        occupancy = empty(Road(sidewalk=3.0))
        place_buildings(occupancy, replace(DISTRICTS[name], blocks=1.0), None, np.random.default_rng(1))
        front = sorted(
            (p.along - p.size[0] / 2, p.along + p.size[0] / 2)
            for p in occupancy._placed
            if p.kind == "block" and 0 < p.across - p.size[1] / 2 < occupancy.road.verge + 13.0
        )
        return np.array([after[0] - before[1] for before, after in itertools.pairwise(front)])

    assert np.median(gaps("urban")) < 0.1
    assert gaps("residential").min() > 1.0


def test_a_hall_stands_behind_its_car_park():
    road = Road()
    car_park = sample_car_park(road, 1, np.random.default_rng(2))
    occupancy = Occupancy(
        replace(road, paved_areas=(car_park.paved_area,)), Ground(road, np.random.default_rng(0), FLAT)
    )
    place_buildings(occupancy, DISTRICTS["retail"], car_park, np.random.default_rng(3))
    hall = occupancy._placed[0]
    assert (hall.kind, np.sign(hall.across)) == ("shed", car_park.side)
    assert abs(hall.across) - hall.size[1] / 2 > max(map(abs, car_park.paved_area.across))


def test_a_roof_is_over_its_eaves():
    rng = np.random.default_rng(0)
    houses = [
        building
        for building in (sample_building(DISTRICTS["country"], rng) for _ in range(50))
        if building[0] == "house"
    ]
    assert houses
    assert all(1.0 < size[2] - eaves < 6.0 for _, size, eaves in houses)
