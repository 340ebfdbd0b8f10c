"""A sentence in chunks."""

import pytest

from lidardraft.drafting.text.layout import grammar
from lidardraft.drafting.text.sentence_chunks import chunks_of


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
