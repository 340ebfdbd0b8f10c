"""Typing errors."""

import pytest

from lidardraft.drafting.text.layout import grammar
from lidardraft.drafting.text.nearest_words import nearest_words


@pytest.mark.parametrize(
    ("word", "known"),
    [
        ("trcuk", "truck"),
        ("pedestrain", "pedestrian"),
        ("tress", "trees"),
        ("bicylce", "bicycle"),
        ("roundabuot", "roundabout"),
        ("motorcyle", None),  # "motor cycle" is spelled with a blank that may be missing
        ("llama", None),
        ("giraffe", None),
        ("cra", None),
    ],
)
def test_a_word_with_an_error_is_near_to_the_one_that_was_meant(word: str, known: str | None) -> None:
    assert nearest_words([f"two {word} ahead"], grammar()) == ({word: known} if known else {})
