"""Where something may be from something else."""

import math

import numpy as np
import pytest

from lidardraft.drafting.solver.relative_poses import Footprint, RelativePoses
from lidardraft.drafting.solver.road_pose import RoadPose
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.scene.road import Road

ROAD = Road()
BUS_AHEAD = Footprint.of("bus_1", SENTENCE_KINDS["bus"], RoadPose(30.0, -1.75, 0.0), 12.0, 2.5)
BUS_COMING = Footprint.of("bus_2", SENTENCE_KINDS["bus"], RoadPose(30.0, 1.75, math.pi), 12.0, 2.5)
HOUSE = Footprint.of("house_1", SENTENCE_KINDS["house"], RoadPose(30.0, 16.0, 0.0), 10.0, 8.0)


def poses(kind: str, relation: str, *references: Footprint) -> list[RoadPose]:
    rng = np.random.default_rng(0)
    sizes = SENTENCE_KINDS[kind].sizes
    assert sizes is not None
    sampler = RelativePoses(ROAD, SENTENCE_KINDS[kind], sizes.largest[:2], None, relation)
    found = [sampler.sample(references, rng, 0, effort) for effort in np.linspace(0.0, 0.9, 30).tolist()]
    return [pose for pose in found if pose is not None]


@pytest.mark.parametrize("bus", [BUS_AHEAD, BUS_COMING], ids=["ahead", "coming"])
def test_behind_a_vehicle_is_at_its_rear(bus: Footprint) -> None:
    found = poses("car", "behind", bus)
    assert found
    assert all((pose.along - 30.0) * bus.forwards < -8.0 for pose in found)
    assert all(abs(pose.across - bus.pose.across) < 0.1 for pose in found)
    assert all((pose.along - 30.0) * bus.forwards > 8.0 for pose in poses("car", "in-front-of", bus))


def test_behind_a_house_is_away_from_the_road_and_in_front_of_it_towards() -> None:
    assert all(pose.across > 20.0 for pose in poses("tree", "behind", HOUSE))
    before = poses("bush", "in-front-of", HOUSE)
    assert before
    assert all(ROAD.edge < pose.across < 12.0 for pose in before)
    assert all(abs(pose.across) == pytest.approx(1.75) for pose in poses("car", "in-front-of", HOUSE))


def test_sides_are_those_of_the_ego() -> None:
    assert all(pose.across > -1.0 for pose in poses("car", "left-of", BUS_AHEAD))
    assert poses("car", "right-of", BUS_AHEAD) == []  # there is no lane
    assert all(pose.across < -2.0 for pose in poses("person", "right-of", BUS_AHEAD))
    assert all(pose.across < -ROAD.edge for pose in poses("tree", "opposite", HOUSE))


def test_between_is_on_the_way_from_one_to_the_other() -> None:
    other = Footprint.of("house_2", SENTENCE_KINDS["house"], RoadPose(60.0, 18.0, 0.0), 10.0, 8.0)
    found = poses("tree", "between", HOUSE, other)
    assert found
    assert all(35.0 < pose.along < 55.0 and 15.0 < pose.across < 19.0 for pose in found)
