"""Masks of pixels become blobs and strokes: thinning, lines without wobble, centre lines, rectangles."""

import itertools
import math
import tracemalloc

import numpy as np
import pytest
from PIL import Image, ImageDraw
from scipy import ndimage

from lidardraft.drafting.sketch.masks import CentreLine, centre_lines, shapes_of_mask, thinned
from lidardraft.drafting.sketch.shapes import Blob, SketchFrame, Stroke, smooth, without_bumps
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
    down, right = np.mgrid[:401, :401] - 200.0
    ahead, aside = np.array([math.cos(turn), math.sin(turn)]), np.array([-math.sin(turn), math.cos(turn)])
    far, wide = (np.abs(right * each[0] + down * each[1]) for each in (ahead, aside))
    line = only((far <= 150) & (wide <= width / 2))
    assert not line.closed
    assert line.width == pytest.approx(width, abs=0.51)
    off, along = ((line.points[:, ::-1] - 200) @ each for each in (aside, ahead))
    assert np.abs(off[np.abs(along) < 150 - width]).max() < 1.5
    assert np.abs(off).max() < 1.5 + 0.35 * width  # the ends have corners
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


@pytest.mark.parametrize("width", [26, 74])
def test_a_stroke_that_leaves_another_reaches_its_edge(width: int) -> None:
    """The middle line of the two is drawn towards the one that ends, by a third of its width."""
    mask = painted_lines([(0, 200), (399, 200)], [(250, 200), (250, 399)], width=width)
    through, side = sorted(centre_lines(mask), key=lambda line: -np.ptp(line.points[:, 1]))
    assert np.ptp(through.points[:, 1]) > 390
    assert 200 < side.points[:, 0].min() < 200 + width / 2 + 5
    if width < 30:
        assert np.abs(through.points[:, 0] - 200).max() < 3
        assert np.abs(side.points[:, 1] - 250).max() < 3


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
    comb = np.zeros((1000, 1000), dtype=bool)
    comb[::4] = comb[:, :1] = True
    maze = np.kron(np.random.default_rng(3).integers(0, 2, (160, 160)), np.ones((6, 6))) > 0
    for mask, said in ((comb, "up to 60000 are read"), (maze, r"meet \d+ times, in \d+ pieces; up to 2000 are read")):
        with pytest.raises(FormatError, match=said):
            list(centre_lines(mask))


def test_a_long_line_takes_no_more_memory_than_its_length() -> None:
    """A spiral; the distances between all its points would take gigabytes."""
    down, right = np.mgrid[-400:400, -400:400]
    turns = np.hypot(right, down) / 3 + np.arctan2(down, right) / 2
    mask, _ = ndimage.label(np.abs(np.sin(turns)) < 0.6, np.ones((3, 3)))
    largest = 1 + int(np.argmax(np.bincount(mask.ravel())[1:]))
    tracemalloc.start()
    lines = list(centre_lines(mask == largest))
    assert sum(len(line.points) for line in lines) >= 10_000
    assert tracemalloc.get_traced_memory()[1] < 300e6
    tracemalloc.stop()


def test_what_is_in_one_piece_stays_in_one_piece_with_its_holes() -> None:
    rng = np.random.default_rng(0)
    mask = ndimage.gaussian_filter(rng.normal(size=(120, 120)), 4) > 0
    mask[[0, -1]] = mask[:, [0, -1]] = False
    thin = thinned(mask)
    assert thin.sum() < 0.2 * mask.sum()
    assert not (thin & ~mask).any()
    assert ndimage.label(thin, np.ones((3, 3)))[1] == ndimage.label(mask, np.ones((3, 3)))[1]
    assert (
        ndimage.label(np.pad(~thin, 1, constant_values=True))[1]
        == ndimage.label(np.pad(~mask, 1, constant_values=True))[1]
    )


