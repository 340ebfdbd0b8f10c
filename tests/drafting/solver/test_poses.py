"""Where one object may be: in zones of the road, in lanes and bays, where roads meet, and from other objects."""

import math
from functools import partial

import numpy as np
import pytest

from lidardraft.drafting.solver.poses import (
    BAY_LENGTH,
    BAY_WIDTH,
    LOT_DEPTH,
    LOT_DEPTHS,
    PoseSampler,
    RoadPose,
    Try,
    at_corner,
    before_and_after,
    in_aisle,
    in_bay,
    in_turn,
    lot_edge,
    on_crossing_road,
    row_poses,
    set_down,
)
from lidardraft.drafting.solver.relative_poses import Footprint, RelativePoses
from lidardraft.drafting.solver.road_zones import along_row, zone_of
from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.scene.road import LEFT, RIGHT, PavedArea, Road

ROAD = Road(lanes=2, parking=2.2, sidewalk=2.0, junction=40.0)
CROSSROADS = Road(junction=40.0)
LANE = 3.0  # m
LOT = Road(
    lane_width=LANE,
    sidewalk=0.0,
    paved_areas=tuple(PavedArea((-30.0, 30.0), a) for a in ((-LANE - LOT_DEPTH, -LANE), (LANE, LANE + LOT_DEPTH))),
)


def sampled(sample_pose: PoseSampler, effort: float = 0.2, along: float = 40.0) -> list[RoadPose]:
    rng = np.random.default_rng(0)
    return [sample_pose(Try(rng, along, number, effort)) for number in range(50)]


def in_zone(place: str, **fields: object) -> list[RoadPose]:
    """Poses over the whole zone of a group at a place, of the first objects and later ones."""
    group = ObjectGroup(**fields)  # type: ignore[arg-type]
    zone, rng = zone_of(group, group.record, place, ROAD), np.random.default_rng(0)
    tries = [
        Try(rng, along, number, effort)
        for along in np.linspace(*zone.span, 5).tolist()
        for number in range(3)
        for effort in (0.0, 0.9)
    ]
    return list(map(zone.sample_pose, tries))


def test_what_drives_keeps_to_its_lane_and_direction() -> None:
    for pose in in_zone("", kind="car"):
        lanes = [ROAD.lane(number, direction) for number in range(2) for direction in (1, -1)]
        assert min(abs(pose.across - lane) for lane in lanes) <= 0.15
        assert (math.cos(pose.yaw) > 0) == (pose.across < 0)
    assert all(abs(p.across) == pytest.approx(ROAD.edge - 1.1) for p in in_zone("", kind="car", heading="parked"))
    assert min(pose.across for pose in in_zone("front", kind="bicycle")) < ROAD.lane(0) - 0.9  # on the right of it


def test_what_is_oncoming_or_stands_in_the_way_is_ahead() -> None:
    assert all(pose.along > 0 for pose in in_zone("", kind="car", heading="against"))
    assert any(pose.along < 0 for pose in in_zone("", kind="car", heading="against", lane="opposite"))
    assert all(pose.along > 0 for pose in in_zone("", kind="cone", lane="right"))
    assert any(pose.along < 0 for pose in in_zone("", kind="person", lane="right"))


@pytest.mark.parametrize(
    ("place", "length", "later", "start"),
    [
        ("", 40.0, 0.0, -20.0),
        ("", 40.0, 8.0, -12.0),
        ("", 150.0, 8.0, -70.0),
        ("front", 40.0, 0.0, 8.0),
        ("behind", 40.0, 8.0, -16.0),
    ],
)
def test_a_row_is_around_the_ego_and_begins_later_as_far_as_the_road_goes_on(
    place: str, length: float, later: float, start: float
) -> None:
    zone = zone_of(ObjectGroup(kind="tree"), SENTENCE_KINDS["tree"], place, ROAD)
    assert zone.in_row(length, ROAD, later, around=True).span[0] == start


def test_a_row_goes_on_behind_a_crossing_road() -> None:
    trees, cars = ObjectGroup(kind="tree", spacing=10.0), ObjectGroup(kind="car", spacing=10.0)
    assert [along_row(trees, ROAD, 10.0, 10.0, number) for number in range(5)] == [10.0, 20.0, 60.0, 70.0, 80.0]
    assert [along_row(cars, ROAD, 10.0, 10.0, number) for number in range(4)] == [10.0, 20.0, 30.0, 40.0]


