import contextlib
import re
from collections import Counter

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lidardraft.drafting.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.sentence_reader import KIND_OF
from lidardraft.drafting.text import grammar, layout_from_text, spec_from_text
from lidardraft.errors import LayoutError, TextError
from lidardraft.scene.check import check, objects
from lidardraft.scene.layout import Layout

PAPER = (
    "a vehicle driving on a road with vehicles both in front and behind, "
    "with trees and houses along both sides of the road"
)
SIDES = ("left", "right")


def group(kind: str, count: int | str = "some", *places: str, **fields: object) -> ObjectGroup:
    return ObjectGroup(kind=kind, count=count, places=places, **fields)  # type: ignore[arg-type]


# Sentence, road, groups: understood to the last word.
UNDERSTOOD: list[tuple[str, RoadSpec, list[ObjectGroup]]] = [
    (
        PAPER,
        RoadSpec(),
        [group("vehicle", "some", "front", "behind"), group("tree", "some", *SIDES), group("house", "some", *SIDES)],
    ),
    ("a car ahead", RoadSpec(), [group("car", 1, "front")]),
    (
        "two parked cars on the left and a bus behind",
        RoadSpec(),
        [group("car", 2, "left", heading="parked"), group("bus", 1, "behind")],
    ),
    (
        "a busy crossroads with pedestrians crossing",
        RoadSpec(kind="crossroads"),
        [group("person", heading="across"), group("vehicle")],
    ),
    (
        "a quiet residential street with houses, gardens, trees and parked cars on both sides",
        RoadSpec(),
        [
            *(group(kind, "some", *SIDES) for kind in ("house", "garden", "tree")),
            group("car", "some", *SIDES, heading="parked"),
        ],
    ),
    ("a t-intersection with three cars in front", RoadSpec(kind="t-junction"), [group("car", 3, "front")]),
    (
        "a motorway with three lanes and trucks on the right",
        RoadSpec(kind="motorway", lanes=3),
        [group("truck", "some", "right")],
    ),
    (
        "four people on the right sidewalk, a cyclist 20 m ahead",
        RoadSpec(sidewalk=True),
        [group("person", 4, "right", surface="sidewalk"), group("bicycle", 1, "front", distance=(20, 20))],
    ),
    ("heavy traffic", RoadSpec(), [group("vehicle", "many")]),
    ("an empty road", RoadSpec(), []),
    ("no traffic", RoadSpec(), []),
    (
        "a row of trees on the left, a wall on the right",
        RoadSpec(),
        [group("tree", "many", "left"), group("wall", 1, "right")],
    ),
    ("12 cars", RoadSpec(), [group("car", 12)]),
    ("a dozen automobiles and twenty-five people", RoadSpec(), [group("car", 12), group("person", 25)]),
    ("a car is driving behind me", RoadSpec(), [group("car", 1, "behind", heading="with")]),
    ("a car is driving on the road behind us", RoadSpec(), [group("car", 1, "behind", heading="with")]),
    (
        "On the left, two parked vans; on the right a hedge and a fence.",
        RoadSpec(),
        [group("van", 2, "left", heading="parked"), group("hedge", 1, "right"), group("fence", 1, "right")],
    ),
    (
        "trees every 10 metres along both sides of the road",
        RoadSpec(),
        [group("tree", "some", *SIDES, spacing=10)],
    ),
    (
        "lamp posts on both sides, a traffic light at the crossroads",
        RoadSpec(kind="crossroads"),
        [group("street-light", "some", *SIDES), group("traffic-light", 1)],
    ),
    (
        "a lorry 10 to 30 metres behind and a motorbike beside us",
        RoadSpec(),
        [group("truck", 1, "behind", distance=(10, 30)), group("motorcycle", 1, "beside")],
    ),
    ("residential street without trees, no parked cars", RoadSpec(), [group("house", "some", *SIDES)]),
    ("a residential street with no houses", RoadSpec(), []),
    ("houses on both sides, no houses on the right", RoadSpec(), [group("house", "some", "left")]),
    ("a man riding a bike on the left", RoadSpec(), [group("bicycle", 1, "left")]),
    (
        "we are driving on a highway with oncoming traffic",
        RoadSpec(kind="motorway"),
        [group("vehicle", heading="against")],
    ),
    (
        "a left-hand bend with bushes and traffic signs",
        RoadSpec(kind="left-bend"),
        [group("bush"), group("traffic-sign")],
    ),
    (
        "In front of us there is a bus, and behind us are three kids.",
        RoadSpec(),
        [group("bus", 1, "front"), group("person", 3, "behind")],
    ),
    ("cars in front, behind and on the left", RoadSpec(), [group("car", "some", "front", "behind", "left")]),
    (
        "a tree-lined city street with pedestrians walking along the road",
        RoadSpec(),
        [group("person"), group("building", "some", *SIDES), group("tree", "many", *SIDES)],
    ),
    ("children playing on the street", RoadSpec(), [group("person", surface="road")]),
    (
        "a car 20 m ahead and a car 30 m behind",
        RoadSpec(),
        [group("car", 1, "front", distance=(20, 20)), group("car", 1, "behind", distance=(30, 30))],
    ),
    (
        "a country road that curves to the right with a few trees, no houses or fences",
        RoadSpec(kind="right-bend", sidewalk=False),
        [group("tree", "few")],
    ),
    (
        "the ego vehicle on a four-lane road with cars parked along the road",
        RoadSpec(lanes=2),
        [group("car", "some", heading="parked")],
    ),
    (
        "bins and benches on the pavement, a couple of pedestrians nearby",
        RoadSpec(sidewalk=True),
        [group("bin", surface="sidewalk"), group("bench", surface="sidewalk"), group("person", 2, distance=(8, 18))],
    ),
    ("a taxi ahead on the left", RoadSpec(), [group("car", 1, "front-left")]),
]


