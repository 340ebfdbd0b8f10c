import itertools
import math
import tracemalloc

import numpy as np
import pytest
from PIL import Image, ImageDraw
from scipy import ndimage

from lidardraft.drafting.sketches.centre_lines import CentreLine, centre_lines
from lidardraft.errors import FormatError


def painted_lines(*lines: list[tuple[float, float]], width: int, size: int = 400) -> np.ndarray:
    canvas = Image.new("1", (size, size))
    for line in lines:
        ImageDraw.Draw(canvas).line(line, fill=1, width=width, joint="curve")
    return np.asarray(canvas)


def only(mask: np.ndarray) -> CentreLine:
    (line,) = centre_lines(mask)
    return line


@pytest.mark.parametrize("width", [3, 8, 35])
@pytest.mark.parametrize("turn", [0.0, 0.3, 1.2])
def test_a_stroke_has_its_line_width_and_ends(width: int, turn: float) -> None:
    middle, half = np.array([200.0, 200.0]), 150 * np.array([math.cos(turn), math.sin(turn)])
    ends = [tuple(middle - half), tuple(middle + half)]
    line = only(painted_lines(ends, width=width))
    assert not line.closed
    assert abs(line.width - width) < 1.5
    off = (line.points[:, ::-1] - middle) @ np.array([-math.sin(turn), math.cos(turn)])
    along = (line.points[:, ::-1] - middle) @ np.array([math.cos(turn), math.sin(turn)])
    assert np.abs(off[np.abs(along) < 150 - width]).max() < 1.5
    assert np.abs(off).max() < 1.5 + 0.2 * width  # the ends have corners
    assert abs(np.ptp(along) - 300) < 6


def test_bumps_and_bites_do_not_move_the_line() -> None:
    mask = painted_lines([(20, 200), (380, 200)], width=40).copy()
    mask[215:232, 100:120] = True
    mask[180:192, 250:280] = False
    line = only(mask)
    inner = line.points[(line.points[:, 1] > 40) & (line.points[:, 1] < 360)]
    assert np.abs(inner[:, 0] - 200).max() < 1.5
    assert abs(line.width - 40) < 1.5


def test_a_ring_is_closed() -> None:
    canvas = Image.new("1", (300, 300))
    ImageDraw.Draw(canvas).ellipse((50, 50, 250, 250), outline=1, width=16)
    line = only(np.asarray(canvas))
    assert line.closed
    np.testing.assert_array_equal(line.points[0], line.points[-1])
    assert np.abs(np.linalg.norm(line.points - 150, axis=1) - 92).max() < 2.5
    assert abs(line.width - 16) < 1.5


def test_where_strokes_cross_one_is_whole_and_the_others_end_at_its_edge() -> None:
    mask = painted_lines([(0, 200), (400, 200)], [(150, 0), (150, 330)], width=30)
    lines = sorted(centre_lines(mask), key=lambda line: -np.ptp(line.points, axis=0).max())
    assert len(lines) == 3
    assert np.abs(lines[0].points[:, 0] - 200).max() < 3
    assert np.ptp(lines[0].points[:, 1]) > 390
    ends = sorted(float(end) for line in lines[1:] for end in line.points[[0, -1], 0])
    np.testing.assert_allclose(ends, [0, 185, 215, 330], atol=6)


def test_a_road_that_leaves_another_is_one_more_stroke() -> None:
    mask = painted_lines([(0, 200), (400, 200)], [(250, 200), (250, 400)], width=26)
    long, short = sorted(centre_lines(mask), key=lambda line: -np.ptp(line.points, axis=0).max())
    assert np.abs(long.points[:, 0] - 200).max() < 3
    assert short.points[:, 0].min() == pytest.approx(213, abs=5)
    assert np.abs(short.points[:, 1] - 250).max() < 3


def test_a_thick_stroke_that_ends_at_another_reaches_its_edge() -> None:
    """The middle line of the two is drawn towards the one that ends, by a third of its width."""
    mask = painted_lines([(200, 0), (200, 399)], [(200, 150), (399, 150)], width=74)
    through, side = sorted(centre_lines(mask), key=lambda line: -np.ptp(line.points[:, 0]))
    assert np.ptp(through.points[:, 0]) > 390
    ends = side.points[:, 1].min()
    assert 200 < ends < 200 + 37


def test_four_roads_at_a_ring_leave_no_gap() -> None:
    size, ring = 800, np.indices((800, 800)) - 400
    away = np.hypot(*ring)
    mask = (away > 80) & (away < 150) | (np.abs(ring) < 33).any(axis=0) & (away > 80)
    lines = list(centre_lines(mask))
    shown = np.zeros((size, size), dtype=bool)
    for line in lines:
        for a, b in itertools.pairwise(line.points):
            shown |= _stroke(a, b, line.width / 2, size)
    assert np.count_nonzero(mask & ~shown) < 0.05 * np.count_nonzero(mask)


def _stroke(a: np.ndarray, b: np.ndarray, half: float, size: int) -> np.ndarray:
    picture = Image.new("1", (size, size))
    aside = (b - a)[::-1] * (1, -1) / max(float(np.linalg.norm(b - a)), 1e-9) * half
    ImageDraw.Draw(picture).polygon([tuple(p[::-1]) for p in (a + aside, b + aside, b - aside, a - aside)], fill=1)
    return np.asarray(picture)


def test_more_than_can_be_read_is_refused() -> None:
    mask = np.zeros((1000, 1000), dtype=bool)
    mask[::4] = True
    mask[:, 0] = True
    with pytest.raises(FormatError, match="up to 60000 are read"):
        list(centre_lines(mask))


def test_a_maze_is_refused() -> None:
    cells = np.random.default_rng(3).integers(0, 2, (160, 160))
    with pytest.raises(FormatError, match=r"strokes of one colour meet \d+ times, in \d+ pieces; up to 2000 are read"):
        list(centre_lines(np.kron(cells, np.ones((6, 6))) > 0))


def test_a_long_line_takes_no_more_memory_than_its_length() -> None:
    """A spiral; the distances between all its points would take gigabytes."""
    down, right = np.mgrid[-500:500, -500:500]
    turns = np.hypot(right, down) / 4 + np.arctan2(down, right) / 2
    mask, _ = ndimage.label(np.abs(np.sin(turns)) < 0.6, np.ones((3, 3)))
    largest = 1 + int(np.argmax(np.bincount(mask.ravel())[1:]))
    tracemalloc.start()
    lines = list(centre_lines(mask == largest))
    assert sum(len(line.points) for line in lines) >= 10_000
    assert tracemalloc.get_traced_memory()[1] < 300e6
    tracemalloc.stop()
