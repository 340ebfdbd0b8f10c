"""Positions and what they belong to."""

import pytest

from lidardraft.drafting.text.layout import spec_from_text


@pytest.mark.parametrize(
    ("sentence", "places"),
    [
        ("a car on the left, 20 m away", [("left",)]),
        ("cars in front, behind and on the left", [("front", "behind", "left")]),
        ("a car 20 m ahead and 30 m behind", [("front",), ("behind",)]),
        ("trees on both sides except on the left", [("right",)]),
        ("no cars except on the left", [("left",)]),
        ("We are behind a truck", [("front",)]),
        ("two cars waiting and a bus on the left", [(), ("left",)]),
        ("bus!!! 20 metres!!! ahead!!!", [("front",)]),
        ("There is a bus. Twenty metres ahead.", [("front",)]),
    ],
)
def test_places(sentence: str, places: list[tuple[str, ...]]) -> None:
    assert [group.places for group in spec_from_text(sentence, strict=True).groups] == places


def test_what_a_kind_cannot_have_is_reported() -> None:
    assert spec_from_text("a house in the left lane").not_understood == ("the left lane",)
    assert spec_from_text("a car on the zebra crossing").not_understood == ("the zebra crossing",)
    assert spec_from_text("crowded sidewalks").not_understood == ("crowded",)