@pytest.mark.parametrize(("sentence", "road", "groups"), UNDERSTOOD, ids=[row[0] for row in UNDERSTOOD])
def test_sentence_is_understood_to_the_last_word(sentence: str, road: RoadSpec, groups: list[ObjectGroup]) -> None:
    spec = spec_from_text(sentence, strict=True)
    assert spec.road == road
    assert list(spec.groups) == groups
    assert spec.not_understood == ()


@pytest.mark.parametrize(
    ("sentence", "left", "kinds"),
    [
        ("a bus stop on the right and a car ahead", ("bus stop", "the right"), ["car"]),
        ("a red car in front and a big green truck behind", ("red", "green"), ["car", "truck"]),
        ("a car behind the llamas", ("behind", "llamas"), ["car"]),
        ("a car inside the house", ("inside",), ["car", "house"]),
        ("a car flurb ahead", ("flurb",), ["car"]),
        ("people meander ahead", ("meander",), ["person"]),
        ("two cars on the left, a llama 12 m ahead", ("llama 12 m ahead",), ["car"]),
        ("trees swaying gently and a car", ("swaying gently",), ["tree", "car"]),
        ("2.5 cars ahead", ("2.5",), ["car"]),
        ("a car parked on the sidewalk", ("sidewalk",), ["car"]),
        ("an empty road in heavy rain", ("heavy rain",), []),
        ("heavy trucks ahead", ("heavy",), ["truck"]),
        ("a busy bus behind a truck", ("busy",), ["bus", "truck"]),
    ],
)
def test_what_is_not_understood_is_returned(sentence: str, left: tuple[str, ...], kinds: list[str]) -> None:
    spec = spec_from_text(sentence)
    assert spec.not_understood == left
    assert [found.kind for found in spec.groups] == kinds
    assert layout_from_text(sentence).provenance["not_understood"] == list(left)


def test_strict_refuses_what_is_left() -> None:
    with pytest.raises(TextError, match="not understood: 'red'"):
        layout_from_text("a red car ahead", strict=True)


@pytest.mark.parametrize("kind", SENTENCE_KINDS)
def test_the_name_of_a_kind_is_a_word_for_it(kind: str) -> None:
    assert spec_from_text(f"one {kind}", strict=True).groups == (group(kind, 1),)


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_every_word_for_a_kind_means_it(data: st.DataObject) -> None:
    terminal = data.draw(st.sampled_from(sorted(KIND_OF)))
    word = data.draw(st.from_regex(grammar().get_terminal(terminal).pattern.to_regexp(), fullmatch=True))
    (found,) = spec_from_text(f"some {word}", strict=True).groups  # two yards are a distance
    assert (found.kind, found.count, found.places) == (KIND_OF[terminal], "some", ())


@pytest.mark.parametrize("sentence", ["", "   ", "\n"])
def test_empty_sentence(sentence: str) -> None:
    with pytest.raises(TextError, match="the sentence is empty"):
        layout_from_text(sentence)


@pytest.mark.parametrize("sentence", ["I want pizza", "xyzzy", "???", "3", "Zwei Hunde"])
def test_nothing_understood(sentence: str) -> None:
    with pytest.raises(TextError, match=r"nothing of .* was understood"):
        layout_from_text(sentence)