def test_smoothing_takes_bumps_and_leaves_straight_lines_points_and_rings() -> None:
    line = np.linspace((0.0, 0.0), (60.0, 20.0), 61)
    for same in (line, np.zeros((4, 2))):
        for smoothed in (smooth(same, 0.5, False), smooth(same, 3.0, False), without_bumps(same, 3, False)):
            np.testing.assert_allclose(smoothed, same, atol=1e-9)
    bumped = line * (1, 0)
    bumped[20:28, 1] = 5.0
    assert [without_bumps(bumped, window, False)[:, 1].max() for window in (19, 11)] == [0, 5]
    turns = np.linspace(0, math.tau, 61)
    ring = 20 * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    for smoothed in (smooth(ring, 2.0, True), without_bumps(ring, 5, True)):
        np.testing.assert_array_equal(smoothed[0], smoothed[-1])
        assert np.abs(np.linalg.norm(smoothed, axis=1) - 20).max() < 0.6


FRAME = SketchFrame(np.array([100.0, 100.0]), 0.1)


def rectangle(length: float, width: float, yaw: float, size: int = 200) -> np.ndarray:
    """The mask of a rectangle in the middle, its length at `yaw` from up."""
    down, right = np.mgrid[:size, :size] - size / 2
    along, across = -down * math.cos(yaw) - right * math.sin(yaw), down * math.sin(yaw) - right * math.cos(yaw)
    return (np.abs(along) <= length / 2) & (np.abs(across) <= width / 2)


@pytest.mark.parametrize("yaw", [0.0, 0.35, -1.2, 1.5])
@pytest.mark.parametrize("sizes", [(84, 36), (60, 58), (110, 95)])
def test_a_rectangle_has_its_place_size_and_yaw(sizes: tuple[float, float], yaw: float) -> None:
    (blob,) = shapes_of_mask(rectangle(*sizes, yaw), FRAME, "car", ("a",), "here")
    assert isinstance(blob, Blob)
    np.testing.assert_allclose(blob.center, 0.0, atol=0.11)
    assert sorted((blob.length, blob.width)) == pytest.approx(sorted(np.array(sizes) / 10), rel=0.04)
    turn = math.remainder(blob.yaw - yaw, math.pi / 2 if sizes[0] < 1.1 * sizes[1] else math.pi)
    assert abs(turn) < math.radians(2)
    assert (blob.label, blob.names, blob.where) == ("car", ("a",), "here")


def test_what_is_long_is_a_stroke_if_its_class_has_strokes() -> None:
    mask = rectangle(160, 12, 0.5)
    (stroke,) = shapes_of_mask(mask, FRAME, "vegetation", (), "")
    assert isinstance(stroke, Stroke)
    assert stroke.width == pytest.approx(1.2, abs=0.15)
    ahead = stroke.line[-1] - stroke.line[0]
    assert abs(math.remainder(math.atan2(ahead[1], ahead[0]) - 0.5, math.pi)) < 0.03
    assert np.linalg.norm(ahead) == pytest.approx(16, abs=0.6)
    (blob,) = shapes_of_mask(mask, FRAME, "bus", (), "")
    assert isinstance(blob, Blob)


def test_an_outline_of_an_object_is_filled_and_one_of_a_hedge_is_not() -> None:
    solid = rectangle(44, 18, 0.3)
    outline = solid & ~ndimage.binary_erosion(solid, iterations=3)
    (whole,), (drawn,) = (list(shapes_of_mask(mask, FRAME, "car", (), "")) for mask in (solid, outline))
    assert isinstance(whole, Blob)
    assert isinstance(drawn, Blob)
    assert (drawn.length, drawn.width) == (whole.length, whole.width)
    assert all(isinstance(shape, Stroke) for shape in shapes_of_mask(outline, FRAME, "vegetation", (), ""))


def test_a_strip_that_leads_to_an_area_is_a_stroke() -> None:
    mask = np.zeros((400, 400), dtype=bool)
    mask[50:250, 60:340] = True
    mask[250:390, 180:220] = True
    stroke, blob = shapes_of_mask(mask, FRAME, "road", (), "")
    assert isinstance(stroke, Stroke)
    assert isinstance(blob, Blob)
    assert stroke.width == pytest.approx(4.0, abs=0.3)
    assert (blob.length, blob.width) == pytest.approx((28.0, 20.0), rel=0.02)
    assert [type(shape) for shape in shapes_of_mask(rectangle(110, 95, 0.4), FRAME, "road", (), "")] == [Blob]
