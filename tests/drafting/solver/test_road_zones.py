import math

import numpy as np
import pytest

from lidardraft.drafting.solver.road_zones import RoadPose, along_row, zone_of
from lidardraft.drafting.solver.scene_spec import PLACES, ObjectGroup
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.scene.road import Road

ROAD = Road(lanes=2, parking=2.2, sidewalk=2.0, junction=40.0)


def poses(place: str, **fields: object) -> list[RoadPose]:
    """Poses over the whole zone of a group at a place, of the first objects and later ones."""
    group = ObjectGroup(**fields)  # type: ignore[arg-type]
    zone = zone_of(group, group.record, place, ROAD)
    rng = np.random.default_rng(0)
    return [
        zone.sample_pose(rng, along, number, effort)
        for along in np.linspace(*zone.span, 5).tolist()
        for number in range(3)
        for effort in (0.0, 0.9)
    ]


@pytest.mark.parametrize("kind", [kind for kind in SENTENCE_KINDS if kind != "vehicle"])
@pytest.mark.parametrize("place", PLACES)
def test_zones_are_where_their_place_says(kind: str, place: str) -> None:
    found = poses(place, kind=kind)
    if "front" in place:
        assert all(pose.along > 0 for pose in found)
    if "behind" in place:
        assert all(pose.along < 0 for pose in found)
    if not SENTENCE_KINDS[kind].drives:
        ego = ROAD.lane(ROAD.ego_lane)
        assert "left" not in place or all(pose.across > ego for pose in found)
        assert "right" not in place or all(pose.across < ego for pose in found)


@pytest.mark.parametrize("kind", [name for name, kind in SENTENCE_KINDS.items() if not kind.on_road])
def test_what_stands_beside_the_road_is_off_it(kind: str) -> None:
    assert all(abs(pose.across) > ROAD.edge for pose in poses("", kind=kind))


def test_what_drives_keeps_to_its_lane_and_direction() -> None:
    for pose in poses("", kind="car"):
        lanes = [ROAD.lane(number, direction) for number in range(2) for direction in (1, -1)]
        assert min(abs(pose.across - lane) for lane in lanes) <= 0.15
        assert (math.cos(pose.yaw) > 0) == (pose.across < 0)
    assert all(abs(pose.across) == pytest.approx(ROAD.edge - 1.1) for pose in poses("", kind="car", heading="parked"))


def test_what_is_oncoming_is_ahead() -> None:
    assert all(pose.along > 0 for pose in poses("", kind="car", heading="against"))
    assert any(pose.along < 0 for pose in poses("", kind="car", heading="against", lane="opposite"))


def test_what_stands_in_the_way_is_ahead() -> None:
    assert all(pose.along > 0 for pose in poses("", kind="cone", lane="right"))
    assert any(pose.along < 0 for pose in poses("", kind="person", lane="right"))


def test_a_row_is_around_the_ego_and_begins_later_as_far_as_the_road_goes_on() -> None:
    zone = zone_of(ObjectGroup(kind="tree"), SENTENCE_KINDS["tree"], "", ROAD)
    assert zone.in_row(40.0, ROAD, 0.0, around=True).span[0] == -20.0
    assert zone.in_row(40.0, ROAD, 8.0, around=True).span[0] == -12.0
    assert zone.in_row(150.0, ROAD, 8.0, around=True).span[0] == -70.0
    ahead = zone_of(ObjectGroup(kind="tree"), SENTENCE_KINDS["tree"], "front", ROAD)
    assert ahead.in_row(40.0, ROAD, 0.0, around=True) == ahead
    behind = zone_of(ObjectGroup(kind="tree"), SENTENCE_KINDS["tree"], "behind", ROAD)
    assert behind.in_row(40.0, ROAD, 8.0, around=True).span[0] == -16.0


def test_a_row_goes_on_behind_a_crossing_road() -> None:
    trees = ObjectGroup(kind="tree", spacing=10.0)
    along = [along_row(trees, ROAD, 10.0, 10.0, number) for number in range(5)]
    assert along == [10.0, 20.0, 60.0, 70.0, 80.0]
    cars = ObjectGroup(kind="car", spacing=10.0)
    assert [along_row(cars, ROAD, 10.0, 10.0, number) for number in range(4)] == [10.0, 20.0, 30.0, 40.0]


def test_who_crosses_at_a_roundabout_does_so_before_it() -> None:
    ring = Road(junction=40.0, roundabout_radius=20.0)
    group = ObjectGroup(kind="person", heading="across")
    near, far = zone_of(group, group.record, "", ring).span
    assert max(near, far) < 20.0
    assert min(near, far) > 15.0


def test_cyclists_keep_to_the_right_of_their_lane() -> None:
    assert min(pose.across for pose in poses("front", kind="bicycle")) < ROAD.lane(0) - 0.9


def test_traffic_lights_stand_before_the_junction_and_after_it() -> None:
    assert ROAD.junction is not None
    off = [pose.along - ROAD.junction for pose in poses("", kind="traffic-light")]
    assert all(ROAD.edge < abs(along) < 20.0 for along in off)
    assert min(off) < 0.0 < max(off)
