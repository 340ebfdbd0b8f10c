"""Streets around layouts, by an independent checker: what was asked for is untouched, in sight, and counted right."""

import itertools
import math
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft import (
    Box,
    Layout,
    Primitive,
    Sensor,
    detail,
    layout_from_boxes,
    layout_from_sketch,
    layout_from_text,
    raycast,
    simulate,
    surround,
)  # fmt: skip
from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.scene_spec import ACTIVITIES, DISTRICTS, PLACES, ROADS, ObjectGroup, RoadSpec, SceneSpec
from lidardraft.errors import LayoutError, LidarDraftError
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.scene import edit
from lidardraft.scene.check import check, objects
from lidardraft.semantics import BY_NAME, GROUND
from random_spec import random_spec
from spec_checker import broken

ROOT = Path(__file__).parents[2]
SENTENCES = [
    line
    for line in (ROOT / "tests/drafting/text/sentences.txt").read_text(encoding="utf-8").splitlines()
    if not line.startswith("    ")
]
SENSOR = Sensor(name="fine", elevations=tuple(np.deg2rad(np.linspace(3, -20, 40)).tolist()), columns=720)
THINGS = {name for name, row in BY_NAME.items() if row.is_thing}


def corners(primitive: Primitive) -> np.ndarray:
    """Corners [4, 2] of the upright box around a shape."""
    cos, sin = math.cos(primitive.yaw), math.sin(primitive.yaw)
    half = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * primitive.size[:2] / 2
    return half @ np.array([[cos, sin], [-sin, cos]]) + primitive.center[:2]


def overlap(one: Primitive, two: Primitive) -> bool:
    """Whether the upright boxes around two shapes share more than a centimetre, by projecting all corners."""
    z, w = (p.center[2] for p in (one, two))
    if abs(z - w) >= (one.size[2] + two.size[2]) / 2 - 0.01:
        return False
    a, b = corners(one), corners(two)
    for edge in np.concatenate([np.diff(a, axis=0), np.diff(b, axis=0)]):
        normal = np.array([-edge[1], edge[0]]) / max(np.hypot(*edge), 1e-9)
        if min((a @ normal).max(), (b @ normal).max()) - max((a @ normal).min(), (b @ normal).min()) < 0.01:
            return False
    return True


def faults(bare: Layout, whole: Layout) -> list[str]:
    """What the street around a layout does to it that it must not, seen from the two layouts alone."""
    wrong = []
    if whole.primitives[: len(bare)] != bare.primitives:
        wrong.append("what was given has changed")
    around = whole.primitives[len(bare) :]
    if not all(p.id.startswith("around/") for p in around):
        wrong.append("an id does not begin with around/")
    solid = [p for p in around if p.label not in GROUND]
    asked = [p for p in bare if p.label not in GROUND]
    ego = Primitive(shape="box", center=(0, 0, 1), size=(4.5, 2, 2), label="car", id="ego")
    for given_one, added in itertools.product([*asked, ego], solid):
        near = math.dist(given_one.center[:2], added.center[:2])
        if near < math.hypot(*given_one.size[:2]) / 2 + math.hypot(*added.size[:2]) / 2 and overlap(given_one, added):
            wrong.append(f"{added.id} touches {given_one.id}")
    numbers = [{(p.instance, p.id.partition(".")[0]) for p in part if p.instance} for part in (asked, solid)]
    if {number for number, _ in numbers[0]} & {number for number, _ in numbers[1]}:
        wrong.append("an instance is shared")
    before = {finding.message for finding in check(bare)}
    for finding in check(whole):
        # on slopes buildings stand in the ground, and crowns and bushes may meet
        on_slope = finding.check == "overlap" or "is sunk" in finding.message
        if finding.message not in before and not (on_slope and all(id.startswith("around/") for id in finding.ids)):
            wrong.append(finding.message)
    return wrong + miscounted(bare, solid) + hidden(bare, whole)


def miscounted(bare: Layout, added: list[Primitive]) -> list[str]:
    """What was added of kinds that the sentence counts or denies."""
    spec = SceneSpec.from_dict(bare.provenance.get("spec", {}))
    said = {group.kind for group in spec.groups if not isinstance(group.count, str) or group.count == "few"}
    said |= set(spec.absent) | set(spec.not_around)
    wrong = []
    for kind in said:
        labels = {SENTENCE_KINDS[kind].label} if kind != "vehicle" else {"car", "truck", "bus", "train", "motorcycle"}
        names = {name: (name,) for name in ("tree", "bush", "hedge", "cone", "bin", "bench", "pole")}
        names |= {"street-light": ("lamp",), "garden": ()}
        names |= {name: (name,) for name, row in SENTENCE_KINDS.items() if row.label == "other"}
        for p in added:
            word = p.id.removeprefix("around/").partition(".")[0].rpartition("_")[0]
            if word in names[kind] if kind in names else p.label in labels:
                wrong.append(f"{p.id}, though {kind} is counted")
    return wrong


