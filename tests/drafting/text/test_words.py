"""Words and figures for numbers and lengths, the chart parser, and words that are near to known ones."""

import pytest

from lidardraft.drafting.solver.scene_spec import MAX_COUNT
from lidardraft.drafting.text import lexicon
from lidardraft.drafting.text.chart import Chart, Grammar, Node, rule
from lidardraft.drafting.text.grammar import parse
from lidardraft.drafting.text.layout import explain, nearest_words, spec_from_text
from lidardraft.drafting.text.lexicon import rows, vocabulary
from lidardraft.drafting.text.positions import BEHIND, FRONT, LEFT, Position
from lidardraft.drafting.text.tokens import NUMBER, clean, number, tokens_of
from lidardraft.errors import LayoutError

ONES = [
    *("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"),
    *("thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen"),
]
TENS = ["zero", "ten", "twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety"]


def in_words(value: int, link: str = " and ") -> str:
    """A whole number from 1 to 9,999 in English, as it is usually written."""
    if value >= 1000:
        rest = value % 1000
        return f"{in_words(value // 1000, link)} thousand" + (
            (link if rest < 100 else " ") + in_words(rest, link) if rest else ""
        )
    if value >= 100:
        return f"{ONES[value // 100]} hundred" + (link + in_words(value % 100, link) if value % 100 else "")
    if value >= 20:
        return TENS[value // 10] + (f"-{ONES[value % 10]}" if value % 10 else "")
    return ONES[value]


def counted(text: str) -> int:
    """The number of cars that a sentence asks for, or that it is refused for."""
    try:
        (group,) = spec_from_text(text, strict=True).groups
    except LayoutError as error:
        said, _, limit = str(error).partition("; ")
        assert limit == f"it must be 1 to {MAX_COUNT}, or one of few, some, many"
        count = int(said.removeprefix("car: count is "))
        assert count > MAX_COUNT
        return count
    assert group.kind == "car"
    assert isinstance(group.count, int)
    return group.count


@pytest.mark.parametrize(
    "hundred",
    [0, 2, 10, 11, 19, 47, *(pytest.param(n, marks=pytest.mark.slow) for n in (1, 3, 5, 9, 12, 15, 20, 21, 30, 99))],
)
def test_numbers_in_words_and_digits_are_never_another_count(hundred: int) -> None:
    # every number up to 199, then each hundred with some rests: two-digit endings repeat
    values = range(100 * hundred, 100 * hundred + 100)
    for value in values if hundred < 2 else [v for v in values if v % 100 in (0, 1, 10, 13, 20, 47, 99)]:
        if value == 0:
            continue
        noun = "car" if value == 1 else "cars"
        texts = (in_words(value), in_words(value, " "), in_words(value).replace("-", " "), f"{value}", f"{value:,}")
        for text in texts:
            assert counted(f"{text} {noun}") == value, text


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(("a hundred", 100), ("a hundred and one", 101), ("nineteen hundred", 1900), ("2 hundred", 200)),
        *(("two million", 2_000_000), ("3 thousand", 3000), ("a group of ten", 10), ("007", 7)),
        *(("one-hundred-and-two", 102), ("two dozen", 24), ("2 dozen", 24), ("half a dozen", 6), ("about 20", 20)),
        *(("a couple of", 2), ("2x", 2), ("2 x", 2)),
    ],
)
def test_other_ways_to_say_a_number(text: str, value: int) -> None:
    assert counted(f"{text} cars") == value


@pytest.mark.parametrize(
    "number",
    [
        *("2.5", "two point five", "1.000", "1,5", "1 000", "12,34", "2/3", "20+", "-5", "4x4", ".5", "2nd", "20 30"),
        *("two three", "2.5 to 3", "9" * 30, "tent", "onerous"),
    ],
)
def test_what_is_no_single_whole_number_is_reported_whole(number: str) -> None:
    explanation = explain(f"{number} cars")
    spec = explanation.spec
    assert " ".join((*spec.not_understood, *explanation.not_shown)) == number
    assert [(group.kind, group.count) for group in spec.groups] == [("car", "some")]


