"""Any run of words is read or refused, and none of them is lost."""

import contextlib
import re
from collections import Counter

from hypothesis import example, given, settings
from hypothesis import strategies as st

from lidardraft.drafting.solver.scene_spec import SceneSpec
from lidardraft.drafting.text.layout import spec_from_text
from lidardraft.errors import LayoutError, TextError

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
    """A number in figures or words counts objects or lanes, also for each of others, is a length, or is reported."""
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
        products = {value * other for other, _ in numbers}  # "two trees for every house, thirteen houses"
        told = re.search(rf"(?<![\w])({text}|{NUMBERS[value]})(?!\w)", reported)
        assert value in used or products & set(counts) or told, (parts, spec)


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=60) | st.text("0123456789.,-+ m/o'e", max_size=20))
@example(".0")
def test_any_text_is_read_or_refused(text: str) -> None:
    with contextlib.suppress(TextError, LayoutError):
        spec_from_text(text)