def hidden(bare: Layout, whole: Layout) -> list[str]:
    """Objects that lose more than a tenth of their returns to what was added."""
    wrong = []
    before, after = (raycast(each, SENSOR, primitive=True) for each in (bare, whole))
    index = {p.id: number for number, p in enumerate(bare)}
    for name, parts in objects(bare).items():
        if not bare.intent.of(name).counted and parts[0].label not in THINGS:
            continue  # more of them may well stand in front
        if any(note.startswith(f"{name} cannot be seen") for note in whole.notes):
            continue
        seen = [np.isin(image.primitive, [index[p.id] for p in parts]).sum() for image in (before, after)]
        width = np.ptp(np.concatenate([corners(p) for p in parts]), axis=0).max()
        if seen[0] >= 20 and width < 4.5 and seen[1] < 0.9 * seen[0]:
            wrong.append(f"{name}: {seen[1]} of {seen[0]} returns")
        if seen[0] >= 20 and seen[1] < 0.1 * seen[0]:
            wrong.append(f"{name}: only {seen[1]} of {seen[0]} returns")
    return wrong


def check_sentences(sentences: list[str]) -> None:
    wrong, notes = {}, 0
    for seed, sentence in enumerate(sentences):
        try:
            bare = layout_from_text(sentence, seed=seed)
        except LidarDraftError:
            continue
        whole = surround(bare, seed=seed)
        notes += any("no street around it" in note for note in whole.notes)
        if found := faults(bare, whole):
            wrong[sentence] = found[:3]
    assert not wrong
    assert notes == 0


def test_sentences_of_the_corpus_keep_what_they_ask_for() -> None:
    check_sentences(SENTENCES[::96])


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_all_sentences_of_the_corpus_keep_what_they_ask_for() -> None:
    check_sentences(SENTENCES)


@settings(max_examples=10, deadline=None)
@given(
    road=st.sampled_from(ROADS),
    kinds=st.lists(st.sampled_from(sorted(SENTENCE_KINDS)), min_size=1, max_size=4),
    counts=st.lists(st.sampled_from((1, 2, 3, (2, 4), "few", "some", "many")), min_size=4, max_size=4),
    places=st.lists(st.sampled_from(("", *PLACES)), min_size=4, max_size=4),
    absent=st.lists(st.sampled_from(sorted(SENTENCE_KINDS)), max_size=2),
    district=st.none() | st.sampled_from(DISTRICTS),
    activity=st.none() | st.sampled_from(ACTIVITIES),
    seed=st.integers(0, 10**6),
)
def test_any_spec_keeps_what_it_asks_for(road, kinds, counts, places, absent, district, activity, seed) -> None:
    groups = tuple(
        ObjectGroup(kind=kind, count=count, places=(place,) if place else ())
        for kind, count, place in zip(kinds, counts, places, strict=False)
    )
    spec = SceneSpec(
        road=RoadSpec(kind=road),
        groups=groups,
        absent=tuple(set(absent) - set(kinds)),
        district=district,
        activity=activity,
    )
    try:
        bare = layout_from_spec(spec, seed=seed)
    except LayoutError:
        return  # no room
    whole = surround(bare, seed=seed)
    assert broken(spec, edit.remove(whole, "around/*")) == []
    assert faults(bare, whole) == []


# Side roads of a bend, and what is seen beside other things that were asked for.
@pytest.mark.parametrize(
    "numbers",
    [
        (*range(8), 228, 417, 684),
        *(pytest.param(range(n, n + 100), marks=pytest.mark.slow) for n in range(0, 1000, 100)),
    ],
)
def test_random_specs_keep_what_they_ask_for(numbers: Iterable[int]) -> None:
    for number in numbers:
        spec = random_spec(np.random.default_rng([7, number]))
        try:
            bare = layout_from_spec(spec, seed=number)
        except LayoutError:
            continue
        whole = surround(bare, seed=number)
        assert broken(spec, edit.remove(whole, "around/*")) == [], number
        assert faults(bare, whole) == [], number