@pytest.mark.parametrize(
    ("words", "counts"),
    [
        *(("20 to 30", (20, 30)), ("20-30", (20, 30)), ("30 or 20", (20, 30)), ("two or three", (2, 3))),
        *(("between five and ten", (5, 10)), ("up to 20", (1, 20)), ("fewer than five", (1, 4))),
        *(("at least 10", (10, 15)), ("more than 10", (11, 15)), ("10 or more", (10, 15))),
        *(("a few hundred", (300, 500)), ("several dozen", (36, 72)), ("dozens of", (24, 36))),
        *(("scores of", (40, 60)), ("hundreds of", (200, 300)), ("thousands of", "many"), ("loads of", "many")),
    ],
)
def test_ranges_and_plurals_of_numbers(words: str, counts: str | tuple[int, int]) -> None:
    (group,) = spec_from_text(f"{words} trees", strict=True).groups
    assert group.count == counts


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(("two point five", 2.5), ("1,234,567.5", 1234567.5), ("zero", 0)),
        ("one hundred and two thousand three hundred and four", 102_304),
    ],
)
def test_number(text: str, value: float) -> None:
    assert NUMBER.fullmatch(text)
    assert number(text) == value


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        *(("20 m", 20, 20), ("20m", 20, 20), ("ten to 30 metres", 10, 30), ("30 - 10 m", 10, 30)),
        *(("20 yards", 18.288, 18.288), ("0.1 km", 100, 100), ("within 10 m", 0, 10)),
        *(("at least 20 m", 20, 60), ("between two hundred and three hundred feet", 60.96, 91.44)),
    ],
)
def test_metres(text: str, low: float, high: float) -> None:
    (group,) = spec_from_text(f"a tree {text} ahead", strict=True).groups
    assert group.distance == pytest.approx((low, high))


@pytest.mark.parametrize(
    ("text", "symbols"),
    [
        ("two cars on the left", ["object", "whereabouts"]),
        ("a garden fence", ["object"]),
        ("cars trucks", ["object", "object"]),
        ("a car at the wall", ["object", "relation"]),
        ("a car at 20 m on the left", ["object", "whereabouts"]),
        ("a bus ticket", ["stranger"]),
        ("a left bend 20 m ahead", ["street", "whereabouts"]),
    ],
)
def test_constituents(text: str, symbols: list[str]) -> None:
    assert [node.symbol for node in parse(tokens_of(clean(text), vocabulary()))] == symbols


def test_the_cheapest_constituents_cover_all_tokens() -> None:
    rules = {"pair": (rule("a b"), rule("a a", cost=9.0)), "run": (rule("a a*"),)}
    words = [[Node(symbol, at, at + 1, 0.0), Node("unknown", at, at + 1, 5.0)] for at, symbol in enumerate("aaba")]
    nodes = Chart(Grammar.of(rules, {"pair": 1.0, "run": 1.0, "unknown": 1.0}), words).cover()
    assert [(node.symbol, node.start, node.end) for node in nodes] == [("run", 0, 1), ("pair", 1, 3), ("run", 3, 4)]


def test_a_constituent_begins_with_what_its_first_parts_begin_with() -> None:
    rules = {"noun": (rule("size? colour* thing"), rule("pronoun")), "pair": (rule("noun and noun"),)}
    begins = Grammar.of(rules, {}).begins
    assert begins["noun"] == {"noun", "size", "colour", "thing", "pronoun"}
    assert begins["pair"] == {"pair", *begins["noun"]}


def test_words_that_fit_together_narrow_a_place_and_others_are_alternatives() -> None:
    ahead, left, behind = Position((FRONT,)), Position((LEFT,)), Position((BEHIND,))
    assert ahead.narrowed(left).places == (("front", "left"),)
    assert ahead.narrowed(behind).places == (FRONT, BEHIND)
    assert ahead.or_at(behind).without(ahead).places == (BEHIND,)
    assert ahead.agrees(left)
    assert not ahead.agrees(behind)


def test_a_misspelled_noun_is_named_and_never_taken_for_it() -> None:
    found = nearest_words(["two trcuk ahead", "a bsu, a zebra, a mouse, a cra, tress, a hosue"])
    assert found == {"trcuk": "truck", "bsu": "bus", "mouse": "moose", "cra": "car", "tress": "trees", "hosue": "house"}


def test_a_synonym_and_a_relation_are_a_row_each(monkeypatch: pytest.MonkeyPatch) -> None:
    added = ["kind kind=car: jalopy", "prep relation=behind at.places=behind: astern of"]
    monkeypatch.setattr(lexicon, "rows", lambda name: [*rows(name), *added])
    caches = (lexicon.lexicon, lexicon.vocabulary)
    for one in caches:
        one.cache_clear()
    try:
        spec = spec_from_text("two jalopies astern of a bus", strict=True)
    finally:
        monkeypatch.undo()
        for one in caches:
            one.cache_clear()
    assert [(one.kind, one.count, one.relation) for one in spec.groups] == [("car", 2, "behind"), ("bus", 1, None)]
