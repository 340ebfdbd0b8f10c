"""What adjectives and verbs say of objects."""

import pytest

from lidardraft.drafting.text.layout import spec_from_text


@pytest.mark.parametrize(
    ("sentence", "size"),
    [
        ("a 3 m high wall", (None, None, 3.0)),
        ("a wall 3 metres high", (None, None, 3.0)),
        ("a 3-metre-high wall", (None, None, 3.0)),
        ("a 12 m truck", (12.0, None, None)),
        ("a 10 m tree", (None, None, 10.0)),
        ("a wall 2 m high and 20 m long", (20.0, None, 2.0)),
        ("a hedge 1.5 m wide", (None, 1.5, None)),
    ],
)
def test_sizes(sentence: str, size: tuple[float | None, ...]) -> None:
    (group,) = spec_from_text(sentence).groups
    assert group.size == size
    assert group.distance is None


def test_scales() -> None:
    (tower,) = spec_from_text("a skyscraper", strict=True).groups
    assert tower.scale == (1.0, 1.0, 2.5)
    (long,) = spec_from_text("a very long low hedge", strict=True).groups
    assert long.scale == (1.5, 1.0, 0.6)


@pytest.mark.parametrize(
    ("sentence", "heading"),
    [
        ("a parked car", "parked"),
        ("a car driving", "with"),
        ("a car going the wrong way", "against"),
        ("people crossing from left to right", "across-right"),
        ("a car turning left", "turning-left"),
        ("a car waiting", None),
    ],
)
def test_headings(sentence: str, heading: str | None) -> None:
    assert spec_from_text(sentence, strict=True).groups[0].heading == heading
