import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lidardraft.drafting.scene_spec import HEADINGS, PLACES, ROADS, ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.solver import layout_from_spec
from lidardraft.errors import LayoutError
from lidardraft.scene.check import check, objects
from lidardraft.scene.layout import Layout, object_of


def one(kind: str, count: int | str = 1, *places: str, road: str = "straight", **fields: object) -> SceneSpec:
    group = ObjectGroup(kind=kind, count=count, places=places, **fields)  # type: ignore[arg-type]
    return SceneSpec(road=RoadSpec(kind=road), groups=(group,))


@pytest.mark.parametrize("kind", sorted(SENTENCE_KINDS))
@pytest.mark.parametrize("road", ROADS)
def test_every_kind_stands_on_every_road(kind: str, road: str) -> None:
    for seed in range(3):
        layout = layout_from_spec(one(kind, "some", road=road), seed)
        assert check(layout) == []
        assert objects(layout)


@settings(max_examples=60, deadline=None)
@given(
    road=st.sampled_from(ROADS),
    kinds=st.lists(st.sampled_from(sorted(SENTENCE_KINDS)), min_size=1, max_size=5),
    place=st.sampled_from(("", *PLACES)),
    heading=st.none() | st.sampled_from(HEADINGS),
    on_sidewalk=st.booleans(),
    seed=st.integers(0, 10**6),
)
@example(road="bend", kinds=["tram"], place="", heading="across", on_sidewalk=False, seed=11502)
def test_what_is_arranged_passes_every_check(
    road: str, kinds: list[str], place: str, heading: str | None, on_sidewalk: bool, seed: int
) -> None:
    places = (place,) if place else ()
    groups = tuple(
        ObjectGroup(
            kind=kind,
            count="some",
            places=places,
            heading=heading,
            surface="sidewalk" if on_sidewalk and "sidewalk" in SENTENCE_KINDS[kind].surfaces else None,
        )
        for kind in kinds
    )
    try:
        layout = layout_from_spec(SceneSpec(road=RoadSpec(kind=road), groups=groups), seed)
    except LayoutError:
        return  # no room
    assert check(layout) == []


def test_ids_and_instances() -> None:
    layout = layout_from_spec(
        SceneSpec(groups=(ObjectGroup(kind="car", count=3), ObjectGroup(kind="tree", count=2))), 0
    )
    assert {object_of(p) for p in layout if p.label == "car"} == {"car_1", "car_2", "car_3"}
    assert sorted(p.instance for p in layout if p.label == "car") == [1, 2, 3]
    assert {p.id for p in layout if p.instance == 0} >= {"tree_1.trunk", "tree_1.crown", "tree_2.trunk", "tree_2.crown"}
    assert (layout["tree_1.trunk"].label, layout["tree_1.crown"].label) == ("trunk", "vegetation")


def test_a_cyclist_is_a_rider_and_a_bicycle() -> None:
    layout = layout_from_spec(one("bicycle", 1, "front"), 0)
    assert [(p.label, p.instance) for p in layout if p.instance] == [("bicycle", 1), ("rider", 2)]
    assert [box.label for box in layout.boxes()] == ["bicycle", "rider"]
    parked = layout_from_spec(one("bicycle", 1, "right", heading="parked"), 0)
    assert [p.label for p in parked if p.instance] == ["bicycle"]


@pytest.mark.parametrize("seed", range(5))
def test_traffic_keeps_to_the_right(seed: int) -> None:
    layout = layout_from_spec(one("car", 6), seed)
    middle = layout["road"].center[1]
    for box in layout.boxes():
        assert (math.cos(box.yaw) > 0) == (box.center[1] < middle)


def test_headings() -> None:
    oncoming = layout_from_spec(one("car", 2, heading="against"), 0)
    assert all(math.cos(box.yaw) < -0.99 for box in oncoming.boxes())
    crossing = layout_from_spec(one("truck", 1, heading="across"), 0)
    assert all(abs(math.sin(box.yaw)) > 0.99 for box in crossing.boxes())
    assert {"road_left", "road_right"} <= {p.id for p in crossing}


def test_parked_cars_stand_between_lane_and_kerb() -> None:
    layout = layout_from_spec(one("car", 4, "left", "right", heading="parked"), 2)
    road = layout["road"]
    for box in layout.boxes():
        from_kerb = road.size[1] / 2 - abs(box.center[1] - road.center[1])
        assert 0.8 < from_kerb < 1.4


