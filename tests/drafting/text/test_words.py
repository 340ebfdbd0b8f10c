"""Words for numbers, lengths and places, chunks of words, and the mentions of objects that they become."""

import pytest
from lark import Token

from lidardraft.drafting.solver.scene_spec import MAX_COUNT, ObjectGroup
from lidardraft.drafting.text.layout import grammar, nearest_words, spec_from_text
from lidardraft.drafting.text.mention import Mention, is_one_of, keep_away, lanes_filled, parted
from lidardraft.drafting.text.number_words import count_of, metres, number, unclear_counts
from lidardraft.drafting.text.positions import Position, read_position
from lidardraft.drafting.text.sentence_chunks import chunks_of
from lidardraft.drafting.text.sentence_notes import SentenceNotes
from lidardraft.errors import LayoutError

LEFT, RIGHT = ("", "left"), ("", "right")
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


@pytest.mark.parametrize("hundred", range(100))
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
        *(("two million", 2_000_000), ("3 thousand", 3000), ("a row of ten", 10), ("a group of 5", 5), ("007", 7)),
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
        *("two three", "2.5 to 3", "two groups of five", "9" * 30, "two dozens of", "dozens of rows of ten"),
        *("tent", "onerous"),
    ],
)
def test_what_is_no_single_whole_number_is_reported_whole(number: str) -> None:
    spec = spec_from_text(f"{number} cars")
    assert spec.not_understood == (number,)
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
    if words.endswith(" of"):
        assert spec_from_text(f"{words} traffic", strict=True).groups[0].count == "many"


@pytest.mark.parametrize(("text", "value"), [("two point five", 2.5), ("1,234,567.5", 1234567.5), ("zero", 0)])
def test_number(text: str, value: float) -> None:
    assert number(text) == value
    assert number("one hundred and two thousand three hundred and four") == 102_304


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        *(("20 m", 20, 20), ("20m", 20, 20), ("ten to 30 metres", 10, 30), ("30 - 10 m", 10, 30)),
        *(("every 8 metres", 8, 8), ("5 yards apart", 4.572, 4.572), ("0.1 km", 100, 100), ("within 10 m", 0, 10)),
        *(("at least 20 m", 20, 60), ("between two hundred and three hundred feet", 60.96, 91.44)),
    ],
)
def test_metres(text: str, low: float, high: float) -> None:
    assert metres(text) == pytest.approx((low, high))


def test_counts_of_noun_phrases() -> None:
    def said(*words: tuple[str, str]) -> list[Token]:
        return [Token(type, text) for type, text in words]

    assert count_of(said(("CAR", "cars"))) == "some"
    assert count_of(said(("BUS", "bus"))) == 1
    assert count_of(said(("NO", "no"), ("CAR", "cars"))) == 0
    assert count_of(said(("DOZEN", "half a dozen"), ("CAR", "cars"))) == 6
    tokens = said(("NUMBER", "two"), ("NUMBER", "three"), ("CAR", "cars"))
    assert unclear_counts(tokens) == tokens[:2]
    assert count_of(tokens) == "some"


@pytest.mark.parametrize(
    ("text", "chunks"),
    [
        ("two cars on the left", [("phrase", "CAR"), ("position", "LEFT")]),
        ("a garden fence", [("phrase", "FENCE")]),
        ("cars trucks", [("phrase", "CAR"), ("phrase", "TRUCK")]),
        ("a car at the wall", [("phrase", "CAR"), ("PREPOSITION", "PREPOSITION"), ("phrase", "WALL")]),
        ("a car at 20 m on the left", [("phrase", "CAR"), ("position", "LEFT")]),
        ("a bus stop", [("phrase", "COMPOUND")]),
    ],
)
def test_chunks(text: str, chunks: list[tuple[str, str]]) -> None:
    assert [(chunk.name, chunk.head) for chunk in chunks_of(grammar().parse(text))] == chunks


def test_what_is_unknown_has_a_determiner_or_begins_a_clause() -> None:
    def first(text: str) -> tuple[bool, bool]:
        chunk = chunks_of(grammar().parse(text))[0]
        return chunk.is_unknown, chunk.may_be_unknown

    assert first("a llama") == (True, True)
    assert first("llamas") == (False, True)
    assert first("glittering") == (False, False)
    assert first("a red car") == (False, False)


def at(*places: tuple[str, str], **fields: object) -> Position:
    return Position(places=places or (("", ""),), **fields)  # type: ignore[arg-type]


def said(*words: tuple[str, str], beside_road: bool = False) -> Position:
    return read_position([Token(type, text) for type, text in words], beside_road=beside_road)


def test_words_that_fit_together_narrow_a_place() -> None:
    assert said(("FRONT", "ahead"), ("LEFT", "left")).places == (("front", "left"),)
    assert said(("FRONT", "ahead"), ("SIDES", "both sides")).places == (("front", "left"), ("front", "right"))


def test_words_that_contradict_each_other_are_alternatives() -> None:
    assert at(("front", "")).narrowed(at(("behind", ""))).places == (("front", ""), ("behind", ""))


def test_lengths_and_surfaces() -> None:
    near = said(("NEAR", "nearby"), ("SIDEWALK", "sidewalk"))
    assert (near.distance, near.sidewalk) == ((8.0, 18.0), True)
    assert said(("SPACING", "every 8 metres")).spacing == 8.0
    assert said(("DISTANCE", "10 to 20 m"), ("BEHIND", "behind")) == at(("behind", ""), distance=(10.0, 20.0))


