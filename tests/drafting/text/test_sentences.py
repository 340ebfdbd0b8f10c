"""Sentences of many forms, with the relations that each is understood as and the words that are not; any others."""

import contextlib
import dataclasses
import itertools
import json
import math
import re
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from readings import reading

from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.scene_spec import ObjectGroup, SceneSpec, relations
from lidardraft.drafting.text.explanation import Explanation
from lidardraft.drafting.text.grammar import parse
from lidardraft.drafting.text.layout import explain, layout_from_text, spec_from_text
from lidardraft.drafting.text.lexicon import lexicon, vocabulary
from lidardraft.drafting.text.tokens import clean, tokens_of
from lidardraft.errors import LayoutError, TextError
from lidardraft.objects.cars import PAINTS
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.scene.check import check, objects
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.weather import Weather
from lidardraft.simulation.simulate import Simulator
from spec_checker import broken, road_of


class Sentence(NamedTuple):
    """A sentence with what it says, what is unknown of it, what has no shape, what its spec does not hold, and the
    refusal that it meets, if any."""

    text: str
    relations: list[str]
    unknown: list[str]
    shapeless: list[str]
    mismatches: list[str]
    refusal: str


def read_sentences() -> list[Sentence]:
    """Those of sentences.txt: under each its relations, "? unknown words", "~ words of no shape", "- a mismatch", and
    "! a refusal"."""
    found: list[Sentence] = []
    for line in Path(__file__).with_name("sentences.txt").read_text(encoding="utf-8").splitlines():
        if not line.startswith("    "):
            found.append(Sentence(line, [], [], [], [], ""))
        elif line.startswith("    ? "):
            found[-1].unknown.append(line[6:])
        elif line.startswith("    ~ "):
            found[-1].shapeless.append(line[6:])
        elif line.startswith("    - "):
            found[-1].mismatches.append(line[6:])
        elif line.startswith("    ! "):
            found[-1] = found[-1]._replace(refusal=line[6:])
        else:
            found[-1].relations.append(line[4:])
    return found


SENTENCES = read_sentences()
UNSEEN = Path(__file__).with_name("unseen.txt").read_text(encoding="utf-8").splitlines()  # of people who know no words
_JOINING = (
    "a an the this that these those my our your his her its their of in on at to from by as so for into "
    "onto through up down out also here there it they them we one ones each all both is are was were be "
    "been being am do does did has have had having can could should must will would may might and or but "
    "nor not except which who whom where while when if with including containing contains featuring "
    "however whereas then plus very quite rather fairly really mostly apart lined about ready wants want "
    "wanting trying tries starts begins going other than another well away now he she that's there's it's "
    "we're aren t exception besides respectively already still currently just so because let letting "
)
FUNCTION_WORDS = frozenset(_JOINING.split())
UNKNOWN_CLAUSES = [
    *(
        "{}, a llama 12 m ahead",
        "{} and a griffin on the left",
        "{}. A dragon hovers above.",
        "{}, unicorns everywhere",
    ),
    *("{}; a UFO parked behind us", "{}, two wombats crossing", "{} and a zeppelin in the left lane", "{}, no yetis"),
    *(
        "{}, with a wizard on the roof",
        "{} and three goblins oncoming",
        "{}. On the left a yeti.",
        "{}, a flumph every 5 m",
    ),
    *("{}, a blorp behind the snark", "{} and an ogre next to a troll", "{}, a basilisk turning left"),
    *(
        "a llama on the left, {}",
        "There is a dragon 20 m behind. {}",
        "On the left a yeti, {}",
        "Two wombats crossing and {}",
    ),
]


def spec_of(text: str) -> SceneSpec | None:
    """The spec of a sentence without what is unknown, None where too much is."""
    read = reading(text)
    return read and dataclasses.replace(read.spec, not_understood=())


def explained(text: str) -> Explanation:
    """What a sentence became, each content word of which gave something that is there, or is reported."""
    explanation = reading(text)
    if explanation is None:
        raise TextError(f"{text!r} is refused")
    spec = explanation.spec
    for one in explanation.meanings:
        words = re.findall(r"[^\W_]+(?:'s|'re)?", one.words)
        left = (*one.lost, *one.unshown)
        assert one.groups or one.others or left or FUNCTION_WORDS.issuperset(words), one
        assert all(any(lost in part for part in spec.not_understood) for lost in one.lost), one
        assert all(any(lost in part for part in explanation.not_shown) for lost in one.unshown), one
        assert all(number < len(spec.groups) for number in one.groups)
    return explanation


