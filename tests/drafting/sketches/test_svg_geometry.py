import math

import numpy as np
import pytest

from lidardraft.drafting.sketches.svg_geometry import arc, bezier, ellipse, length, numbers, transform
from lidardraft.errors import FormatError


@pytest.mark.parametrize(
    ("text", "pixels"), [("12.5", 12.5), (" -3px ", -3), ("25.4mm", 96), ("1in", 96), ("1e1", 10), (".5cm", 18.9)]
)
def test_lengths(text: str, pixels: float) -> None:
    assert length(text, "x") == pytest.approx(pixels, rel=1e-3)


@pytest.mark.parametrize("text", ["", "50%", "3 m", "nan", "1e99", "2em", "--1"])
def test_what_is_no_length(text: str) -> None:
    with pytest.raises(FormatError, match="x is "):
        length(text, "x")


@pytest.mark.parametrize("text", ["1e308%", "1e9%", "1e400%", "9e6in"])
def test_lengths_beyond_any_sketch(text: str) -> None:
    with pytest.raises(FormatError, match=r"cx is .*; it must be a length of up to 1e\+07 pixels"):
        length(text, "cx", 200.0)


def test_percentages_are_of_a_whole() -> None:
    assert length("40%", "x", 50.0) == 20.0


def test_lists_of_numbers() -> None:
    assert numbers("1,2 -3.5-4 5e1", "points").tolist() == [1, 2, -3.5, -4, 50]
    for text in ("1 2 three", "1e300", "1;2", "inf"):
        with pytest.raises(FormatError, match="points is "):
            numbers(text, "points")


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("translate(10)", (12, 1)),
        ("translate(10, 5)", (12, 6)),
        ("scale(2)", (4, 2)),
        ("scale(2 3)", (4, 3)),
        ("rotate(90)", (-1, 2)),
        ("rotate(90 2 0)", (1, 0)),
        ("matrix(1 0 0 1 5 6)", (7, 7)),
        ("skewX(45)", (3, 1)),
        ("skewY(45)", (2, 3)),
        ("translate(10,0) scale(2)", (14, 2)),
        ("scale(2),translate(10 0)", (24, 2)),
        ("", (2, 1)),
    ],
)
def test_transforms(text: str, place: tuple[float, float]) -> None:
    np.testing.assert_allclose((transform(text) @ (2, 1, 1))[:2], place, atol=1e-9)


@pytest.mark.parametrize(
    "text",
    ["spin(3)", "rotate(1 2)", "scale()", "matrix(1 2 3)", "translate(1", "translate(1e300)", "scale(1e6) scale(1e6)"],
)
def test_transforms_that_are_none(text: str) -> None:
    with pytest.raises(FormatError, match="transform is "):
        transform(text)


def test_curves_begin_and_end_where_they_should() -> None:
    control = np.array([(0, 0), (0, 10), (10, 10), (10, 0)], dtype=float)
    curve = bezier(control)
    np.testing.assert_allclose(curve[-1], (10, 0))
    np.testing.assert_allclose(curve[len(curve) // 2 - 1], (5, 7.5))  # the middle of t
    np.testing.assert_allclose(bezier(control[:3])[-1], (10, 10))


@pytest.mark.parametrize("large", [False, True])
@pytest.mark.parametrize("sweep", [False, True])
def test_arcs_lie_on_their_circle(large: bool, sweep: bool) -> None:
    begin, end = np.array([10.0, 0.0]), np.array([0.0, 10.0])
    points = arc(begin, (10, 10), 0, large, sweep, end)
    np.testing.assert_array_equal(points[-1], end)
    centers = (np.zeros(2), np.array([10.0, 10.0]))
    center = centers[0] if large != sweep else centers[1]
    np.testing.assert_allclose(np.linalg.norm(points - center, axis=1), 10, atol=1e-9)
    assert (len(points) > 20) == large


def test_an_arc_that_is_too_small_grows_and_one_without_radius_is_a_line() -> None:
    points = arc(np.zeros(2), (1, 1), 0, False, True, np.array([10.0, 0.0]))
    np.testing.assert_allclose(np.linalg.norm(points - (5, 0), axis=1), 5, atol=1e-6)
    assert len(arc(np.zeros(2), (0, 1), 0, False, True, np.array([10.0, 0.0]))) == 1


def test_an_ellipse() -> None:
    points = ellipse(3, 4, 2, 1)
    np.testing.assert_allclose(((points - (3, 4)) / (2, 1) ** np.ones(2)) ** 2 @ (1, 1), 1)
    assert math.isclose(points[:, 0].max(), 5)
