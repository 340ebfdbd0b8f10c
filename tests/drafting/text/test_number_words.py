import pytest
from lark import Token

from lidardraft.drafting.solver.scene_spec import MAX_COUNT
from lidardraft.drafting.text.layout import spec_from_text
from lidardraft.drafting.text.number_words import count_of, metres, number, unclear_counts
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
        ("a hundred cars", 100),
        ("a hundred and one cars", 101),
        ("nineteen hundred cars", 1900),
        ("2 hundred cars", 200),
        ("two million cars", 2_000_000),
        ("3 thousand cars", 3000),
        ("a row of ten cars", 10),
        ("a group of 5 cars", 5),
        ("007 cars", 7),
    ],
)
def test_other_ways_to_say_a_number(text: str, value: int) -> None:
    assert counted(text) == value


@pytest.mark.parametrize(
    ("number", "reported"),
    [
        ("2.5", "2.5"),
        ("two point five", "two point five"),
        ("1.000", "1.000"),
        ("1,5", "1,5"),
        ("1 000", "1 000"),
        ("12,34", "12,34"),
        ("2/3", "2/3"),
        ("20+", "20+"),
        ("-5", "-5"),
        ("4x4", "4x4"),
        (".5", ".5"),
        ("2nd", "2nd"),
        ("20 30", "20 30"),
        ("two three", "two three"),
        ("2.5 to 3", "2.5 to 3"),
        ("two groups of five", "two groups of five"),
        ("9" * 30, "9" * 30),
        ("two dozens of", "two dozens of"),
        ("dozens of rows of ten", "dozens of rows of ten"),
        ("tent", "tent"),
        ("onerous", "onerous"),
    ],
)
def test_what_is_no_single_whole_number_is_reported_whole(number: str, reported: str) -> None:
    spec = spec_from_text(f"{number} cars")
    assert spec.not_understood == (reported,)
    assert [(group.kind, group.count) for group in spec.groups] == [("car", "some")]


@pytest.mark.parametrize(
    ("words", "counts"),
    [
        ("20 to 30", (20, 30)),
        ("20-30", (20, 30)),
        ("30 or 20", (20, 30)),
        ("two or three", (2, 3)),
        ("between five and ten", (5, 10)),
        ("up to 20", (1, 20)),
        ("fewer than five", (1, 4)),
        ("at least 10", (10, 15)),
        ("more than 10", (11, 15)),
        ("10 or more", (10, 15)),
        ("a few hundred", (300, 500)),
        ("several dozen", (36, 72)),
        ("two dozen", 24),
        ("2 dozen", 24),
        ("half a dozen", 6),
        ("about 20", 20),
        ("a couple of", 2),
        ("2x", 2),
        ("2 x", 2),
    ],
)
def test_ranges_and_multiples(words: str, counts: int | tuple[int, int]) -> None:
    (group,) = spec_from_text(f"{words} cars", strict=True).groups
    assert group.count == counts


@pytest.mark.parametrize(
    ("words", "counts"),
    [
        ("dozens of", (24, 36)),
        ("scores of", (40, 60)),
        ("hundreds of", (200, 300)),
        ("thousands of", "many"),
        ("loads of", "many"),
    ],
)
def test_a_plural_of_numbers_means_two_of_it_at_least(words: str, counts: str | tuple[int, int]) -> None:
    (group,) = spec_from_text(f"{words} trees", strict=True).groups
    assert group.count == counts
    (traffic,) = spec_from_text(f"{words} traffic", strict=True).groups
    assert traffic.count == "many"


@pytest.mark.parametrize(
    ("sentence", "count", "compound"),
    [
        ("a ten-ton truck", 1, "ten-ton"),
        ("a 10-ton truck", 1, "10-ton"),
        ("a 2.5-ton truck", 1, "2.5-ton"),
        ("a sixty-five-ton truck", 1, "sixty-five-ton"),
        ("twenty five-ton trucks", 20, "five-ton"),
        ("a two-storey house", 1, "two-storey"),
        ("a four-door car", 1, "four-door"),
        ("a 4-wheel-drive car", 1, "4-wheel-drive"),
    ],
)
def test_a_number_inside_a_word_counts_no_objects(sentence: str, count: int, compound: str) -> None:
    spec = spec_from_text(sentence)
    assert [group.count for group in spec.groups] == [count]
    assert spec.not_understood == (compound,)


def test_hyphens_within_numbers_and_before_units_and_lanes_are_blanks() -> None:
    (group,) = spec_from_text("one-hundred-and-two cars", strict=True).groups
    assert group.count == 102
    (group,) = spec_from_text("a car 20-m ahead", strict=True).groups
    assert group.distance == (20.0, 20.0)
    assert spec_from_text("a 3-lane motorway", strict=True).road.lanes == 3
    assert spec_from_text("a four-way junction", strict=True).road.kind == "crossroads"


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("twenty-one".replace("-", " "), 21),
        ("one hundred and two thousand three hundred and four", 102_304),
        ("two point five", 2.5),
        ("1,234,567.5", 1234567.5),
        ("zero", 0),
    ],
)
def test_number(text: str, value: float) -> None:
    assert number(text) == value


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("20 m", 20, 20),
        ("20m", 20, 20),
        ("ten to 30 metres", 10, 30),
        ("30 - 10 m", 10, 30),
        ("every 8 metres", 8, 8),
        ("5 yards apart", 4.572, 4.572),
        ("0.1 km", 100, 100),
        ("within 10 m", 0, 10),
        ("at least 20 m", 20, 60),
        ("between two hundred and three hundred feet", 60.96, 91.44),
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
