"""What there is in streets of all districts."""

import math
from collections import Counter

import numpy as np
from planned import occupancies, plans

from lidardraft.scene.road import LEFT, RIGHT
from lidardraft.streets.ego import sample_ego
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.lanes import MAIN_ROAD
from lidardraft.streets.placement.plan import plan_street


def test_every_district_and_every_form_of_road_occurs():
    assert {name for _, _, name in plans()} == set(DISTRICTS)
    roads = [occupancy.road for occupancy in occupancies()]
    side_roads = Counter(
        road.side_roads for road in roads if road.junction is not None and road.roundabout_radius is None
    )
    assert set(side_roads) == {(LEFT, RIGHT), (LEFT,), (RIGHT,)}
    assert {len(road.side_roads) for road in roads if road.roundabout_radius is not None} == {1, 2}
    assert any(road.curvature > 0 for road in roads)
    assert any(road.curvature < 0 for road in roads)
    assert any(road.paved_areas for road in roads)
    assert any(road.median > 1.5 and road.sidewalk > 0 for road in roads)
    assert {road.lanes for road in roads} == {1, 2, 3}
    directions = [{math.cos(lane.angle) > 0 for lane in lanes if lane.kind == MAIN_ROAD} for _, lanes, _ in plans()]
    assert {True} in directions  # one-way
    assert {True, False} in directions
    assert any(occupancy.ground.strip > 0 for occupancy in occupancies())


def test_every_kind_of_object_occurs():
    kinds = Counter(placed.kind for occupancy in occupancies() for placed in occupancy.objects)
    wanted = """house block shed tree bush hedge lamp pole sign traffic_light fence garden_wall bin bench shelter cone
        barrier mesh_fence grass gantry wall billboard letterbox hydrant cabinet truck bus trailer_truck tram bicycle
        cyclist motorcycle motorcyclist person hatchback saloon estate suv minivan coupe pickup van"""
    assert set(wanted.split()) <= set(kinds)
    standing = [t for occupancy in occupancies() for t in occupancy.objects if t.kind == "person" and t.size[0] <= 0.3]
    assert 0.1 < len(standing) / kinds["person"] < 0.8


def test_streets_of_any_length():
    for seed in range(30):
        for half_length in (40.0, 200.0):
            occupancy, lanes, _ = plan_street(np.random.default_rng([seed, 77]), half_length)
            assert sample_ego(occupancy, lanes, np.random.default_rng(0)).lane in lanes


def test_a_plan_is_a_function_of_its_generator():
    for seed in (0, 3, 8):
        one, two = (plan_street(np.random.default_rng([seed]), 90.0) for _ in range(2))
        assert one[0].objects == two[0].objects
        assert one[1:] == two[1:]
        assert (one[0].ground.heights(*np.ones((2, 3))) == two[0].ground.heights(*np.ones((2, 3)))).all()