@pytest.mark.parametrize("text", UNSEEN)
def test_no_content_word_is_lost_in_silence(text: str) -> None:
    with contextlib.suppress(TextError):
        explained(text)


def test_there_are_many() -> None:
    assert len(SENTENCES) >= 500
    assert len({sentence.text for sentence in SENTENCES}) == len(SENTENCES)


@pytest.mark.parametrize("sentence", SENTENCES, ids=[sentence.text for sentence in SENTENCES])
def test_what_is_understood_and_what_is_not(sentence: Sentence) -> None:
    explanation = explained(sentence.text)
    spec = explanation.spec
    assert [text for text in relations(spec) if text != "road: straight"] == sentence.relations
    assert list(spec.not_understood) == sentence.unknown
    assert list(explanation.not_shown) == sentence.shapeless
    assert list(explanation.mismatches) == sentence.mismatches


@pytest.mark.parametrize("sentence", SENTENCES, ids=[sentence.text for sentence in SENTENCES])
def test_every_relation_holds(sentence: Sentence) -> None:
    spec = explained(sentence.text).spec
    if sentence.refusal:
        with pytest.raises(LayoutError, match=sentence.refusal):
            layout_from_spec(spec, seed=0)
        return
    layouts = [layout_from_spec(spec, seed=seed) for seed in range(2)]
    for layout in layouts:
        assert broken(spec, layout) == []
        assert check(layout) == []
        numbers = {name: asked.group for name, asked in layout.intent.objects.items()}
        assert numbers == layout.provenance["objects"]
        assert all(asked.kind == spec.groups[asked.group].kind for asked in layout.intent.objects.values())
    assert len({tuple((primitive.center, primitive.size) for primitive in layout) for layout in layouts}) == 2


def test_a_sentence_and_a_seed_give_one_layout() -> None:
    for sentence in SENTENCES[::50]:
        if sentence.refusal:
            continue
        layout, same = (layout_from_text(sentence.text, seed=2) for _ in range(2))
        assert layout.to_json() == same.to_json()
        assert layout.primitives == layout_from_spec(explained(sentence.text).spec, seed=2).primitives


@pytest.mark.parametrize(
    "clause", [*UNKNOWN_CLAUSES[::10], *(pytest.param(one, marks=pytest.mark.slow) for one in UNKNOWN_CLAUSES)]
)
def test_an_unknown_clause_changes_nothing_of_the_rest(clause: str) -> None:
    """In nearly all sentences: some go on after the clause as if it were known, as in "two wombats crossing and X"."""
    texts = [sentence.text for sentence in SENTENCES[UNKNOWN_CLAUSES.index(clause) :: 30]]
    changed = [text for text in texts if spec_of(clause.format(text.rstrip(".!"))) != spec_of(text)]
    assert len(changed) <= 0.1 * len(texts), changed


def test_an_explanation_says_what_each_word_became() -> None:
    sentence = "On the left two red cars and a llama, a bus 20 m behind them on a two-lane road"
    explanation = explain(sentence)
    found = [(one.words, one.groups, one.others, one.lost) for one in explanation.meanings]
    assert [one for one in found if one[0] != "and"] == [
        ("on the left", (0,), (), ()),
        ("two red cars", (0,), (), ()),
        ("a llama", (), (), ("llama",)),
        ("a bus", (1,), (), ()),
        ("20 m behind them", (1,), (), ()),
        ("on", (), (), ()),
        ("a two-lane road", (), ("road: 1 lane each way",), ()),
    ]
    assert explanation.spec == spec_from_text(sentence)
    lines = str(explanation).splitlines()
    assert lines[0].split(maxsplit=3) == ["on", "the", "left", "car [0]: 2, on the left, light paint"]
    assert "a llama           not understood" in lines
    assert lines[-1] == "road: straight, 1 lane each way"


@pytest.mark.parametrize(
    ("text", "words", "gave"),
    [
        ("a van in heavy rain", "in heavy rain", "weather: heavy-rain"),
        ("an empty road", "an empty road", "around: empty"),
        ("nobody on the road", "nobody", "person: none"),
        ("a roundabout with a truck", "a roundabout", "road: roundabout"),
        ("a man at the zebra crossing", "at the zebra crossing", "person [0]; not shown: zebra crossing"),
        ("two cyclists ride ahead", "ride", "bicycle [0]"),
        ("a tram runs ahead", "runs", "not shown"),
        ("three trucks are heading the opposite way", "heading the opposite way", "truck [0]"),
        ("a woman holding hands", "holding hands", "not shown"),
        ("a row of five trees", "a row of five trees", "tree [0]: 5, every 6 m"),
    ],
)
def test_each_word_names_what_it_gave(text: str, words: str, gave: str) -> None:
    lines = [line for line in str(explained(text)).splitlines() if line.startswith(words + " ")]
    assert [line.removeprefix(words).strip() for line in lines] == [gave]


