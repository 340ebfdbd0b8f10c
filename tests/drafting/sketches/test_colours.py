import io

import numpy as np
import pytest
from PIL import Image

from drawn_sketches import DrawnBox, DrawnLine, painted
from lidardraft.drafting.sketches.colours import BAR, EGO, PAPER, UNKNOWN, classes_of_pixels, filled, without_specks
from lidardraft.semantics import CLASSES


def test_every_colour_of_the_palette_is_itself() -> None:
    colours = [(255, 255, 255), *(row.colour for row in CLASSES[1:]), (0, 255, 0), (0, 0, 0)]
    pixels = np.repeat(np.array(colours, dtype=np.uint8)[:, None], 9, axis=1).repeat(9, axis=0)
    found = classes_of_pixels(pixels)
    assert found[4::9, 4].tolist() == [PAPER, *range(1, 21), EGO, BAR]


def test_a_colour_of_nothing_has_no_class() -> None:
    assert (classes_of_pixels(np.full((9, 9, 3), (255, 128, 128), np.uint8)) == UNKNOWN).all()


@pytest.mark.parametrize("label", ["car", "building", "road", "person", "vegetation"])
def test_smooth_edges_show_no_other_class(label: str) -> None:
    """Between white and dark blue, say, lies the colour of walls."""
    pixels = painted(
        [DrawnBox(label, (3.0, 2.0), 12.0, 7.0, 0.4), DrawnLine(label, np.array([(-30, -9), (30, -5)]), 3.0)]
    )
    found, _ = without_specks(classes_of_pixels(pixels), 8)
    assert {CLASSES[k].name for k in np.unique(found)} == {"none", label}


def test_noise_of_a_jpeg_file_is_told_from_shapes() -> None:
    pixels = painted(
        [DrawnLine("road", np.array([(-40, 0), (40, 0)]), 7.0), DrawnBox("car", (8.0, 0.0), 4.2, 1.8, 0.2)]
    )
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, format="JPEG", quality=85)
    found, _ = without_specks(classes_of_pixels(np.asarray(Image.open(file))), 8)
    exact, _ = without_specks(classes_of_pixels(pixels), 8)
    assert np.mean(found == exact) > 0.995
    assert set(np.unique(found)) == set(np.unique(exact))


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


def test_nothing_but_gaps_is_paper() -> None:
    assert (filled(np.full((3, 3), 7, np.uint8), np.ones((3, 3), bool)) == PAPER).all()
