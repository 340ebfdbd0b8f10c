import pytest

from lidardraft.drafting.text.layout import spec_from_text


@pytest.mark.parametrize(
    ("sentence", "places", "distances"),
    [
        ("two cars at 20 m and at 40 m", [(), ()], [(20, 20), (40, 40)]),
        ("trees at 10, 20 and 30 m", [(), (), ()], [(10, 10), (20, 20), (30, 30)]),
        ("a car and a truck, 20 m and 50 m ahead", [("front",), ("front",)], [(20, 20), (50, 50)]),
        ("a car on the left and a bus on the other side", [("left",), ("right",)], [None, None]),
        ("four poles on the left, the first at 10 m, 20 m between them", [("front-left",)], [(10, 10)]),
        ("a car, 20 m ahead, on the left", [("front-left",)], [(20, 20)]),
    ],
)
def test_places_and_distances(
    sentence: str, places: list[tuple[str, ...]], distances: list[tuple[float, float] | None]
) -> None:
    groups = spec_from_text(sentence, strict=True).groups
    assert [group.places for group in groups] == places
    assert [group.distance for group in groups] == distances


@pytest.mark.parametrize(
    ("sentence", "size"),
    [
        ("a tall building of 30 m", (None, None, 30.0)),
        ("a wall of 20 m on the left", (20.0, None, None)),
        ("a wall, height 2 m, length 30 m", (30.0, None, 2.0)),
    ],
)
def test_lengths_of_objects_are_sizes(sentence: str, size: tuple[float | None, ...]) -> None:
    (group,) = spec_from_text(sentence, strict=True).groups
    assert group.size == size
    assert group.distance is None


def test_a_number_at_each_corner() -> None:
    (lights,) = spec_from_text("a crossroads with a traffic light at each of its four corners").groups
    assert (lights.count, lights.at_junction) == (4, True)
