"""Furniture and what has no class of its own."""

from coarse_boxes import box, detailed, materials


def test_a_name_says_what_it_is() -> None:
    bench = detailed(box("other", (1.6, 0.5, 0.8), id="bench_1"))
    assert "wood" in materials(bench)
    bin = detailed(box("other", (0.6, 0.6, 1.1), id="bin_1"))
    assert "plastic" in materials(bin)


def test_extents_tell_a_bench_from_a_bin_from_a_shelter() -> None:
    assert "wood" in materials(detailed(box("other", (0.5, 1.6, 0.8))))
    assert "rubber" in materials(detailed(box("other", (0.6, 0.7, 1.1))))
    assert "glass" in materials(detailed(box("other", (4.0, 1.5, 2.5))))


def test_what_is_like_nothing_stays() -> None:
    given = box("other", (5.0, 4.0, 0.2))
    (part,) = detailed(given)
    assert (part.center, part.size, part.material) == (given.center, given.size, "plaster")


def test_a_name_of_another_class_says_nothing() -> None:
    (part,) = detailed(box("other", (5.0, 4.0, 0.2), id="car_1"))
    assert part.label == "other"
