"""Vehicles in their lanes and along the kerb."""

import itertools
import math

import numpy as np
from planned import plans

from lidardraft.scene.road import LEFT, RIGHT, Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.lanes import driven_lanes
from lidardraft.streets.placement.occupancy import Occupancy
from lidardraft.streets.placement.traffic import place_parked_vehicles, place_traffic


def test_traffic_drives_on_the_road():
    for occupancy, _, name in plans():
        for index, placed in enumerate(occupancy.objects):
            if placed.kind in ("bus", "truck", "trailer_truck", "motorcyclist", "cyclist", "tram"):
                placed = occupancy._placed[index]
                assert occupancy.ground.surface(placed.along, placed.across) == "road", (name, placed)


def test_traffic_keeps_its_distance():
    for occupancy, lanes, name in plans():
        if name != "motorway" or occupancy.road.curvature:
            continue
        for lane in lanes:
            inside = [
                p for p in occupancy._placed if abs(p.across - lane.across) < 0.5 and p.kind not in ("barrier", "pole")
            ]
            spans = sorted((p.along - p.size[0] / 2, p.along + p.size[0] / 2) for p in inside)
            gaps = [after[0] - before[1] for before, after in itertools.pairwise(spans)]
            assert all(gap > 1.9 for gap in gaps)


def empty(road: Road) -> Occupancy:
    return Occupancy(road, Ground(road, np.random.default_rng(0)))


def test_parked_vehicles_stand_at_the_kerb_and_clear_of_the_junction():
    for seed in range(10):
        road = Road(lane_width=5.0, junction=10.0)
        occupancy = empty(road)
        place_parked_vehicles(occupancy, (RIGHT, LEFT), None, np.random.default_rng(seed))
        assert {np.sign(p.across) for p in occupancy._placed} == {-1, 1}
        for placed in occupancy._placed:
            kerb = road.edge - abs(placed.across) - placed.size[1] / 2
            assert 0.1 < kerb < 0.35, placed
            assert abs(math.sin(placed.angle)) < 0.1
            assert abs(placed.along - 10.0) > road.verge + 5.0


def test_vehicles_face_the_way_of_their_lane():
    for seed in range(10):
        road = Road(lanes=2, junction=20.0)
        occupancy = empty(road)
        lanes = driven_lanes(road, DISTRICTS["urban"], (), None, oneway=False, lights=True)
        place_traffic(occupancy, DISTRICTS["urban"], lanes, np.random.default_rng(seed))
        for placed in occupancy._placed:
            along_road = abs(math.sin(placed.angle)) < 0.2
            # right-hand traffic
            right = (
                -placed.across * math.cos(placed.angle)
                if along_road
                else (placed.along - 20.0) * math.sin(placed.angle)
            )
            assert right > 0, placed


def test_vehicles_wait_at_the_line_of_a_red_light():
    waiting = 0
    for seed in range(20):
        road = Road(junction=20.0)
        occupancy = empty(road)
        lanes = driven_lanes(road, DISTRICTS["urban"], (), None, oneway=False, lights=True)
        place_traffic(occupancy, DISTRICTS["urban"], lanes, np.random.default_rng(seed))
        for lane in (lane for lane in lanes if lane.stop is not None):
            for placed in occupancy._placed:
                along, across, _ = lane.at(lane.stop - placed.size[0] / 2 - 0.5)
                waiting += math.hypot(placed.along - along, placed.across - across) < 0.6
    # two lanes have a red light; by chance alone there would be few
    assert waiting > 25
