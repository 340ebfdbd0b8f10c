import pytest

from lidardraft.drafting.text.layout import spec_from_text


@pytest.mark.parametrize(
    ("sentence", "counts"),
    [
        ("two cars ahead and one behind", [2, 1]),
        ("three cars ahead, one of them parked", [2, 1]),
        ("three cars ahead, the last one parked", [2, 1]),
        ("four cars on the right, the first is 10 m ahead", [3, 1]),
        ("four cars on the right 10 m apart, the first is 12 m ahead", [4]),
        ("four cars, the first two are parked", [2, 2]),
        ("five cars: two are parked, the rest are oncoming", [2, 3]),
        ("five cars ahead, two of the cars are turning left", [3, 2]),
        ("houses on the left, every house has two trees in front of it; there are three houses", [3, 6]),
        ("bicycles at a wall: 8 of them", [8, 1]),
    ],
)
def test_parts_and_more_of_the_same(sentence: str, counts: list[int]) -> None:
    spec = spec_from_text(sentence, strict=True)
    assert [group.count for group in spec.groups] == counts