@pytest.mark.parametrize(
    "text",
    [
        *("a bench with two people on it, and in front of the bench a suitcase", "only " * 60 + "a car"),
        *("9 " * 100 + "cars", "nine " * 100 + "cars"),
        *("behind a car " * 20, "a car next to it " * 15, "(" * 50 + "a car", "a bench with a man on it " * 10),
        UNSEEN[110],
    ],
)
def test_long_and_deep_sentences_are_read_or_refused(text: str) -> None:
    with contextlib.suppress(TextError, LayoutError):
        explained(text)


def test_strict_refuses_what_is_left() -> None:
    with pytest.raises(TextError, match="not understood: 'flurby'"):
        layout_from_text("a flurby car ahead", strict=True)
    for sentence in SENTENCES[::25]:
        if sentence.unknown or sentence.mismatches:
            with pytest.raises(TextError, match="not understood: " if sentence.unknown else "the sentence says "):
                spec_from_text(sentence.text, strict=True)
        else:
            assert spec_from_text(sentence.text, strict=True) == explained(sentence.text).spec


@pytest.mark.parametrize("kind", SENTENCE_KINDS)
def test_the_name_of_a_kind_is_a_word_for_it(kind: str) -> None:
    assert spec_from_text(f"one {kind}", strict=True).groups == (ObjectGroup(kind=kind, count=1),)


def test_every_word_for_a_kind_means_it() -> None:
    words = [(" ".join(parts), word) for entries in lexicon().values() for parts, word in entries]
    nouns = {text: word.features for text, word in words if word.category == "kind"}
    assert {said["kind"] for said in nouns.values()} == set(SENTENCE_KINDS)
    for number, (noun, said) in enumerate(sorted(nouns.items())[::5]):  # they are alike
        if not said.get("plural"):
            (node,) = parse(tokens_of(clean(f"some {noun}"), vocabulary()))
            read = dict(node.features)
            assert (read["kind"], read.get("noun"), read["count"]) == (
                said["kind"],
                said.get("noun"),
                said.get("count", "some"),
            ), noun
        if number % 14:
            continue  # a whole explanation takes three times as long
        explanation = explain(f"some {noun}")  # two yards are a distance
        (found,) = explanation.spec.groups
        assert (found.kind, found.count, found.places) == (said["kind"], "some", ()), noun
        assert not explanation.spec.not_understood, noun
        assert explanation.not_shown == ((noun,) if "more" in said else ()), noun  # a train is more than a tram


@pytest.mark.parametrize("sentence", ["I want pizza", "xyzzy", "???", "3", "Zwei Hunde"])
def test_nothing_understood(sentence: str) -> None:
    with pytest.raises(TextError, match=r"nothing of .* was understood"):
        layout_from_text(sentence)


def test_a_refusal_names_what_is_unknown_and_what_is_near_to_it() -> None:
    with pytest.raises(TextError, match=r"nothing of 'a llama' was understood \(unknown as a whole: 'llama'\)"):
        spec_from_text("a llama")
    with pytest.raises(
        TextError, match=r"nothing of 'a bus lane' was understood that has a shape \(not shown: 'bus lane'\)"
    ):
        spec_from_text("a bus lane")
    with pytest.raises(TextError, match=r"'bsu ahead' \(nearest words: 'bus' for 'bsu'\)"):
        spec_from_text("a bsu ahead")
    layout = layout_from_text("a bsu ahead, a car behind, a giraffe")
    assert layout.notes == ("not understood: bsu ahead, giraffe; did you mean 'bus'?",)
    assert set(objects(layout)) == {"car_1"}


def test_a_slip_of_the_finger_is_read_and_noted() -> None:
    layout = layout_from_text("a trcuk ahead, a motorcyle behind, a horse")
    assert layout.notes == ("'trcuk' is read as 'truck'", "'motorcyle' is read as 'motorcycle'")
    assert set(objects(layout)) == {"truck_1", "motorcycle_1", "animal_1"}