def test_it_is_said_what_cannot_be_seen_for_something_else_that_was_asked_for() -> None:
    for sentence, hidden in (
        ("a truck 8 m ahead, a motorcycle in front of it", ("motorcycle_1 cannot be seen: truck_1 stands before it",)),
        ("a truck 8 m ahead, a motorcycle behind it", ()),
    ):
        whole = surround(layout_from_text(sentence, seed=1), seed=1)
        assert (whole.provenance["surroundings"]["in_sight"], whole.notes) == (1.0, hidden)


@pytest.mark.parametrize("kind", ["garden", "bench", "hedge"])
def test_what_lies_along_the_road_is_not_fenced_off(kind: str) -> None:
    spec = SceneSpec(groups=(ObjectGroup(kind=kind, places=("left",)),))
    for seed in range(4):
        bare = layout_from_spec(spec, seed=seed)
        assert faults(bare, surround(bare, seed=seed)) == []


def test_the_street_is_a_function_of_layout_and_seed_and_goes_in_one_line() -> None:
    bare = layout_from_text("two cars ahead", seed=1)
    whole = surround(bare, seed=4)
    assert whole == surround(bare, seed=4)
    assert whole != surround(bare, seed=5)
    assert edit.remove(whole, "around/*").primitives == bare.primitives
    assert Layout.from_json(whole.to_json()) == whole
    said = whole.provenance["surroundings"]
    assert said["objects"] == len({p.id.partition(".")[0] for p in whole if p.id.startswith("around/")} - GROUNDS)
    assert 0.9 <= said["in_sight"] <= 1.0


GROUNDS = {f"around/{name}" for name in ("land", "yards", "drives", "sidewalks", "road")}


@pytest.mark.parametrize(("sentence", "green"), [("a street in a town", 0.1), ("a busy street downtown", 0.04)])
def test_a_street_has_what_recordings_have(sentence: str, green: float) -> None:
    shares = np.zeros(len(BY_NAME))
    for seed in range(6):
        whole = surround(layout_from_text(sentence, seed=seed), seed=seed)
        label = simulate(whole, SENSOR, seed=seed).labels()
        shares += np.bincount(label, minlength=len(BY_NAME)) / len(label) / 6
    at = {name: shares[row.id] for name, row in BY_NAME.items()}
    assert green < at["vegetation"] < 0.45
    assert 0.05 < at["building"] < 0.4
    assert at["pole"] + at["traffic-sign"] > 0.002
    assert at["trunk"] > 0.002
    assert at["car"] > 0.005


def test_an_object_looks_the_same_after_every_edit() -> None:
    whole = surround(layout_from_text("a bus ahead", seed=2), seed=2)
    names = sorted({p.id.partition(".")[0] for p in whole if p.id.startswith("around/") and p.label not in GROUND})
    edited = edit.move(edit.remove(whole, names[0]), names[-1], by=(0.0, 0.5, 0.0))
    before, after = (objects(detail(each, seed=2)) for each in (whole, edited))
    assert len(before) > 30
    assert names[0] not in after
    assert all(after[name] == before[name] for name in before if name not in (names[0], names[-1]))
    assert [p.size for p in after[names[-1]]] == [p.size for p in before[names[-1]]]
    built = sum(len(parts) for name, parts in before.items() if name.startswith("around/"))
    assert built > 2 * len(names), "no richer than its coarse shapes"


@pytest.mark.parametrize(
    ("sentence", "district"),
    [
        ("a narrow alley between tall buildings", "alley"),
        ("a quiet residential street", "residential"),
        ("a motorway with two trucks ahead", "motorway"),
        ("an industrial estate with a van", "industrial"),
        ("a forest road", "forest"),
        ("a busy downtown intersection", "urban"),
        ("a shopping street with many people", "urban"),
        ("a shopping centre", "retail"),
        ("roadworks with cones on the right", "roadworks"),
    ],
)
def test_words_choose_the_district(sentence: str, district: str) -> None:
    assert surround(layout_from_text(sentence)).intent.around == district


def test_words_move_traffic_and_people() -> None:
    def vehicles(sentence: str) -> float:
        layouts = [surround(layout_from_text(sentence, seed=seed), seed=seed) for seed in range(8)]
        moving = THINGS - {"bicycle"}  # parked ones are no traffic
        return float(np.mean([sum(p.label in moving for p in layout) for layout in layouts]))

    empty, quiet, usual = (vehicles(f"{how} city street with no pedestrians") for how in ("an empty", "a quiet", "a"))
    assert empty == 0.0
    assert quiet < 0.8 * usual  # whose parked cars stand on quiet streets too


