"""The road of a spec, in which order its groups are placed, what has room on it, and when a crowd is given up."""

import math

import numpy as np
import pytest

from lidardraft.drafting.solver.layout import (
    Crowd,
    layout_from_spec,
    long_strips,
    placing_order,
    row_of,
    with_gap,
    with_references,
    with_sides,
)
from lidardraft.drafting.solver.poses import RoadPose
from lidardraft.drafting.solver.road_from_spec import road_from_spec
from lidardraft.drafting.solver.scene import SpecScene
from lidardraft.drafting.solver.scene_spec import EGO_LANES, ObjectGroup, RoadSpec, SceneSpec
from lidardraft.errors import LayoutError
from lidardraft.scene.check import check
from lidardraft.scene.road import LEFT, RIGHT, Road
from spec_checker import broken

CARS, BUS = ObjectGroup(kind="car", count=3), ObjectGroup(kind="bus", places=("front",))
BEHIND = ObjectGroup(kind="van", relation="behind", references=(1,))
BETWEEN = ObjectGroup(kind="bicycle", relation="between", references=(0,))


def road(kind: str = "straight", *groups: ObjectGroup, seed: int = 0, **fields: object) -> Road:
    spec = SceneSpec(road=RoadSpec(kind=kind, **fields), groups=groups)  # type: ignore[arg-type]
    return road_from_spec(spec, np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(5))
def test_kinds_of_road(seed: int) -> None:
    assert road("straight", seed=seed).curvature == 0
    assert road("left-bend", seed=seed).curvature > 0 > road("right-bend", seed=seed).curvature
    assert road("crossroads", seed=seed).side_roads == (LEFT, RIGHT)
    assert len(road("t-junction", seed=seed).side_roads) == 1
    motorway = road("motorway", seed=seed)
    assert (motorway.sidewalk, motorway.junction, motorway.parking, motorway.median) == (0.0, None, 3.0, 4.0)
    assert road("motorway", ObjectGroup(kind="car", heading="across"), seed=seed).median == 0.0
    assert (road(lanes=3, sidewalk=False).lanes, road(lanes=3, sidewalk=False).sidewalk) == (3, 0)
    assert road("motorway", sidewalk=True).sidewalk > 0


@pytest.mark.parametrize("seed", range(5))
def test_the_ego_drives_in_the_lane_that_is_said(seed: int) -> None:
    three = {name: road(lanes=3, seed=seed, ego_lane=name).ego_lane for name in EGO_LANES}
    assert three == {"left": 2, "middle": 1, "right": 0}
    assert road(seed=seed, ego_lane="left").lanes >= 2
    assert road(seed=seed, ego_lane="middle").lanes >= 3
    overtaken = ObjectGroup(kind="car", places=("right",), heading="with")
    assert road("straight", overtaken, seed=seed, ego_lane="left").ego_lane > 0


def test_a_parking_lot_has_no_sidewalk() -> None:
    assert road("parking-lot", ObjectGroup(kind="person"), sidewalk=False).sidewalk == 0.0
    walker = ObjectGroup(kind="person", surface="sidewalk")
    bench = ObjectGroup(kind="bench", from_sidewalk=(2.0, 3.0))
    for groups, sidewalk in (((), True), ((walker,), None), ((bench,), None)):
        with pytest.raises(LayoutError, match=r"^road: a parking lot has no sidewalk"):
            road("parking-lot", *groups, sidewalk=sidewalk)


def test_a_median_lies_between_two_directions() -> None:
    tree = ObjectGroup(kind="tree", count=3, surface="median")
    assert road("straight", tree).median == road("straight", median=True).median == 4.0
    assert road("straight").median == 0.0
    for fields, has in (
        ({"one_way": True}, "is one-way"),
        ({"lanes": 3, "oncoming_lanes": 2}, "has 3 .* and 2 oncoming"),
    ):
        with pytest.raises(
            LayoutError, match=rf"^road: it {has}; a median is between two directions with as many lanes"
        ):
            road("straight", tree, **fields)
    with pytest.raises(LayoutError, match=r"^road: it is a parking lot; a median is between two directions"):
        road("parking-lot", median=True)


@pytest.mark.parametrize("kind", ["straight", "left-bend", "crossroads", "roundabout", "motorway"])
def test_things_and_people_stand_in_a_median(kind: str) -> None:
    kinds = {"tree": 4, "person": 2, "barrier": 1, "street-light": "some", "tram": 1}
    groups = tuple(ObjectGroup(kind=name, count=count, surface="median") for name, count in kinds.items())
    spec = SceneSpec(road=RoadSpec(kind=kind), groups=groups)
    for seed in range(3):
        layout = layout_from_spec(spec, seed=seed)
        assert broken(spec, layout) == check(layout) == []