def test_who_crosses_at_a_roundabout_does_so_before_it() -> None:
    group = ObjectGroup(kind="person", heading="across")
    span = zone_of(group, group.record, "", Road(junction=40.0, roundabout_radius=20.0)).span
    assert 15.0 < min(span) < max(span) < 20.0


def test_traffic_lights_stand_before_the_junction_and_after_it() -> None:
    off = [pose.along - 40.0 for pose in in_zone("", kind="traffic-light")]
    assert all(ROAD.edge < abs(along) < 20.0 for along in off)
    assert min(off) < 0.0 < max(off)


def on_road(road: Road = ROAD, **fields: object) -> list[RoadPose]:
    group = ObjectGroup(**fields)  # type: ignore[arg-type]
    return sampled(partial(set_down, group, "front", "", (1, -1), road), 0.0)


def test_what_is_in_a_lane_is_near_its_middle_and_barriers_stand_across_it() -> None:
    for kind in ("fence", "bin", "cone", "tree"):
        assert all(abs(pose.across - ROAD.lane(0)) <= 1.2 for pose in on_road(kind=kind, lane="right"))
    assert all(abs(math.sin(pose.yaw)) > 0.99 for pose in on_road(kind="fence", lane="left"))
    assert all(abs(math.cos(pose.yaw)) > 0.99 for pose in on_road(kind="traffic-sign", lane="left"))


def test_the_middle_of_the_road_is_that_of_the_own_carriageway_where_there_are_two() -> None:
    straight, parted = Road(lanes=2), Road(lanes=2, median=4.0)
    assert all(abs(pose.across) <= 0.5 for pose in on_road(straight, kind="pole", surface="road"))
    middle = (straight.lane(0) + straight.lane(1)) / 2 - 2.0
    assert all(abs(pose.across - middle) <= 0.5 for pose in on_road(parted, kind="pole", surface="road"))


def test_who_crosses_keeps_to_the_right_and_comes_from_the_side_that_is_said() -> None:
    def crossing(road: Road, heading: str, *sides: int) -> list[RoadPose]:
        return sampled(partial(on_crossing_road, road, heading, sides))

    assert all((pose.along < 40.0) == (math.sin(pose.yaw) < 0) for pose in crossing(CROSSROADS, "across", 1, -1))
    assert all(pose.across > 0 and math.sin(pose.yaw) < 0 for pose in crossing(CROSSROADS, "across", LEFT))
    wide = Road(lanes=3, junction=40.0)
    assert all(pose.across < wide.lane(wide.ego_lane) for pose in crossing(wide, "across", RIGHT))
    assert all(math.sin(pose.yaw) > 0 for pose in crossing(CROSSROADS, "across-left", 1, -1))


@pytest.mark.parametrize(("heading", "side"), [("turning-left", LEFT), ("turning-right", RIGHT)])
def test_a_turn_leads_from_a_lane_into_one_of_the_crossing_road(heading: str, side: int) -> None:
    for pose in sampled(partial(in_turn, CROSSROADS, heading)):
        way = 1 if abs(math.remainder(pose.yaw - side * math.pi / 4, math.tau)) < math.pi / 2 else -1
        turned = math.remainder(pose.yaw - (0.0 if way > 0 else math.pi), math.tau) * side
        assert 0.0 < turned < math.pi / 2
        assert math.hypot(pose.along - 40.0, pose.across) < 10.0
    to_the_left = Road(junction=40.0, side_roads=(LEFT,))  # which is all that a T-junction has
    assert all(math.sin(pose.yaw) > 0 for pose in sampled(partial(in_turn, to_the_left, heading)))


def test_for_want_of_room_who_turns_has_just_turned() -> None:
    poses = sampled(partial(in_turn, CROSSROADS, "turning-left"), 0.8)
    after = [pose for pose in poses if abs(math.sin(pose.yaw)) > 0.999]
    assert after
    for pose in after:
        assert (pose.along - 40.0) * math.sin(pose.yaw) > 0.0  # on the right of the crossing road
        assert CROSSROADS.edge < abs(pose.across) < CROSSROADS.edge + 40.0


