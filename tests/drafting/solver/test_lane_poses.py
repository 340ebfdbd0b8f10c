"""Poses on the road."""

import math

import numpy as np
import pytest

from lidardraft.drafting.solver.lane_poses import set_down
from lidardraft.drafting.solver.road_pose import RoadPose
from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.scene.road import Road

ROAD = Road(lanes=2)


def poses(road: Road = ROAD, **fields: object) -> list[RoadPose]:
    group = ObjectGroup(**fields)  # type: ignore[arg-type]
    sample = set_down(group, group.record, "front", "", (1, -1), road)
    rng = np.random.default_rng(0)
    return [sample(rng, 20.0, number, 0.0) for number in range(50)]


@pytest.mark.parametrize("kind", ["fence", "bin", "cone", "tree"])
def test_what_is_in_a_lane_is_near_its_middle(kind: str) -> None:
    assert all(abs(pose.across - ROAD.lane(0)) <= 1.2 for pose in poses(kind=kind, lane="right"))


def test_a_barrier_in_a_lane_stands_across_it() -> None:
    assert all(abs(math.sin(pose.yaw)) > 0.99 for pose in poses(kind="fence", lane="left"))
    assert all(abs(math.cos(pose.yaw)) > 0.99 for pose in poses(kind="traffic-sign", lane="left"))


def test_the_middle_of_the_road_is_that_of_the_own_carriageway_where_there_are_two() -> None:
    assert all(abs(pose.across) <= 0.5 for pose in poses(kind="pole", surface="road"))
    middle = (ROAD.lane(0) + ROAD.lane(1)) / 2 - 2.0
    parted = poses(Road(lanes=2, median=4.0), kind="pole", surface="road")
    assert all(abs(pose.across - middle) <= 0.5 for pose in parted)
