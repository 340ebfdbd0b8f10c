"""Street furniture and trees."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.ground.relief import Land
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.occupancy import Occupancy
from lidardraft.streets.placement.roadside import (
    place_high_grass,
    place_island_plants,
    place_street_furniture,
    place_street_trees,
)

FLAT = Land(grade=0.0, hillside=0.0, rolling=0.0)


def empty(road: Road) -> Occupancy:
    return Occupancy(road, Ground(road, np.random.default_rng(0), FLAT))


def furnished(road: Road, name: str, seeds: int = 20, **fields: float) -> list[Occupancy]:
    district = replace(DISTRICTS[name], **fields)
    found = []
    for seed in range(seeds):
        found.append(empty(road))
        place_street_furniture(found[-1], district, None, np.random.default_rng(seed))
    return found


def test_lamps_stand_off_the_road_as_far_apart_as_their_height_allows_and_reach_over_it():
    lit = 0
    for occupancy in furnished(Road(), "residential"):
        for side in (-1, 1):
            lamps = [p for p in occupancy._placed if p.kind == "lamp" and p.across * side > 0]
            lit += bool(lamps)
            for lamp in lamps:
                assert occupancy.road.edge + 0.3 < abs(lamp.across) < occupancy.road.verge
                # the arm is to the left (+y)
                assert math.cos(lamp.angle) * lamp.across < 0
            steps = np.diff(sorted(lamp.along for lamp in lamps))
            if len(steps):
                assert 3.3 * lamps[0].size[2] - 1e-6 <= steps.min() <= 4.5 * lamps[0].size[2]
    assert lit > 20


def test_furniture_stands_on_the_sidewalk_and_benches_look_to_the_road():
    kinds: Counter[str] = Counter()
    for occupancy in furnished(Road(sidewalk=4.0), "urban", 40, people=5.0):
        for placed in occupancy._placed:
            kinds[placed.kind] += 1
            assert abs(placed.across) > occupancy.road.edge, placed
            if placed.kind != "billboard":
                assert abs(placed.across) < occupancy.road.verge, placed
            if placed.kind == "sign" and abs(math.cos(placed.angle)) > 0.5:
                # the face (+x) looks at the traffic that comes on that side
                assert math.cos(placed.angle) * placed.across > 0
        assert all(abs(along) < 55.0 for along, _ in occupancy.stops)
        assert sum(placed.kind == "shelter" for placed in occupancy._placed) == len(occupancy.stops)
    assert {"lamp", "sign", "pole", "bin", "bench", "cabinet", "hydrant", "shelter", "bicycle"} <= set(kinds)


def test_outside_towns_there_are_signs_and_no_benches():
    kinds = {p.kind for occupancy in furnished(Road(sidewalk=0.0), "country") for p in occupancy._placed}
    assert kinds == {"sign", "lamp"}


def test_street_trees_stand_in_rows_over_what_passes_under_them():
    occupancy = empty(Road(lanes=2, median=4.0))
    place_street_trees(occupancy, replace(DISTRICTS["avenue"], street_trees=1.0), np.random.default_rng(2))
    rows = {round(abs(placed.across), 6) for placed in occupancy._placed}
    assert len(rows) <= 3
    for placed in occupancy._placed:
        assert placed.clearance >= (4.5 if placed.across == 0.0 else 2.6)
        assert placed.size[2] >= placed.clearance + 1.5 - 1e-9
    assert len(occupancy._placed) > 15


def test_an_island_keeps_its_plants_and_signs():
    road = Road(junction=10.0, roundabout_radius=20.0)
    occupancy = empty(road)
    place_island_plants(occupancy, np.random.default_rng(1))
    signs = [placed for placed in occupancy._placed if placed.kind == "sign"]
    assert len(signs) == 4
    for placed in occupancy._placed:
        assert math.hypot(placed.along - 10.0, placed.across) < road.island
    assert any(placed.kind == "bush" for placed in occupancy._placed)


def test_high_grass_grows_outside_towns():
    town, country = empty(Road()), empty(Road(sidewalk=0.0))
    for occupancy in (town, country):
        for seed in range(4):
            place_high_grass(occupancy, np.random.default_rng(seed))
    assert town._placed == []
    assert len(country._placed) > 20
    assert {placed.across > 0 for placed in country._placed} == {True, False}
    for placed in country._placed:
        assert abs(placed.across) - placed.size[1] / 2 > country.road.edge
