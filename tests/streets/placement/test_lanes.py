"""Where is driven."""

import math

import numpy as np
import pytest
from planned import plans

from lidardraft.scene.road import LEFT, RIGHT, Road
from lidardraft.streets.placement.district import DISTRICTS, PARKING_STRIP
from lidardraft.streets.placement.lanes import MAIN_ROAD, ROUNDABOUT, SIDE_ROAD, Lane, driven_lanes


def test_lanes_lie_on_the_road():
    for occupancy, lanes, _ in plans():
        for lane in lanes:
            places = np.array([lane.at(share * lane.length)[:2] for share in np.linspace(0.02, 0.98, 25)])
            assert (occupancy.ground.kinds(*places.T) == 0).all(), (occupancy.road, lane)


def test_an_arc_is_followed():
    ring = Lane(kind=ROUNDABOUT, along=3.0, across=0.0, angle=math.pi / 2, length=20 * math.pi, speed=8.0, bend=0.1)
    assert ring.at(0.0) == pytest.approx((3.0, 0.0, math.pi / 2))
    # half way around a circle of 10 m about (-7, 0)
    assert ring.at(10 * math.pi)[:2] == pytest.approx((-17.0, 0.0))
    assert ring.at(5 * math.pi, 1.0)[:2] == pytest.approx((-7.0, 9.0))


def lanes_of(road: Road, parking: tuple[int, ...] = (), *, oneway: bool = False, lights: bool = False) -> list[Lane]:
    return list(driven_lanes(road, DISTRICTS["urban"], parking, None, oneway=oneway, lights=lights))


def test_traffic_keeps_to_the_right_but_in_a_one_way_street():
    for lane in lanes_of(Road(lanes=2)):
        assert math.cos(lane.angle) * lane.across < 0
    assert all(math.cos(lane.angle) > 0 for lane in lanes_of(Road(), oneway=True))


def test_parked_cars_take_room_from_the_lanes():
    road = Road(lane_width=3.0 + PARKING_STRIP / 2)
    free, narrow = lanes_of(road), lanes_of(road, (RIGHT,))
    assert len(free) == len(narrow) == 2
    assert narrow[0].across == pytest.approx(free[0].across + 0.75 * PARKING_STRIP)
    # of several lanes they take the outermost
    assert len(lanes_of(Road(lanes=2), (LEFT, RIGHT))) == 2


def test_traffic_stops_before_the_junction_at_lights_only():
    road = Road(junction=10.0)
    assert all(lane.stop is None for lane in lanes_of(road))
    stopping = [lane for lane in lanes_of(road, lights=True) if lane.stop is not None]
    assert {lane.kind for lane in stopping} == {MAIN_ROAD, SIDE_ROAD}
    for lane in stopping:
        along, across, _ = lane.at(lane.stop)
        assert road.verge + 1.5 <= max(abs(along - 10.0), abs(across)) + 1e-9 <= road.verge + 3.6
    # a roundabout has none
    around = lanes_of(Road(junction=10.0, roundabout_radius=18.0), lights=True)
    assert all(lane.stop is None for lane in around)
    assert [lane.kind for lane in around].count(ROUNDABOUT) == 1