def test_beside_a_road_is_no_place_beside_the_ego() -> None:
    assert said(("BESIDE", "next to"), beside_road=True) == at(beside_road=True)
    assert said(("BESIDE", "next to")) == at(("beside", ""))


def test_and_or_without() -> None:
    both = at(("front", "")).or_at(at(("behind", "")))
    assert both.places == (("front", ""), ("behind", ""))
    assert both.without(at(("front", ""))).places == (("behind", ""),)
    assert at(("front", "")).without(at(("front", ""))).places == (("front", ""),)


def test_vehicles_along_the_sides_of_a_road_are_parked() -> None:
    assert Mention("car", 2, Position(places=(LEFT, RIGHT), both_sides=True)).group().heading == "parked"
    assert Mention("car", 2, Position(places=(LEFT,))).group().heading is None


def test_what_queues_stands_in_the_ego_lane_with_gaps() -> None:
    queue = Mention("car", 3, in_queue=True).group()
    assert (queue.lane, queue.places, queue.heading) == ("own", ("front",), "with")
    assert queue.spacing is not None
    assert queue.spacing > 5.0


def test_places_are_left_out_of_those_that_a_mention_names_or_of_all() -> None:
    both, anywhere = Mention("tree", "some", Position(places=(LEFT, RIGHT))), Mention("tree", "some")
    for mention in (both, anywhere):
        keep_away(mention, Position(places=(LEFT,)))
    assert both.at.places == (RIGHT,)
    assert anywhere.not_at == [LEFT]


def test_one_of_them_is_counted_once() -> None:
    whole = Mention("car", 3, Position(places=(LEFT,)), placed=True)
    part = Mention("car", 1, heading="parked", same_as=whole, of_them=True)
    assert [(one.count, one.at.places) for one in parted([whole, part])] == [(2, (LEFT,)), (1, (LEFT,))]


def test_one_more_is_counted_again() -> None:
    first = Mention("car", 2, Position(places=(LEFT,)), placed=True)
    assert [one.count for one in parted([first, Mention("car", 1, same_as=first)])] == [2, 1]


def test_a_sum_is_no_mention_of_its_own() -> None:
    whole = Mention("vehicle", 3)
    parts = [Mention("car", 2), Mention("bus", 1)]
    wanted = parted([whole, *parts])
    assert wanted == parts
    assert all(is_one_of(part, whole, wanted) for part in parts)


def test_the_others_are_what_is_left() -> None:
    whole = Mention("car", 5)
    others = Mention("car", "some", same_as=whole, of_them=True)
    assert [one.count for one in parted([whole, Mention("car", 1, same_as=whole, of_them=True), others])] == [1, 4]


def test_what_each_has_is_as_many() -> None:
    houses = Mention("house", 4)
    tree = Mention("tree", 2, host=houses)
    assert parted([houses, tree])[1] is tree
    assert (tree.count, tree.relation, tree.references) == (8, "near", [houses])


def test_three_abreast_stand_beside_each_other() -> None:
    bikes = Mention("bicycle", 3, abreast=True)
    wanted = parted([bikes])
    assert [one.count for one in wanted] == [1, 1, 1]
    assert [one.relation for one in wanted] == ["beside", "beside", None]


def test_a_number_at_both_sides_is_shared() -> None:
    for count, each in ((5, [3, 2]), ((10, 20), [(5, 10), (5, 10)]), ("some", ["some"]), (1, [1])):
        trees = Mention("tree", count, Position(places=(LEFT, RIGHT), shared=True))
        assert [one.count for one in parted([trees])] == each


def test_lanes_that_one_each_fills() -> None:
    whole = Mention("car", 3)
    assert lanes_filled([whole, Mention("car", 1, Position(lane="each"), same_as=whole)]) == 3
    assert lanes_filled([whole]) == 0


def test_settings_imply_what_the_sentence_does_not_say() -> None:
    notes = SentenceNotes(settings={"RESIDENTIAL", "BUSY"})
    assert {group.kind for group in notes.spec().groups} == {"house", "vehicle"}
    notes = SentenceNotes(mentions=[Mention("building", 2)], settings={"RESIDENTIAL"})
    assert [group.kind for group in notes.spec().groups] == ["building"]


def test_what_is_denied_is_absent_and_not_implied() -> None:
    spec = SentenceNotes(mentions=[Mention("house", 0)], settings={"RESIDENTIAL"}).spec()
    assert spec.absent == ("house",)
    assert spec.groups == ()


def test_lanes_are_counted_on_both_sides_but_on_motorways() -> None:
    assert SentenceNotes(lanes=4).spec().road.lanes == 2
    assert SentenceNotes(lanes=4, each_way=True).spec().road.lanes == 4
    assert SentenceNotes(road="motorway", lanes=3).spec().road.lanes == 3


def test_nothing_noted_is_empty() -> None:
    notes = SentenceNotes("a llama, red", unclear=[(9, 12), (2, 7)])
    assert notes.empty
    assert notes.not_understood == ["llama", "red"]
    assert not SentenceNotes(sidewalk=False).empty
    assert Mention("car", 1).group() == ObjectGroup(kind="car", count=1)


def test_a_misspelled_word_of_the_grammar_is_named_and_never_taken_for_it() -> None:
    assert nearest_words(["two trcuk ahead", "a zebra, a mouse, a cra"], grammar()) == {"trcuk": "truck"}
