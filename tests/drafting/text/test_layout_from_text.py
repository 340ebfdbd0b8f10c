import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.layout import grammar, layout_from_text, spec_from_text
from lidardraft.drafting.text.sentence_reader import KIND_OF
from lidardraft.errors import LayoutError, TextError
from lidardraft.scene.check import objects

PAPER = (
    "a vehicle driving on a road with vehicles both in front and behind, "
    "with trees and houses along both sides of the road"
)


def group(kind: str, count: int | str = "some", *places: str, **fields: object) -> ObjectGroup:
    return ObjectGroup(kind=kind, count=count, places=places, **fields)  # type: ignore[arg-type]


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
        spec_from_text("a motorway with 20 lanes each way")
    with pytest.raises(LayoutError, match="car: count is 9000; it must be 1 to 5000"):
        spec_from_text("9000 cars")


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


def test_a_note_says_where_weather_is_asked_for() -> None:
    (note,) = layout_from_text("a motorway in heavy rain").provenance["notes"]
    assert "--weather rain:" in note
    assert "notes" not in layout_from_text("a train on the left of a motorway").provenance