def test_the_ego_keeps_to_the_left_for_what_is_far_to_the_right() -> None:
    for heading, distance, lanes in ((None, 7.0, 2), ("parked", 5.0, 1), ("parked", 3.0, 0)):
        car = ObjectGroup(kind="car", places=("beside-right",), distance=(distance, distance), heading=heading)
        assert road("straight", car).ego_lane == lanes
        spec = SceneSpec(groups=(car,))
        assert broken(spec, layout_from_spec(spec, seed=0)) == []


def test_motorcycles_stand_and_bicycles_ride_on_sidewalks() -> None:
    parked = ObjectGroup(kind="motorcycle", count=2, surface="sidewalk", heading="parked")
    coming = ObjectGroup(kind="bicycle", surface="sidewalk", heading="against")
    spec = SceneSpec(road=RoadSpec(sidewalk=True), groups=(parked, coming))
    for seed in range(5):
        layout = layout_from_spec(spec, seed=seed)
        assert broken(spec, layout) == check(layout) == []


def test_there_is_room_for_what_is_asked_for() -> None:
    parked = {kind: road("straight", ObjectGroup(kind=kind, heading="parked")) for kind in ("car", "truck", "person")}
    assert [parked[kind].parking for kind in ("car", "truck", "person")] == [2.2, 3.0, 0.0]
    assert road("straight", ObjectGroup(kind="car", heading="across")).junction is not None
    assert road("straight", ObjectGroup(kind="car", distance=(90.0, 90.0))).half_length == 105
    assert road("straight", ObjectGroup(kind="bus", count=4)).half_length > 90
    for seed in range(12):
        narrow = road("straight", ObjectGroup(kind="tree", places=("left",), distance=(10.0, 10.0)), seed=seed)
        assert narrow.edge - narrow.lane(narrow.ego_lane) < 9.0


def test_a_parking_lot_ends_before_a_house_that_is_nearer() -> None:
    house, tree = (ObjectGroup(kind=kind, places=("left",), distance=(20.0, 20.0)) for kind in ("house", "tree"))
    assert [area.across for area in road("parking-lot", house).paved_areas] == [(-24.0, -3.0), (3.0, 13.0)]
    assert [area.across for area in road("parking-lot", tree).paved_areas] == [(-24.0, -3.0), (3.0, 24.0)]


def test_references_come_before_what_is_placed_from_them_and_those_before_the_rest() -> None:
    spec = SceneSpec(groups=(CARS, BUS, BEHIND))
    assert placing_order(spec, {}) == [1, 2, 0]
    assert placing_order(spec, {0: 0}) == [0, 1, 2]
    assert with_references(spec, 2) == {1, 2}
    spec = SceneSpec(groups=(CARS, BUS, ObjectGroup(kind="person")))  # what found no room last is first
    assert placing_order(spec, {0: 0, 2: 1}) == [2, 0, 1]
    assert placing_order(spec, {0: 1, 2: 0}) == [0, 2, 1]


def test_what_is_between_two_is_placed_as_a_row() -> None:
    spec = SceneSpec(groups=(ObjectGroup(kind="truck", count=2), BETWEEN))
    assert row_of(spec, 0) == (0, 1, 0)
    assert row_of(SceneSpec(groups=(CARS, BUS)), 0) is None


def test_a_side_follows_from_what_is_to_the_left() -> None:
    sign = ObjectGroup(kind="traffic-sign")
    for kind, side in (("bench", "left"), ("car", "right")):
        other = ObjectGroup(kind=kind, relation="left-of", references=(0,))
        assert with_sides((sign, other))[0].places == (side,)


@pytest.mark.parametrize(
    ("strip", "shortest", "longest"),
    [
        (ObjectGroup(kind="fence", count=10), 3.0, 9.0),
        (ObjectGroup(kind="fence", count=2), None, None),
        (ObjectGroup(kind="wall", lane="left"), 2.0, 2.0),
        (ObjectGroup(kind="wall", lane="left", size=(6.0, None, None)), 6.0, 6.0),
    ],
)
def test_many_strips_and_those_in_a_lane_are_shorter(
    strip: ObjectGroup, shortest: float | None, longest: float | None
) -> None:
    ((length, *_),) = [group.size or (None,) for group in long_strips((strip,))]
    assert length is None if shortest is None or longest is None else shortest <= (length or 0.0) <= longest


@pytest.mark.parametrize(("spacing", "step"), [(1.5, 6.0), (4.0, 8.5), (4.2, 4.2), (9.0, 9.0)])
def test_a_spacing_that_is_shorter_than_the_objects_is_between_their_ends(spacing: float, step: float) -> None:
    row = with_gap(ObjectGroup(kind="car", count=4, spacing=spacing))
    assert row.spacing == pytest.approx(step, abs=0.5)
    assert (row.size is None) == (spacing == step)


