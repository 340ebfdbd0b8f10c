import math

import numpy as np
import pytest

from drawn_sketches import DrawnBox, DrawnLine, Hand, painted
from lidardraft.drafting.sketch.painting import (
    BAR,
    EGO,
    PAPER,
    UNKNOWN,
    classes_of_pixels,
    read_painting,
    without_specks,
)
from lidardraft.errors import FormatError, LayoutError
from lidardraft.semantics import BY_NAME, CLASSES

ROAD = DrawnLine("road", np.array([(-40.0, 0.0), (40.0, 0.0)]), 7.0)
CAR = DrawnBox("car", (8.0, 1.8), 4.2, 1.8, 0.1)


def test_shapes_are_where_they_were_painted() -> None:
    found = read_painting(painted([ROAD, CAR], hand=Hand(1, 0.05)), 0.1, None)
    (car,), (road,) = found.blobs, found.strokes
    np.testing.assert_allclose(car.center, CAR.center, atol=0.1)
    assert (car.length, car.width) == pytest.approx((4.2, 1.8), abs=0.25)
    assert abs(math.remainder(car.yaw - 0.1, math.pi)) < math.radians(3)
    assert (road.label, road.width) == ("road", pytest.approx(7.0, abs=0.4))
    assert np.abs(road.line[:, 1]).max() < 0.5
    assert np.ptp(road.line[:, 0]) > 78


def test_a_road_goes_on_under_what_stands_on_it() -> None:
    bus = DrawnBox("bus", (10.0, 0.0), 11.0, 7.5, 0.0)  # as wide as the road
    (road,) = read_painting(painted([ROAD, bus]), 0.1, None).strokes
    assert np.ptp(road.line[:, 0]) > 78


def test_a_bar_says_the_scale_and_green_the_ego_vehicle() -> None:
    found = read_painting(painted([ROAD, CAR], bar=20.0, ego=(-5.0, -1.0)), None, 20.0)
    assert found.metres_per_unit == pytest.approx(0.1, rel=0.01)
    assert found.ego_marked
    np.testing.assert_allclose(found.blobs[0].center, (13.0, 2.8), atol=0.15)
    ignored = read_painting(painted([ROAD, CAR], bar=20.0), 0.1, None).ignored
    assert ignored[-1] == "black: the scale is given in metres per pixel"


def test_a_large_picture_is_read_coarsely() -> None:
    fine = painted([ROAD, CAR], metres_per_pixel=0.04, size=(2000, 2000))
    found = read_painting(fine, 0.04, None)
    assert found.metres_per_unit == pytest.approx(0.04)
    np.testing.assert_allclose(found.blobs[0].center, CAR.center, atol=0.1)


@pytest.mark.parametrize("label", ["bus", "train"])
def test_like_colours_are_told_apart_by_the_whole_piece(label: str) -> None:
    pixels = painted([DrawnBox(label, (0.0, 0.0), 12.0, 2.6, 0.0)])
    noise = np.random.default_rng(0).normal(0, 9, pixels.shape)
    noisy = np.clip(pixels + noise, 0, 255).astype(np.uint8)
    found = read_painting(noisy, 0.1, None)
    assert [blob.label for blob in found.blobs] == [label]


def test_what_has_no_colour_of_a_class_is_told() -> None:
    pixels = painted([CAR]).copy()
    pixels[:40, :200] = (255, 128, 128)
    colour, line = read_painting(pixels, 0.1, None).ignored
    assert colour == "colour 255 128 128, 1.2% of the pixels: no class has it"
    assert line.startswith("1.2")
    assert "% of the pixels" in line


def test_lettering_frames_and_arrows_are_no_scale_bar() -> None:
    pixels = painted([CAR], bar=10.0).copy()
    pixels[100:104, 100:700] = pixels[396:400, 100:700] = 0
    pixels[100:400, 100:104] = pixels[100:400, 696:700] = 0
    pixels[600:640, 300:340] = 0
    assert read_painting(pixels, None, 10.0).metres_per_unit == pytest.approx(0.1, rel=0.02)


def test_markings_on_a_road_are_road() -> None:
    pixels = painted([DrawnLine("road", np.array([(-40.0, 0.0), (40.0, 0.0)]), 7.0)]).copy()
    for k in range(0, 800, 40):
        pixels[k : k + 20, 399:402] = 255
    for k in range(5):
        pixels[200:230, 368 + 13 * k : 374 + 13 * k] = 255
    (stroke,) = read_painting(pixels, 0.1, None).strokes
    assert stroke.width == pytest.approx(7.0, abs=0.3)