def test_weather_and_paint_reach_the_scan() -> None:
    """What a sentence says of them is there in the detailed scene and in the air, for each seed."""
    sensor = Sensor.preset("vlp16")
    for seed in range(3):
        black, white = (
            Simulator(f"a {colour} car 10 m ahead in dense fog", sensor, seed=seed) for colour in ("black", "white")
        )
        paints = [{part.material for part in one.scene if part.id.startswith("car_1")} for one in (black, white)]
        assert [paint & set(PAINTS) for paint in paints] == [{"dark-paint"}, {"light-paint"}]
    asked, clear = (
        Simulator("a car in dense fog", sensor, weather=weather).scan(seed=1).image for weather in (None, Weather())
    )
    assert (asked.label > 0).mean() < (clear.label > 0).mean() - 0.1  # what returns from the fog has no label


@pytest.mark.parametrize("kind", ["crossroads", "T-junction", "roundabout"])
def test_a_junction_is_where_the_sentence_says(kind: str) -> None:
    for seed in range(3):
        layout = layout_from_text(f"a {kind} 40 m ahead, two cars at it", seed=seed)
        road = road_of(layout)
        assert road.junction is not None
        assert road.junction - (road.roundabout_radius or road.edge) == pytest.approx(40.0)
    with pytest.raises(LayoutError, match=r"road: junction is .*; it must be a range in metres, 6 <= from <= to"):
        spec_from_text(f"a {kind} 2 m ahead")


def test_who_walks_towards_us_faces_us() -> None:
    for seed in range(3):
        away = layout_from_text("a man walking away from us, 20 m ahead", seed=seed)
        coming = layout_from_text("a man walking towards us, 20 m ahead", seed=seed)
        yaws = [next(one.yaw for one in layout if one.label == "person") for layout in (away, coming)]
        assert [math.cos(yaw) > 0.9 for yaw in yaws] == [True, False]


def test_an_ellipsis_ends_a_sentence() -> None:
    spec = spec_from_text("a bus\u2026 a car\u20262 trees\u2026", strict=True)
    assert spec == spec_from_text("a bus. a car. 2 trees.")


def test_too_many_lanes_and_objects() -> None:
    with pytest.raises(LayoutError, match="lanes is 20; it must be 1 to 6 in each direction"):
        spec_from_text("a motorway with 20 lanes each way")
    with pytest.raises(LayoutError, match="car: count is 9000; it must be 1 to 5000"):
        spec_from_text("9000 cars")


def test_nothing_is_invented() -> None:
    assert objects(layout_from_text("an empty road")) == {}
    names = objects(layout_from_text("trees on the left"))
    assert all(name.startswith("tree_") for name in names)
    assert min(part.center[1] for parts in names.values() for part in parts) > 0


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


def test_control_characters_are_blanks() -> None:
    spec = spec_from_text("a\x1b[31m car\x00ahead and a be\x07ll\u202e")
    assert all(text.isprintable() for text in spec.not_understood)
    assert spec.groups[0] == ObjectGroup(kind="car", count=1, places=("front",))
    for sentence in ("\x1b\x00", "xy\x1bzzy"):
        with pytest.raises(TextError) as caught:
            spec_from_text(sentence)
        assert str(caught.value).isprintable()
    for sentence in ("", "   ", "\n", "\x00\u200b"):
        with pytest.raises(TextError, match="the sentence is empty"):
            spec_from_text(sentence)


def test_a_sentence_has_a_length() -> None:
    with pytest.raises(TextError, match="the sentence has 1000005 characters; it may have 10000"):
        spec_from_text("9" * 1_000_000 + " cars")
    with pytest.raises(TextError, match="the text has 201 words and signs; it may have 200, more with --llm-url"):
        spec_from_text("a car ahead " * 67)
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
STRANGE = ["blimp", "android", "fourteenth", "Xylophones", "4x4", "naïve", "--", "andante"]


@settings(max_examples=75, deadline=None)
@given(st.lists(st.sampled_from(WORDS), min_size=1, max_size=14))
def test_any_run_of_words_is_read_or_refused(words: list[str]) -> None:
    try:
        spec = spec_from_text(" ".join(words))
    except (TextError, LayoutError):
        return
    assert SceneSpec.from_dict(json.loads(json.dumps(spec.to_dict()))) == spec


@settings(max_examples=50, deadline=None)
@given(st.lists(st.sampled_from(WORDS) | st.sampled_from(STRANGE), min_size=1, max_size=12))
def test_words_that_are_not_in_the_vocabulary_are_reported(words: list[str]) -> None:
    try:
        spec = spec_from_text(" ".join(words))
    except (TextError, LayoutError):
        return
    reported = Counter(" ".join(spec.not_understood).split())
    assert not Counter(word.lower() for word in words if word in STRANGE) - reported