def test_corners_are_on_the_sidewalk_clear_of_the_crossing_road_and_taken_in_turns() -> None:
    for pose in sampled(partial(at_corner, CROSSROADS, (LEFT,))):
        assert CROSSROADS.edge < pose.across < CROSSROADS.verge
        assert CROSSROADS.verge < abs(pose.along - 40.0) < 15.0
    poses = sampled(partial(before_and_after, lambda _: RoadPose(30.0, 5.0, 0.0), 40.0, 2))[:5]
    assert [pose.along for pose in poses] == [30.0, 30.0, 50.0, 50.0, 30.0]
    assert [pose.yaw for pose in poses] == pytest.approx([0.0, 0.0, math.pi, math.pi, 0.0])


def test_cars_stand_in_bays_at_right_angles_to_the_aisle_and_what_is_longer_along_it() -> None:
    rng = np.random.default_rng(0)
    for number in range(60):
        pose = in_bay(SENTENCE_KINDS["car"], LOT, (1, -1), False, Try(rng, -29.0 + number, number, number / 60))
        assert abs(math.sin(pose.yaw)) > 0.99
        assert min(abs(abs(pose.across) - LANE - row) for row in (2.5, 7.5, 18.5)) < 1e-9
        assert abs((pose.along + 30.0) / BAY_WIDTH % 1.0 - 0.5) < 0.05
    assert in_bay(SENTENCE_KINDS["car"], LOT, (1, -1), True, Try(rng, 12.3, 0, 0.0)).along == 12.3
    assert abs(math.sin(in_bay(SENTENCE_KINDS["bus"], LOT, (1,), False, Try(rng, 0.0, 0, 0.0)).yaw)) < 0.1


def test_a_lot_of_one_row_has_no_others() -> None:
    road = Road(lane_width=LANE, sidewalk=0.0, paved_areas=(PavedArea((-30.0, 30.0), (LANE, LANE + LOT_DEPTHS[-1])),))
    assert lot_edge(road, 1) == LANE + BAY_LENGTH
    assert lot_edge(road, -1) == LANE
    assert [across for across, _ in row_poses(road, 1)] == [LANE + 2.5]
    assert len(row_poses(LOT, -1)) == 3


def test_people_walk_in_the_aisles() -> None:
    for pose in sampled(partial(in_aisle, LOT, (1, -1)), 0.5):
        assert abs(pose.across) < LANE or LANE + 10.0 < abs(pose.across) < LANE + 16.0


STRAIGHT = Road()
BUS_AHEAD = Footprint.of("bus_1", SENTENCE_KINDS["bus"], RoadPose(30.0, -1.75, 0.0), 12.0, 2.5)
BUS_COMING = Footprint.of("bus_2", SENTENCE_KINDS["bus"], RoadPose(30.0, 1.75, math.pi), 12.0, 2.5)
HOUSE = Footprint.of("house_1", SENTENCE_KINDS["house"], RoadPose(30.0, 16.0, 0.0), 10.0, 8.0)


def related(kind: str, relation: str, *references: Footprint) -> list[RoadPose]:
    rng, sizes = np.random.default_rng(0), SENTENCE_KINDS[kind].sizes
    assert sizes is not None
    sampler = RelativePoses(STRAIGHT, SENTENCE_KINDS[kind], sizes.largest[:2], None, relation)
    found = [sampler.sample(references, Try(rng, 0.0, 0, effort)) for effort in np.linspace(0.0, 0.9, 30).tolist()]
    return [pose for pose in found if pose is not None]


@pytest.mark.parametrize("bus", [BUS_AHEAD, BUS_COMING], ids=["ahead", "coming"])
def test_behind_a_vehicle_is_at_its_rear(bus: Footprint) -> None:
    found = related("car", "behind", bus)
    assert found
    assert all((pose.along - 30.0) * bus.forwards < -8.0 for pose in found)
    assert all(abs(pose.across - bus.pose.across) < 0.1 for pose in found)
    assert all((pose.along - 30.0) * bus.forwards > 8.0 for pose in related("car", "in-front-of", bus))


def test_behind_a_house_is_away_from_the_road_and_in_front_of_it_towards() -> None:
    assert all(pose.across > 20.0 for pose in related("tree", "behind", HOUSE))
    before = related("bush", "in-front-of", HOUSE)
    assert before
    assert all(STRAIGHT.edge < pose.across < 12.0 for pose in before)
    assert all(abs(pose.across) == pytest.approx(1.75) for pose in related("car", "in-front-of", HOUSE))