def test_a_refusal_names_what_is_unknown_and_what_is_near_to_it() -> None:
    with pytest.raises(TextError, match=r"nothing of 'a bus stop' was understood \(unknown as a whole: 'bus stop'\)"):
        spec_from_text("a bus stop")
    with pytest.raises(TextError, match=r"'trcuk ahead' \(nearest words: 'truck' for 'trcuk'\)"):
        spec_from_text("a trcuk ahead")
    layout = layout_from_text("a trcuk ahead, a car behind, a giraffe")
    assert layout.provenance["nearest_words"] == {"trcuk": "truck"}
    assert set(objects(layout)) == {"car_1"}


def test_an_ellipsis_ends_a_sentence() -> None:
    spec = spec_from_text("a bus\u2026 a car\u20262 trees\u2026", strict=True)
    assert spec == spec_from_text("a bus. a car. 2 trees.")


def test_too_many_lanes_and_objects() -> None:
    with pytest.raises(LayoutError, match="lanes is 20; a road has 1 to 6"):
        spec_from_text("a motorway with 20 lanes")
    with pytest.raises(LayoutError, match="car: count is 9000; it must be 1 to 5000"):
        spec_from_text("9000 cars")


@pytest.mark.parametrize("sentence", [row[0] for row in UNDERSTOOD])
def test_layouts_pass_every_check_and_survive_json(sentence: str) -> None:
    for seed in range(20):
        layout = layout_from_text(sentence, seed=seed)
        assert check(layout) == []
    assert Layout.from_json(layout.to_json()) == layout
    assert layout.provenance["sentence"] == sentence
    assert SceneSpec.from_dict(layout.provenance["spec"]) == spec_from_text(sentence)


def test_nothing_is_invented() -> None:
    assert objects(layout_from_text("an empty road")) == {}
    names = objects(layout_from_text("trees on the left"))
    assert all(name.startswith("tree_") for name in names)
    assert min(part.center[1] for parts in names.values() for part in parts) > 0


def test_paper_sentence() -> None:
    layout = layout_from_text(PAPER, seed=0)
    vehicles = layout.boxes()
    assert any(box.center[0] > 5 for box in vehicles)
    assert any(box.center[0] < -5 for box in vehicles)
    for label in ("building", "trunk", "vegetation"):
        sides = {part.center[1] > 0 for part in layout if part.label == label}
        assert sides == {True, False}


def test_seed_decides() -> None:
    assert layout_from_text(PAPER, seed=3) == layout_from_text(PAPER, seed=3)
    first, second = layout_from_text(PAPER, seed=0), layout_from_text(PAPER, seed=1)
    assert [p.center for p in first] != [p.center for p in second]


PLACES = {"ahead": (1, 0), "behind us": (-1, 0), "on the left": (0, 1), "on the right": (0, -1)}


@settings(max_examples=40, deadline=None)
@given(
    kind=st.sampled_from(["car", "truck", "person", "tree", "house", "hedge", "pole", "bicycle"]),
    count=st.integers(1, 4),
    place=st.sampled_from(sorted(PLACES)),
    seed=st.integers(0, 2**31),
)
def test_counts_and_relations_hold(kind: str, count: int, place: str, seed: int) -> None:
    layout = layout_from_text(f"{count} {kind} {place}", seed=seed, strict=True)
    found = objects(layout)
    assert len(found) == count
    forward, left = PLACES[place]
    for parts in found.values():
        x, y, _ = parts[0].center
        assert x * forward > 0 or not forward
        assert y * left > 0 or not left


WORDS = """
a|the|two|no|some|cars|car|tree|houses|behind|left|right sides|both|and|,|.|with|front|of|in|us|driving|parked|road
crossing|lanes|20|m|every|on|traffic|red|busy|sidewalk|bend|motorway|without|or|10|to|apart|next to|along|many|a row of
dozen|people|riding|bikes|each direction|near|between
"""
WORDS = WORDS.strip().replace("\n", "|").split("|")
# without denials: where a thing is not is in no spec
NO_PLAIN_WORDS = ("dozen", "each direction", "two", "no", "without")
PLAIN_WORDS = [word for word in WORDS if not word.isdigit() and word not in NO_PLAIN_WORDS]
NUMBERS = {15: "15", 13: "thirteen", 27: "27", 31: "thirty-one", 45: "45", 101: "hundred and one", 150: "150"}
STRANGE = ["tent", "android", "fourteenth", "Xylophones", "4x4", "naïve", "--", "andante", "ones"]


@settings(max_examples=150, deadline=None)
@given(st.lists(st.sampled_from(WORDS), min_size=1, max_size=14))
def test_any_run_of_words_is_read_or_refused(words: list[str]) -> None:
    try:
        spec = spec_from_text(" ".join(words))
    except (TextError, LayoutError):
        return
    assert SceneSpec.from_json(spec.to_json()) == spec


