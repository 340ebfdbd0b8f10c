import math
from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lidardraft.drafting.solver import layout as solver
from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.scene import SpecScene
from lidardraft.drafting.solver.scene_spec import (
    HEADINGS,
    PLACES,
    ROADS,
    ObjectGroup,
    RoadSpec,
    SceneSpec,
)
from lidardraft.drafting.text.layout import layout_from_text
from lidardraft.errors import LayoutError
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.scene.check import check, objects
from lidardraft.scene.layout import object_of
from random_spec import random_spec
from spec_checker import broken


def one(kind: str, count: int | str = 1, *places: str, road: str = "straight", **fields: object) -> SceneSpec:
    group = ObjectGroup(kind=kind, count=count, places=places, **fields)  # type: ignore[arg-type]
    return SceneSpec(road=RoadSpec(kind=road), groups=(group,))


@pytest.mark.parametrize("kind", sorted(SENTENCE_KINDS))
@pytest.mark.parametrize("road", ROADS)
def test_every_kind_stands_on_every_road(kind: str, road: str) -> None:
    layout = layout_from_spec(one(kind, "some", road=road), seed=len(kind))
    assert check(layout) == []
    assert objects(layout)


@settings(max_examples=30, deadline=None)
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
        layout = layout_from_spec(SceneSpec(road=RoadSpec(kind=road), groups=groups), seed=seed)
    except LayoutError:
        return  # no room
    assert check(layout) == []


def test_ids_and_instances() -> None:
    layout = layout_from_spec(
        SceneSpec(groups=(ObjectGroup(kind="car", count=3), ObjectGroup(kind="tree", count=2))), seed=0
    )
    assert {object_of(p) for p in layout if p.label == "car"} == {"car_1", "car_2", "car_3"}
    assert sorted(p.instance for p in layout if p.label == "car") == [1, 2, 3]
    assert {p.id for p in layout if p.instance == 0} >= {"tree_1.trunk", "tree_1.crown", "tree_2.trunk", "tree_2.crown"}
    assert (layout["tree_1.trunk"].label, layout["tree_1.crown"].label) == ("trunk", "vegetation")


def test_a_cyclist_is_a_rider_and_a_bicycle() -> None:
    layout = layout_from_spec(one("bicycle", 1, "front"), seed=0)
    assert [(p.label, p.instance) for p in layout if p.instance] == [("bicycle", 1), ("rider", 2)]
    assert [box.label for box in layout.boxes()] == ["bicycle", "rider"]
    parked = layout_from_spec(one("bicycle", 1, "right", heading="parked"), seed=0)
    assert [p.label for p in parked if p.instance] == ["bicycle"]


@pytest.mark.parametrize("seed", range(5))
def test_traffic_keeps_to_the_right(seed: int) -> None:
    layout = layout_from_spec(one("car", 6), seed=seed)
    middle = layout["road"].center[1]
    for box in layout.boxes():
        assert (math.cos(box.yaw) > 0) == (box.center[1] < middle)


def test_absent_kinds_leave_the_mix() -> None:
    group = ObjectGroup(kind="vehicle", count=12)
    layout = layout_from_spec(SceneSpec(groups=(group,), absent=("truck", "bus", "van")), seed=0)
    assert Counter(p.label for p in layout if p.instance) == {"car": 12}
    with pytest.raises(LayoutError, match="every kind of it is absent"):
        layout_from_spec(SceneSpec(groups=(group,), absent=("car", "truck", "bus", "van")), seed=0)


@pytest.mark.parametrize(
    ("kind", "count", "place", "fields", "said"),
    [
        ("bus", 60, "front", {}, r"Only \d+ of 60 buses fit in front; blocked by .*bus_\d"),
        ("bus", 40, "front", {"distance": (0, 10)}, r"Only \d of 40 buses fit in front, 0 to 10 m away; blocked by"),
        ("tree", 1, "left", {"distance": (2, 2)}, "No tree fits on the left, 2 m away; blocked by the road"),
        ("tree", "some", "left", {"distance": (2, 2)}, "No tree fits on the left, 2 m away; blocked by the road"),
        ("tree", 10, "left", {"spacing": 30.0}, "None of 10 trees fits on the left, every 30 m; blocked by the end of"),
    ],
)
def test_no_room_is_said(kind: str, count: int | str, place: str, fields: dict[str, Any], said: str) -> None:
    with pytest.raises(LayoutError, match=rf"^{said}.*; ask for fewer or for another place$"):
        layout_from_spec(one(kind, count, place, **fields), seed=0)


def test_too_far() -> None:
    with pytest.raises(LayoutError, match="car: distance is 300 m; it must be 200 m or less"):
        layout_from_spec(one("car", 1, "front", distance=(300, 300)), seed=0)
    far = layout_from_spec(one("car", 1, "front", distance=(105, 105)), seed=0)
    assert far.boxes()[0].center[0] == pytest.approx(105)


@pytest.mark.parametrize("seed", [-1, 1.5, True])
def test_wrong_seed(seed: object) -> None:
    with pytest.raises(LayoutError, match=r"seed is .*; it must be an integer of 0 to 2"):
        layout_from_spec(SceneSpec(), seed=seed)  # type: ignore[arg-type]