# Words that say something of what they stand with, or nothing at all; without those that only join others.
PUT_IN = ["flurb", "red", "7", "big", "behind", "opposite", "cyclists", "a roundabout", "20 m", "10 m apart", "nearby"]
NEAR_OTHERS = re.compile(r"\d|\b(and|or|at|from|between|each|one|two|both|road|street|other|follow\w*)\b")


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(SENTENCES), st.sampled_from(["flurb", "grokking", "xyzzy", "bsu"]), st.integers(0, 40))
def test_an_unknown_word_put_in_is_always_reported(sentence: Sentence, word: str, index: int) -> None:
    words = sentence.text.split()
    text = " ".join([*words[: index % (len(words) + 1)], word, *words[index % (len(words) + 1) :]])
    with contextlib.suppress(TextError, LayoutError):
        assert word in " ".join(spec_from_text(text).not_understood).split()


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.sampled_from(SENTENCES), st.sampled_from(PUT_IN), st.integers(0, 40))
def test_a_word_put_in_that_changes_nothing_is_reported(sentence: Sentence, word: str, index: int) -> None:
    words = sentence.text.split()
    at = index % (len(words) + 1)
    assume(word.split()[-1] not in re.findall(r"\w+", sentence.text.lower()))  # what is said twice is accounted for
    assume(not NEAR_OTHERS.search(" ".join(words[max(0, at - 2) : at + 2]).lower()))
    try:
        both = [explain(" ".join(one)) for one in (words, [*words[:at], word, *words[at:]])]
    except (TextError, LayoutError):
        return
    before, after = (dataclasses.replace(one.spec, not_understood=()) for one in both)
    said = [" ".join((*one.spec.not_understood, *one.not_shown)).split() for one in both]
    assert before != after or len(said[1]) > len(said[0]) or set(word.split()) <= set(said[1])


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.sampled_from(PLAIN_WORDS), max_size=5),
    st.lists(
        st.tuples(st.sampled_from(sorted(NUMBERS)), st.lists(st.sampled_from(PLAIN_WORDS), min_size=1, max_size=4)),
        max_size=3,
    ),
)
def test_numbers_are_used_or_reported(words: list[str], numbers: list[tuple[int, list[str]]]) -> None:
    """A number in figures or words counts objects or lanes, also for each of others, is a length, or is reported."""
    parts = [*words, *(word for value, after in numbers for word in (NUMBERS[value], *after))]
    try:
        spec = spec_from_text(" ".join(parts))
    except (TextError, LayoutError):
        return
    lengths = [length for group in spec.groups for length in (*(group.distance or ()), group.spacing)]
    lengths += [length for group in spec.groups for length in group.size or ()]
    counts = [n for group in spec.groups for n in (group.count if isinstance(group.count, tuple) else (group.count,))]
    halves = {a + b for a, b in itertools.pairwise(one for one in counts if isinstance(one, int))}  # at two sides
    used = {spec.road.lanes, *lengths, *counts, *halves}
    reported = f" {' '.join(spec.not_understood)} "
    for value, _ in numbers:
        text = NUMBERS[value].replace("-", " ")
        each = {"each", "every", "per"} & set(parts)  # "two trees for every house": as many for some houses
        each = each and any(isinstance(count, int) and count % value == 0 for count in counts)
        told = re.search(rf"(?<![\w])({text}|{NUMBERS[value]})(?!\w)", reported)
        assert value in used or each or told, (parts, spec)


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=60) | st.text("0123456789.,-+ m/o'e", max_size=20))
@example(".0")
def test_any_text_is_read_or_refused(text: str) -> None:
    with contextlib.suppress(TextError, LayoutError):
        spec_from_text(text)


def test_each_group_has_the_words_that_asked_for_it() -> None:
    spec = spec_from_text("three flurbed cars grok on the left, a snark and two vans")
    assert [group.words for group in spec.groups] == ["three flurbed cars grok on the left", "two vans"]


@pytest.mark.parametrize("text", ["bus!!! 20 metres!!! ahead!!!", "There is a bus. Twenty metres ahead."])
def test_a_distance_in_a_sentence_of_its_own_is_that_of_the_object_before_it(text: str) -> None:
    (group,) = spec_from_text(text, strict=True).groups
    assert group.places == ("front",)