@settings(max_examples=300, deadline=None)
@given(st.lists(st.sampled_from(WORDS) | st.sampled_from(STRANGE), min_size=1, max_size=12))
def test_words_that_are_not_in_the_vocabulary_are_reported(words: list[str]) -> None:
    try:
        spec = spec_from_text(" ".join(words))
    except (TextError, LayoutError):
        return
    reported = Counter(" ".join(spec.not_understood).split())
    assert not Counter(word.lower() for word in words if word in STRANGE) - reported


@settings(max_examples=500, deadline=None)
@given(
    st.lists(st.sampled_from(PLAIN_WORDS), max_size=5),
    st.lists(
        st.tuples(st.sampled_from(sorted(NUMBERS)), st.lists(st.sampled_from(PLAIN_WORDS), min_size=1, max_size=4)),
        max_size=3,
    ),
)
def test_numbers_are_used_or_reported(words: list[str], numbers: list[tuple[int, list[str]]]) -> None:
    """A number in figures or words counts objects or lanes, is a length, or is among what was not understood."""
    parts = [*words, *(word for value, after in numbers for word in (NUMBERS[value], *after))]
    try:
        spec = spec_from_text(" ".join(parts))
    except (TextError, LayoutError):
        return
    lengths = [length for group in spec.groups for length in (*(group.distance or ()), group.spacing)]
    lengths += [length for group in spec.groups for length in group.size or ()]
    counts = [n for group in spec.groups for n in (group.count if isinstance(group.count, tuple) else (group.count,))]
    used = {spec.road.lanes, *lengths, *counts}
    reported = f" {' '.join(spec.not_understood)} "
    for value, _ in numbers:
        text = NUMBERS[value].replace("-", " ")
        assert value in used or re.search(rf"(?<![\w])({text}|{NUMBERS[value]})(?!\w)", reported), (parts, spec)


@pytest.mark.parametrize(
    ("sentence", "left"),
    [
        ("a car and an android", ("android",)),
        ("a tent on the left and a car", ("tent", "the left")),
        ("no crossroads and a car", ("no crossroads",)),
        ("two roads and a car", ("two",)),
        ("several lanes and a car", ("several",)),
        ("a road with 2 lanes, 3 lanes and a car", ("3",)),
        ("a car 20 m ahead driving 30 m away", ("30 m",)),
        ("a car 20 m 30 m ahead", ("20 m",)),
        ("a man riding three bikes", ("three",)),
        ("thirty traffic", ("thirty",)),
        ("people people next to thirteen the thirteen people", ("thirteen", "thirteen")),
    ],
)
def test_what_used_to_vanish_is_reported(sentence: str, left: tuple[str, ...]) -> None:
    assert spec_from_text(sentence).not_understood == left


def test_control_characters_are_blanks() -> None:
    spec = spec_from_text("a\x1b[31m car\x00ahead and a be\x07ll\u202e")
    assert all(text.isprintable() for text in spec.not_understood)
    assert spec.groups[0] == group("car", 1, "front")
    for sentence in ("\x1b\x00", "xy\x1bzzy"):
        with pytest.raises(TextError) as caught:
            spec_from_text(sentence)
        assert str(caught.value).isprintable()
    with pytest.raises(TextError, match="the sentence is empty"):
        spec_from_text("\x00\u200b")


def test_a_sentence_has_a_length() -> None:
    with pytest.raises(TextError, match="the sentence has 1000005 characters; it may have 10000"):
        spec_from_text("9" * 1_000_000 + " cars")
    assert spec_from_text("9" * 9000 + " cars").not_understood == ("9" * 9000,)


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=60) | st.text("0123456789.,-+ m/o'e", max_size=20))
@example(".0")
def test_any_text_is_read_or_refused(text: str) -> None:
    with contextlib.suppress(TextError, LayoutError):
        spec_from_text(text)


def test_a_list_has_an_object_on_each_line() -> None:
    for text in (
        "car\ncar\ntruck behind",
        "- a car\n- a car\n- a truck behind",
        "1. a car\n2. a car\n3. a truck behind",
    ):
        spec = spec_from_text(text, strict=True)
        assert [(one.kind, one.count, one.places) for one in spec.groups] == [
            ("car", 1, ()),
            ("car", 1, ()),
            ("truck", 1, ("behind",)),
        ]
    wrapped = "There are two parked cars on the left side of the road and a\nbus ahead of us"
    assert [one.kind for one in spec_from_text(wrapped, strict=True).groups] == ["car", "bus"]