@pytest.mark.parametrize("paper", [(0, 0, 0), (128, 128, 128), (220, 220, 220), (250, 240, 205)])
def test_paper_may_be_grey_or_black_and_the_bar_white(paper: tuple[int, int, int]) -> None:
    shapes = [DrawnLine("road", np.array([(-40.0, 0.0), (40.0, 0.0)]), 7.0), CAR]
    white = painted(shapes, bar=10.0)
    pixels = np.where((white == 255).all(axis=2, keepdims=True), paper, white).astype(np.uint8)
    if paper == (0, 0, 0):
        pixels[(white == 0).all(axis=2)] = 255
    found = read_painting(pixels, None, 10.0)
    assert ([blob.label for blob in found.blobs], [stroke.label for stroke in found.strokes]) == (["car"], ["road"])
    assert f"colour {' '.join(map(str, paper))}: taken for the paper" in found.ignored


@pytest.mark.parametrize("label", ["building", "other", "pole"])
def test_the_grey_of_a_class_is_no_paper(label: str) -> None:
    """City blocks up to the edges of the sheet."""
    pixels = np.full((600, 600, 3), 255, np.uint8)
    for rows in (slice(0, 250), slice(350, 600)):
        for columns in (slice(0, 250), slice(350, 600)):
            pixels[rows, columns] = BY_NAME[label].colour
    found = read_painting(pixels, 0.1, None)
    assert {blob.label for blob in found.blobs} | {stroke.label for stroke in found.strokes} == {label}
    assert not any("taken for the paper" in line for line in found.ignored)


def test_squared_paper_is_white() -> None:
    pixels = painted([CAR]).copy()
    pixels[::50], pixels[:, ::50] = (205, 225, 240), (205, 225, 240)
    assert [blob.label for blob in read_painting(pixels, 0.1, None).blobs] == ["car"]


@pytest.mark.parametrize(
    ("pixels", "said"),
    [
        (np.full((50, 50, 3), (255, 128, 128), np.uint8), "100% of the pixels have no class's colour"),
        (np.random.default_rng(0).integers(0, 256, (300, 300, 3)).astype(np.uint8), "have no class's colour"),
        (painted([CAR], size=(99, 99)), "or a black bar and its length in metres"),
    ],
)
def test_pictures_that_are_no_sketch(pixels: np.ndarray, said: str) -> None:
    with pytest.raises(LayoutError, match=said):
        read_painting(pixels, None, None)


def test_scales_that_cannot_be() -> None:
    with pytest.raises(LayoutError, match="no black bar"):
        read_painting(painted([CAR]), None, 10.0)
    with pytest.raises(LayoutError, match="is 4000 m wide; 1 to 2000 m"):
        read_painting(painted([CAR]), 5.0, None)
    with pytest.raises(LayoutError, match="is 8e-306 m wide; 1 to 2000 m"):
        read_painting(painted([CAR]), 1e-308, None)


def test_more_shapes_than_a_sketch_has() -> None:
    pixels = np.full((900, 900, 3), 255, np.uint8)
    spots = (np.add.outer(np.arange(900) % 10 < 4, np.zeros(900, int)) > 0) & (np.arange(900) % 10 < 4)
    pixels[spots] = (0, 0, 142)
    with pytest.raises(FormatError, match="more than 1500 shapes"):
        read_painting(pixels, 0.1, None)


def test_every_colour_of_the_palette_is_itself() -> None:
    colours = [(255, 255, 255), *(row.colour for row in CLASSES[1:]), (0, 255, 0), (0, 0, 0)]
    pixels = np.repeat(np.array(colours, dtype=np.uint8)[:, None], 9, axis=1).repeat(9, axis=0)
    found = classes_of_pixels(pixels)
    assert found[4::9, 4].tolist() == [PAPER, *range(1, 21), EGO, BAR]


@pytest.mark.parametrize("label", ["car", "building", "road", "person", "vegetation"])
def test_smooth_edges_show_no_other_class(label: str) -> None:
    """Between white and dark blue, say, lies the colour of walls."""
    pixels = painted(
        [DrawnBox(label, (3.0, 2.0), 12.0, 7.0, 0.4), DrawnLine(label, np.array([(-30, -9), (30, -5)]), 3.0)]
    )
    found, _ = without_specks(classes_of_pixels(pixels), 8)
    assert {CLASSES[k].name for k in np.unique(found)} == {"none", label}


def test_specks_lines_of_a_pixel_and_unknown_colours_become_what_is_around_them() -> None:
    found = np.full((40, 40), 1, dtype=np.uint8)
    found[5, 3:30] = 5
    found[10:12, 10:12] = 13
    found[20:30, 20:30] = 13
    found[24:26, 24:26] = UNKNOWN
    cleaned, count = without_specks(found, 8)
    assert count == 27 + 4 + 4
    assert np.count_nonzero(cleaned == 13) == 100
    assert set(np.unique(cleaned)) == {1, 13}