@pytest.mark.parametrize("tenth", [0, *(pytest.param(tenth, marks=pytest.mark.slow) for tenth in range(1, 10))])
def test_every_relation_of_a_random_spec_holds(tenth: int) -> None:
    refused = 0
    for number in range(100 * tenth, 100 * tenth + 100):
        spec = random_spec(np.random.default_rng([7, number]))
        try:
            layout = layout_from_spec(spec, seed=number)
        except LayoutError:
            refused += 1
            continue
        assert broken(spec, layout) == [], (number, spec)
        assert check(layout) == [], (number, spec)
    assert refused <= 20  # trucks to the right of the only lane, and the like


@pytest.mark.parametrize(
    ("kind", "distance"), [("truck", 8.0), ("bus", 8.0), ("tram", 10.0), ("car", 3.0), ("car", 1.0)]
)
def test_what_is_close_finds_room_for_every_seed(kind: str, distance: float) -> None:
    for seed in range(12):
        layout = layout_from_spec(one(kind, 1, "front", distance=(distance, distance)), seed=seed)
        assert check(layout) == []
        (box,) = layout.boxes()
        near_end = box.center[0] - box.size[0] / 2
        assert near_end - 2.25 - 1.0 <= distance <= box.center[0] + 0.01


def test_other_roads() -> None:
    roundabout = layout_from_spec(one("car", 3, road="roundabout", at_junction=True), seed=0)
    middle = roundabout["roundabout"].center
    assert all(8.0 < math.dist(box.center[:2], middle[:2]) < 36.0 for box in roundabout.boxes())
    lot = layout_from_spec(one("car", 100, road="parking-lot"), seed=0)
    assert sum(abs(math.sin(box.yaw)) > 0.9 for box in lot.boxes()) == 100
    cars = ObjectGroup(kind="car", count=6)
    one_way = layout_from_spec(SceneSpec(road=RoadSpec(one_way=True), groups=(cars,)), seed=0)
    assert all(math.cos(box.yaw) > 0.9 for box in one_way.boxes())


def test_who_drives_through_the_ring_of_a_roundabout_drives_around() -> None:
    for seed in range(10):
        layout = layout_from_spec(one("car", 20, road="roundabout"), seed=seed)
        middle = layout["roundabout"].center
        for box in layout.boxes():
            x, y = box.center[0] - middle[0], box.center[1] - middle[1]
            if math.hypot(x, y) < 12.0:
                assert x * math.sin(box.yaw) - y * math.cos(box.yaw) > 0.9 * math.hypot(x, y)


def test_an_impossible_crowd_is_refused_early(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = 0
    place = SpecScene.place

    def counted(*arguments: Any, by_end: bool) -> Any:
        nonlocal tried
        tried += 1
        return place(*arguments, by_end=by_end)

    monkeypatch.setattr(SpecScene, "place", counted)
    with pytest.raises(LayoutError, match=r"^At most \d+ of 5000 people fit on the left, on the sidewalk; "):
        layout_from_spec(one("person", 5000, "left", surface="sidewalk"), seed=0)
    assert tried < 40_000  # a third of what all arrangements take


def test_a_crowd_that_the_last_arrangement_does_not_hold_is_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    arrangements = 0
    arrange = solver._Solver.arrange

    def counted(self: solver._Solver, urgent: dict[int, int]) -> int | None:
        nonlocal arrangements
        arrangements += 1
        return arrange(self, urgent)

    monkeypatch.setattr(solver._Solver, "arrange", counted)
    with pytest.raises(LayoutError, match=r"^(Only|At most) \d+ of 150 buses fit; blocked by bus_"):
        layout_from_spec(one("bus", 150), seed=0)
    assert arrangements == 2  # all nine of them take seven seconds


@pytest.mark.parametrize("seed", range(8))
def test_what_is_at_a_distance_leaves_room_for_what_is_behind_it(seed: int) -> None:
    car = ObjectGroup(kind="car", places=("front",), distance=(12.0, 12.0))
    spec = SceneSpec(groups=(car, ObjectGroup(kind="truck", relation="behind", references=(0,))))
    assert broken(spec, layout_from_spec(spec, seed=seed)) == []


@pytest.mark.parametrize("seed", range(4))
def test_the_first_of_several_is_at_the_distance(seed: int) -> None:
    layout = layout_from_spec(one("car", 3, "front", distance=(25.0, 25.0)), seed=seed)
    assert math.isclose(min(box.center[0] for box in layout.boxes()), 25.0, abs_tol=2.5)


@pytest.mark.parametrize("seed", range(8))
def test_a_relation_keeps_heading_and_lane(seed: int) -> None:
    truck = ObjectGroup(kind="truck", lane="right", places=("front",), distance=(30.0, 30.0))
    coach = ObjectGroup(kind="bus", lane="middle", heading="with", relation="left-of", references=(0,))
    child = ObjectGroup(kind="person", heading="across-left", relation="in-front-of", references=(0,))
    spec = SceneSpec(road=RoadSpec(kind="motorway", lanes=3), groups=(truck, coach, child))
    assert broken(spec, layout_from_spec(spec, seed=seed)) == []


@pytest.mark.parametrize("seed", range(4))
def test_the_near_end_of_what_has_no_room_at_its_middle_is_at_the_distance(seed: int) -> None:
    (tram,) = [one for one in layout_from_text("a tram 5 m ahead", seed=seed) if one.id == "tram_1"]
    assert tram.center[0] - tram.size[0] / 2 == pytest.approx(5.0, abs=0.1)


def test_cones_that_begin_at_a_place_ahead_are_one_row() -> None:
    cones = [one for one in layout_from_text("14 cones ahead every 1.5 m") if one.id.startswith("cone")]
    assert {one.center[1] > 0 for one in cones} == {False}
