"""The words of a phrase that say nothing of its noun."""

import pytest

from lidardraft.drafting.text.layout import spec_from_text


@pytest.mark.parametrize(
    ("phrase", "unknown"),
    [
        ("a busy car", ("busy",)),
        ("a long road", ("long",)),
        ("a narrow road", ()),
        ("two three cars", ("two three",)),
        ("several roads", ("several",)),
        ("twenty traffic", ("twenty",)),
    ],
)
def test_strange_words(phrase: str, unknown: tuple[str, ...]) -> None:
    assert spec_from_text(phrase).not_understood == unknown