def test_crowns_leave_room_for_each_other() -> None:
    row = with_gap(ObjectGroup(kind="tree", count=4, spacing=2.0))
    assert row.spacing == 2.0
    assert row.size is not None
    assert (row.size[0] or 9.0) < 2.0


def occupancy(**fields: object) -> SpecScene:
    return SpecScene(Road(**fields), np.random.default_rng(0))  # type: ignore[arg-type]


def test_what_finds_no_room_says_what_is_in_the_way() -> None:
    scene, car, tree = occupancy(), ObjectGroup(kind="car"), ObjectGroup(kind="tree")
    assert scene.place(car.record, car, RoadPose(20.0, -1.75, 0.0)) is not None
    for group, pose in ((car, (21.0, -1.75)), (car, (1.0, -1.75)), (car, (30.0, -9.0)), (tree, (30.0, -1.0))):
        assert scene.place(group.record, group, RoadPose(*pose, 0.0)) is None
    assert set(scene.in_the_way) == {"car_1", "the ego vehicle", "the kerb", "the road"}
    right = ObjectGroup(kind="car", not_places=("left",))
    assert scene.place(right.record, right, RoadPose(30.0, 1.75, 0.0)) is None
    assert scene.place(right.record, right, RoadPose(30.0, -1.75, 0.0)) is not None


def test_nothing_stands_in_the_way_of_a_roundabout_but_those_who_drive_around() -> None:
    scene = occupancy(junction=40.0, roundabout_radius=20.0)
    car, person = ObjectGroup(kind="car"), ObjectGroup(kind="person")
    assert scene.place(car.record, car, RoadPose(40.0, 10.0, 0.0)) is None
    assert scene.place(person.record, person, RoadPose(30.0, 4.5, 0.0)) is None
    assert scene.place(car.record, car, RoadPose(40.0, 16.0, 0.0)) is None  # the wrong way round
    assert scene.place(car.record, car, RoadPose(40.0, 16.0, math.pi)) is not None


def test_objects_have_the_sizes_that_are_asked_for() -> None:
    scene = occupancy()
    wall = ObjectGroup(kind="wall", size=(None, None, 4.0))
    scene.place(wall.record, wall, RoadPose(30.0, 8.0, 0.0))
    assert scene.primitives[-1].size[2] == pytest.approx(4.0)
    large = ObjectGroup(kind="car", scale=(9.0, 9.0, 9.0))  # as large as a car can be
    assert scene.place(large.record, large, RoadPose(30.0, -1.75, 0.0)) is not None
    assert scene.primitives[-1].size == pytest.approx((6.5, 2.4, 3.0), rel=1e-5)
    long = ObjectGroup(kind="car", size=(30.0, None, None))
    with pytest.raises(LayoutError, match=r"car: length is 30 m; a car has 2\.4 to 6\.5 m"):
        scene.place(long.record, long, RoadPose(60.0, -1.75, 0.0))


@pytest.mark.parametrize("kind", ["house", "tree", "wall", "person", "car"])
@pytest.mark.parametrize("said", ["from_road", "from_sidewalk"])
def test_the_near_side_is_at_the_distance(kind: str, said: str) -> None:
    fields = {"from_road": (0.3, 0.3), "heading": "parked"} if kind == "car" else {"count": 2, said: (4.0, 4.0)}
    spec = SceneSpec(road=RoadSpec(sidewalk=True), groups=(ObjectGroup(kind=kind, **fields),))  # type: ignore[arg-type]
    layout = layout_from_spec(spec, seed=0)
    assert broken(spec, layout) == []
    assert check(layout) == []


def packed(width: float, height: float, size: tuple[float, float], seed: int) -> tuple[int, list[float]]:
    """Rectangles of a size placed at random until 20,000 tries are over: how many, and the bounds on the way."""
    rng, crowd = np.random.default_rng(seed), Crowd()
    placed, bounds = np.zeros((0, 2)), []
    for _ in range(20_000):
        at = rng.uniform((0, 0), (width - size[0], height - size[1]))
        found = not (np.abs(placed - at) < size).all(axis=1).any()
        crowd.add(found=found)
        if found:
            placed = np.vstack([placed, at])
        bounds.append(crowd.most(len(placed)))
    return len(placed), bounds


@pytest.mark.parametrize(("width", "height", "size"), [(30, 30, (1, 1)), (200, 1.001, (1, 1)), (120, 3, (0.6, 0.8))])
def test_a_crowd_that_has_room_is_never_given_up(width: float, height: float, size: tuple[float, float]) -> None:
    number, bounds = packed(width, height, size, 1)
    assert min(bounds) >= number
    assert bounds[0] == math.inf
    assert bounds[-1] <= 1.6 * number
