"""What belongs to what in a sentence."""

import pytest

from lidardraft.drafting.text.layout import spec_from_text


@pytest.mark.parametrize(
    ("sentence", "places"),
    [
        ("a car ahead and a bus behind", {"car": ("front",), "bus": ("behind",)}),
        ("on the left a car and a bus", {"car": ("left",), "bus": ("left",)}),
        ("a car and a bus on the left", {"car": ("left",), "bus": ("left",)}),
        ("a car, with a bus on the right", {"car": (), "bus": ("right",)}),
    ],
)
def test_positions_belong_to_what_they_follow_or_introduce(sentence: str, places: dict[str, tuple[str, ...]]):
    spec = spec_from_text(sentence)
    assert {group.kind: group.places for group in spec.groups} == places
    assert spec.not_understood == ()


def test_a_denial_reaches_over_its_list():
    assert spec_from_text("two trees without cars and buses").absent == ("bus", "car")
    assert spec_from_text("no cars and two trees").absent == ("car",)


@pytest.mark.parametrize(
    ("sentence", "counts", "left"),
    [
        ("2 cars flurb", [2], ("flurb",)),
        ("2 cars now", [2], ()),
        ("a car thanks", [1], ()),
        ("a bus stop and a car", [1], ("bus stop",)),
        ("2 bus stops and a car", [1], ("2 bus stops",)),
    ],
)
def test_unknown_words_make_a_compound_of_a_singular_only(sentence: str, counts: list[int], left: tuple[str, ...]):
    spec = spec_from_text(sentence)
    assert [group.count for group in spec.groups] == counts
    assert spec.not_understood == left
