"""Poses where roads meet."""

import math

import numpy as np
import pytest

from lidardraft.drafting.solver.junction_poses import at_corner, before_and_after, in_turn, on_crossing_road, on_ring
from lidardraft.drafting.solver.road_pose import PoseSampler, RoadPose
from lidardraft.scene.road import LEFT, RIGHT, Road

ROAD = Road(junction=40.0)
ROUNDABOUT = Road(junction=40.0, roundabout_radius=20.0)


def sampled(sample_pose: PoseSampler, effort: float = 0.2) -> list[RoadPose]:
    rng = np.random.default_rng(0)
    return [sample_pose(rng, 40.0, number, effort) for number in range(40)]


def test_who_crosses_keeps_to_the_right_and_comes_from_the_side_that_is_said() -> None:
    for pose in sampled(on_crossing_road(ROAD, "across", (1, -1))):
        assert (pose.along < 40.0) == (math.sin(pose.yaw) < 0)
    from_left = sampled(on_crossing_road(ROAD, "across", (LEFT,)))
    assert all(pose.across > 0 and math.sin(pose.yaw) < 0 for pose in from_left)
    wide = Road(lanes=3, junction=40.0)
    assert all(pose.across < wide.lane(wide.ego_lane) for pose in sampled(on_crossing_road(wide, "across", (RIGHT,))))
    assert all(math.sin(pose.yaw) > 0 for pose in sampled(on_crossing_road(ROAD, "across-left", (1, -1))))


@pytest.mark.parametrize(("heading", "side"), [("turning-left", LEFT), ("turning-right", RIGHT)])
def test_a_turn_leads_from_a_lane_into_one_of_the_crossing_road(heading: str, side: int) -> None:
    for pose in sampled(in_turn(ROAD, heading)):
        way = 1 if abs(math.remainder(pose.yaw - side * math.pi / 4, math.tau)) < math.pi / 2 else -1
        turned = math.remainder(pose.yaw - (0.0 if way > 0 else math.pi), math.tau) * side
        assert 0.0 < turned < math.pi / 2
        assert math.hypot(pose.along - 40.0, pose.across) < 10.0


def test_for_want_of_room_who_turns_has_just_turned() -> None:
    after = [pose for pose in sampled(in_turn(ROAD, "turning-left"), 0.8) if abs(math.sin(pose.yaw)) > 0.999]
    assert after
    for pose in after:
        assert (pose.along - 40.0) * math.sin(pose.yaw) > 0.0  # on the right of the crossing road
        assert ROAD.edge < abs(pose.across) < ROAD.edge + 40.0


def test_corners_are_taken_in_turns() -> None:
    sample = before_and_after(lambda *_: RoadPose(30.0, 5.0, 0.0), 40.0, 2)
    poses = [sample(np.random.default_rng(0), 30.0, number, 0.0) for number in range(5)]
    assert [pose.along for pose in poses] == [30.0, 30.0, 50.0, 50.0, 30.0]
    assert [pose.yaw for pose in poses] == pytest.approx([0.0, 0.0, math.pi, math.pi, 0.0])


def test_a_t_junction_is_left_by_its_side_road() -> None:
    to_the_left = Road(junction=40.0, side_roads=(LEFT,))
    assert all(math.sin(pose.yaw) > 0 for pose in sampled(in_turn(to_the_left, "turning-right")))


def test_the_ring_is_driven_counter_clockwise() -> None:
    for pose in sampled(on_ring(ROUNDABOUT)):
        x, y = pose.along - 40.0, pose.across
        assert math.hypot(x, y) == pytest.approx(16.0)
        assert x * math.sin(pose.yaw) - y * math.cos(pose.yaw) > 15.0


def test_a_corner_is_on_the_sidewalk_clear_of_the_crossing_road() -> None:
    for pose in sampled(at_corner(ROAD, (LEFT,))):
        assert ROAD.edge < pose.across < ROAD.verge
        assert ROAD.verge < abs(pose.along - 40.0) < 15.0