@pytest.mark.parametrize("sentence", ["an alley", "an alley between tall buildings"])
def test_an_alley_has_closed_fronts_at_its_narrow_road(sentence: str) -> None:
    for seed in range(3):
        whole = surround(layout_from_text(sentence, seed=seed), seed=seed)
        walls = [p for p in whole if p.label == "building"]
        front = sum(p.size[0] for p in walls if abs(p.center[1]) - p.size[1] / 2 < 6.0)
        assert front > 0.55 * 2 * 160.0
        assert not any(p.label == "sidewalk" and p.id.startswith(("sidewalk", "around/sidewalk")) for p in whole)


@pytest.mark.parametrize("sentence", ["a forest road", "a motorway"])
def test_where_nobody_lives_there_are_no_bins_bicycles_and_sidewalks(sentence: str) -> None:
    for seed in range(4):
        whole = surround(layout_from_text(sentence, seed=seed), seed=seed)
        names = {primitive.id.partition("_")[0].removeprefix("around/") for primitive in whole}
        assert not names & {"bicycle", "bin", "letterbox", "sidewalk"}


def test_what_is_as_large_as_a_county_takes_no_longer() -> None:
    county = Box(id="hall", label="building", instance=0, center=(5e7, 0, 3), size=(9e7, 9e7, 6), yaw=0.0)
    start = time.process_time()
    assert len(surround(layout_from_boxes([county]))) > 60
    assert time.process_time() - start < 5.0


def test_boxes_get_a_road_that_their_vehicles_drive_on() -> None:
    cars = [(14.0, 0.0, 0.0), (30.0, 3.6, math.pi), (22.0, -3.3, 0.0), (-18.0, 3.4, math.pi)]
    boxes = [
        Box(id=f"car_{n}", label="car", instance=n + 1, center=(x, y, 0.8), size=(4.2, 1.8, 1.6), yaw=yaw)
        for n, (x, y, yaw) in enumerate(cars)
    ]
    bare = layout_from_boxes(boxes)
    whole = surround(bare, seed=3)
    assert faults(bare, whole) == []
    assert not any(p.label == "car" for p in whole.primitives[len(bare) :])
    assert len(whole) > 60


@pytest.mark.parametrize(("name", "options"), [("bend.svg", {}), ("crossroads.png", {"scale_bar": 10.0})])
def test_a_sketch_gets_a_street_along_its_road(name: str, options: dict[str, float]) -> None:
    bare = layout_from_sketch(ROOT / "examples/sketches" / name, seed=0, **options)
    for seed in range(3):
        whole = surround(bare, seed=seed)
        assert faults(bare, whole) == []
        assert len(whole) > len(bare) + 30


def test_around_a_picture_nothing_stands_in_it() -> None:
    view = (-0.6, 0.6)
    plane = Primitive(shape="plane", center=(0, 0, -0.3), size=(300, 300, 0), label="terrain", id="ground", open=True)
    car = Primitive(shape="box", center=(15, 1, 0.8), size=(4.2, 1.8, 1.6), label="car", id="car_1", instance=1)
    whole = surround(Layout((plane, car), {"source": "picture.png"}, view), seed=1)
    added = whole.primitives[2:]
    assert len(added) > 50
    for primitive in added:
        if primitive.label not in GROUND:
            turns = np.arctan2(corners(primitive)[:, 1], corners(primitive)[:, 0])
            assert not ((turns > view[0]) & (turns < view[1])).any(), primitive.id
    seen = raycast(whole, SENSOR).label[np.abs(SENSOR.azimuths) < 0.59]
    assert set(np.unique(seen)) <= {0, BY_NAME["terrain"].id, BY_NAME["car"].id}


@pytest.mark.parametrize(
    ("layout", "note"),
    [
        (Layout(), "it has no road under the ego vehicle"),
        (
            Layout((Primitive(shape="plane", center=(0, 30, 0), size=(90, 7, 0), label="road", id="road"),)),
            "it has no road under the ego vehicle",
        ),
        (Layout((), {}, (-math.pi, math.pi)), "it shows everything around already"),
    ],
)
def test_where_there_is_no_room_the_layout_stays_bare_and_says_why(layout: Layout, note: str) -> None:
    whole = surround(layout)
    assert whole.primitives == layout.primitives
    assert [note in line for line in whole.notes] == [True]
    assert surround(whole) == whole  # the note is there already


def test_what_cannot_be_surrounded_is_refused() -> None:
    layout = layout_from_text("a car ahead")
    with pytest.raises(LayoutError, match="seed is -1; it must be an integer of 0 to 2"):
        surround(layout, seed=-1)
    with pytest.raises(LayoutError, match="the layout has surroundings already"):
        surround(surround(layout))