def test_distance_and_spacing() -> None:
    box = layout_from_spec(one("car", 1, "front", distance=(20, 20)), 4).boxes()[0]
    assert box.center[0] == pytest.approx(20)
    ahead = layout_from_spec(one("truck", 1, "behind", distance=(30, 40)), 4).boxes()[0]
    assert -40 <= ahead.center[0] <= -30
    house = layout_from_spec(one("house", 1, "left", distance=(25, 25)), 4)["house_1"]
    assert house.center[1] == pytest.approx(25)
    trees = layout_from_spec(one("tree", 5, "left", spacing=9), 0)
    along = sorted(p.center[0] for p in trees if p.label == "trunk")
    np.testing.assert_allclose(np.diff(along), 9)


def test_on_the_right_of_a_wide_road_is_a_lane() -> None:
    layout = layout_from_spec(one("truck", 2, "right", road="motorway"), 0)
    assert all(box.center[1] < -3 and math.cos(box.yaw) > 0 for box in layout.boxes())


def test_absent_kinds_leave_the_mix() -> None:
    group = ObjectGroup(kind="vehicle", count=12)
    layout = layout_from_spec(SceneSpec(groups=(group,), absent=("truck", "bus", "van")), 0)
    assert Counter(p.label for p in layout if p.instance) == {"car": 12}
    with pytest.raises(LayoutError, match="every kind of it is absent"):
        layout_from_spec(SceneSpec(groups=(group,), absent=("car", "truck", "bus", "van")), 0)


@pytest.mark.parametrize("radius_kind", ["left-bend", "right-bend"])
def test_strips_follow_the_bend(radius_kind: str) -> None:
    layout = layout_from_spec(one("wall", 1, "left", road=radius_kind), 1)
    parts = [p for p in layout if p.label == "wall"]
    assert len(parts) > 1
    yaws = np.diff([p.yaw for p in parts])
    assert (yaws > 0).all() or (yaws < 0).all()


def test_no_room_is_said() -> None:
    with pytest.raises(LayoutError, match=r"bus at place 'front': \d+ of 60 found room"):
        layout_from_spec(one("bus", 60, "front"), 0)
    with pytest.raises(LayoutError, match="car at place 'front': 0 of 1 found room"):
        layout_from_spec(one("car", 1, "front", distance=(1, 1)), 0)
    with pytest.raises(LayoutError, match="tree at place 'left': 0 of 'some' found room"):
        layout_from_spec(one("tree", "some", "left", distance=(2, 2)), 0)


def test_too_far() -> None:
    with pytest.raises(LayoutError, match="distance is 300 m; objects can be asked for up to 110 m away"):
        layout_from_spec(one("car", 1, "front", distance=(300, 300)), 0)
    assert layout_from_spec(one("car", 1, "front", distance=(105, 105)), 0).boxes()[0].center[0] == pytest.approx(105)


@pytest.mark.parametrize("seed", [-1, 1.5, True])
def test_wrong_seed(seed: object) -> None:
    with pytest.raises(LayoutError, match=r"seed is .*; it must be an integer >= 0"):
        layout_from_spec(SceneSpec(), seed)  # type: ignore[arg-type]


def test_provenance_is_json() -> None:
    layout = layout_from_spec(one("car", 2, "front"), 5)
    assert Layout.from_json(layout.to_json()) == layout
    assert layout.provenance["seed"] == 5


@pytest.mark.parametrize("kind", [kind for kind in sorted(SENTENCE_KINDS) if kind != "vehicle"])
def test_things_stand_on_the_ground_and_differ(kind: str) -> None:
    first, second = (
        SENTENCE_KINDS[kind].sample_parts(np.random.default_rng(0)),
        SENTENCE_KINDS[kind].sample_parts(np.random.default_rng(1)),
    )
    assert min(part.center[2] - part.size[2] / 2 for part in first) == pytest.approx(0)
    assert first != second


def test_spacing_that_leaves_the_road_is_refused() -> None:
    with pytest.raises(LayoutError, match="of 10 found room"):
        layout_from_spec(one("tree", 10, "left", spacing=(30.0)), 0)
