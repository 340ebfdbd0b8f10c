"""What road authorities build."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft.scene.road import Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.ground.relief import Land
from lidardraft.streets.placement.district import DISTRICTS, RoadEquipment
from lidardraft.streets.placement.occupancy import Occupancy
from lidardraft.streets.placement.road_equipment import place_road_equipment, place_traffic_lights

FLAT = Land(grade=0.0, hillside=0.0, rolling=0.0)


def empty(road: Road) -> Occupancy:
    return Occupancy(road, Ground(road, np.random.default_rng(0), FLAT))


def equipped(road: Road, equipment: RoadEquipment, seed: int = 0) -> Occupancy:
    occupancy = empty(road)
    place_road_equipment(occupancy, replace(DISTRICTS["urban"], equipment=equipment), np.random.default_rng(seed))
    return occupancy


NOTHING = RoadEquipment(cones=0.0)
WIDE = Road(lanes=2, sidewalk=0.0, median=4.0)


def test_a_district_without_equipment_has_none_and_takes_no_random_numbers():
    rng = np.random.default_rng(0)
    occupancy = empty(Road())
    place_road_equipment(occupancy, replace(DISTRICTS["urban"], equipment=NOTHING), rng)
    assert occupancy._placed == []
    assert rng.random() == np.random.default_rng(0).random()


@pytest.mark.parametrize(
    ("fields", "kinds"),
    [
        ({"median_barrier": True}, {"barrier"}),
        ({"rails": 1.0}, {"barrier"}),
        ({"short_rails": 1.0}, {"barrier"}),
        ({"noise_walls": 1.0, "deer_fences": 1.0}, {"wall"}),
        ({"deer_fences": 1.0}, {"mesh_fence"}),
        ({"gantries": 1.0}, {"gantry"}),
        ({"delineators": True}, {"pole"}),
        ({"cones": 1.0}, {"cone"}),
    ],
)
def test_each_piece_of_equipment_is_what_its_field_says(fields: dict, kinds: set[str]):
    occupancy = equipped(WIDE, replace(NOTHING, **fields))
    assert {placed.kind for placed in occupancy._placed} == kinds
    for placed in occupancy._placed:
        if placed.kind in ("wall", "mesh_fence", "pole") or "rails" in fields:
            assert abs(placed.across) > WIDE.edge
        if "median_barrier" in fields:
            assert abs(placed.across) < WIDE.median / 2


def test_rails_face_the_road_from_end_to_end():
    occupancy = equipped(WIDE, replace(NOTHING, rails=1.0))
    for side in (-1, 1):
        rails = sorted((p.along, p.size[0]) for p in occupancy._placed if p.across * side > 0)
        assert sum(length for _, length in rails) == pytest.approx(2 * WIDE.half_length, rel=0.01)
    for placed in occupancy._placed:
        # the face is the left (+y)
        assert math.cos(placed.angle) * placed.across < 0


def test_what_is_shorter_than_a_seam_is_no_piece():
    # pieces of 12 m leave 1 cm, of which the seam takes 2
    road = replace(WIDE, half_length=30.005)
    assert 0 < 2 * road.half_length % 12.0 < 0.02
    for placed in equipped(road, replace(NOTHING, rails=1.0))._placed:
        assert placed.size[0] > 0


def test_delineators_are_fifty_metres_apart():
    occupancy = equipped(WIDE, replace(NOTHING, delineators=True))
    left = sorted(p.along for p in occupancy._placed if p.across > 0)
    assert np.diff(left) == pytest.approx(50.0)


def test_nothing_stands_in_the_junction():
    road = Road(junction=10.0, sidewalk=0.0)
    occupancy = equipped(road, replace(NOTHING, rails=1.0, noise_walls=1.0, delineators=True))
    assert occupancy._placed
    for placed in occupancy._placed:
        assert abs(placed.along - 10.0) - placed.size[0] / 2 > road.verge


def test_lights_stand_at_the_corners_and_face_the_traffic_that_comes():
    road = Road(junction=10.0)
    occupancy = empty(road)
    place_traffic_lights(occupancy, np.random.default_rng(0))
    assert {(p.along > 10.0, p.across > 0) for p in occupancy._placed} == {
        (a, b) for a in (True, False) for b in (True, False)
    }
    for placed in occupancy._placed:
        assert road.edge < abs(placed.across) < road.verge
        # a light on the right faces those who drive ahead
        assert math.cos(placed.angle) * placed.across > 0
