import numpy as np
import pytest

from lidardraft.drafting.sketches.svg_path import MOST_COMMANDS, PathReader
from lidardraft.errors import FormatError


def pieces(data: str) -> list[tuple[list[list[float]], bool]]:
    return [(np.round(points, 6).tolist(), closed) for points, closed in PathReader(data).pieces()]


@pytest.mark.parametrize(
    ("data", "points"),
    [
        ("M1 2 L3 4", [[1, 2], [3, 4]]),
        ("m1,2 3,4", [[1, 2], [4, 6]]),
        ("M1 2 3 4 5 6", [[1, 2], [3, 4], [5, 6]]),
        ("M0 0H5V3h-1v-1", [[0, 0], [5, 0], [5, 3], [4, 3], [4, 2]]),
        ("M0-1L.5.5", [[0, -1], [0.5, 0.5]]),
    ],
)
def test_lines(data: str, points: list[list[float]]) -> None:
    assert pieces(data) == [(points, False)]


def test_pieces_are_closed_and_go_on_where_they_began() -> None:
    assert pieces("M0 0 L4 0 L4 3 Z L1 1 M9 9 l1 0 z") == [
        ([[0, 0], [4, 0], [4, 3]], True),
        ([[0, 0], [1, 1]], False),
        ([[9, 9], [10, 9]], True),
    ]


def test_curves_go_through_their_ends_and_mirror_their_controls() -> None:
    smooth, said = (
        PathReader(f"M0 0 C0 5 5 5 5 0 {rest}").pieces()[0][0] for rest in ("S10 -5 10 0", "C5 -5 10 -5 10 0")
    )
    np.testing.assert_allclose(smooth, said)
    smooth, said = (PathReader(f"M0 0 q5 5 10 0 {rest}").pieces()[0][0] for rest in ("t10 0", "q5 -5 10 0"))
    np.testing.assert_allclose(smooth, said)


def test_flags_of_arcs_may_touch() -> None:
    np.testing.assert_allclose(
        PathReader("M0 0a5 5 0 0110 0").pieces()[0][0], PathReader("M0 0 A5 5 0 0 1 10 0").pieces()[0][0]
    )


@pytest.mark.parametrize("data", ["L1 2", "M1", "M1 2 b3", "M1 2 L", "M1 2 Z 3", "M1 2 A1 1 0 2 0 3 3", "M1e99 0", "é"])
def test_data_that_cannot_be_read(data: str) -> None:
    with pytest.raises(FormatError, match="path"):
        PathReader(data).pieces()


def test_a_path_without_end_and_one_that_runs_away() -> None:
    with pytest.raises(FormatError, match=f"more than {MOST_COMMANDS} commands"):
        PathReader("M0 0" + "l1 1" * (MOST_COMMANDS + 1)).pieces()
    with pytest.raises(FormatError, match="further than"):
        PathReader("M0 0" + "l9999999 0" * 3).pieces()
    assert PathReader("").pieces() == []
