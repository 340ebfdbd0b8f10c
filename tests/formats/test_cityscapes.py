import numpy as np
import pytest
from PIL import Image

from lidardraft.errors import FormatError
from lidardraft.formats.cityscapes import CLASS_FROM_TRAIN_ID, read_semantics
from lidardraft.semantics import CLASSES

# The train ids of cityscapesScripts in their order; 10 is the sky.
NAMES = "road sidewalk building wall fence pole traffic-light traffic-sign vegetation terrain - person rider car truck"
NAMES += " bus train motorcycle bicycle"
IDS = np.array([[*range(19), 255]], dtype=np.uint8)


def test_the_table_is_that_of_the_names():
    names = [CLASSES[CLASS_FROM_TRAIN_ID[k]].name for k in range(19)]
    assert names == ["none" if name == "-" else name for name in NAMES.split()]
    assert CLASS_FROM_TRAIN_ID[255] == 0


def test_train_ids_are_read_from_grey_pictures_and_arrays(tmp_path):
    Image.fromarray(IDS).save(tmp_path / "a.png")
    np.save(tmp_path / "a.npy", IDS.astype(np.int64))
    for name in ("a.png", "a.npy"):
        np.testing.assert_array_equal(read_semantics(tmp_path / name), CLASS_FROM_TRAIN_ID[IDS])


@pytest.mark.parametrize("palette", [True, False])
def test_colours_are_read(tmp_path, palette):
    colours = np.array([row.colour for row in CLASSES[:19]] + [(70, 130, 180)], dtype=np.uint8)[None]
    image = Image.fromarray(colours)
    if palette:  # as the colour images of some programs are stored, with indices of their own
        image = Image.fromarray(np.arange(30, 50, dtype=np.uint8)[None]).convert("P")
        image.putpalette(np.concatenate([np.zeros(90, np.uint8), colours.ravel()]).tolist())
    image.save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_semantics(tmp_path / "a.png"), [[*range(19), 0]])


def test_train_ids_with_a_palette_are_ids(tmp_path):
    image = Image.fromarray(IDS).convert("P")
    image.putpalette([row.colour[k] for row in CLASSES[1:20] for k in range(3)])
    image.save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_semantics(tmp_path / "a.png"), CLASS_FROM_TRAIN_ID[IDS])


def test_other_tables_are_refused(tmp_path):
    Image.fromarray(np.array([[1, 26, 7]], dtype=np.uint8)).save(tmp_path / "a.png")  # label ids, not train ids
    with pytest.raises(FormatError, match=r"a.png: 26 at row 0, column 1 is no train id of Cityscapes"):
        read_semantics(tmp_path / "a.png")
    Image.fromarray(np.full((2, 2, 3), 9, dtype=np.uint8)).save(tmp_path / "b.png")
    with pytest.raises(FormatError, match=r"b.png: \(9, 9, 9\) is no colour of a class of Cityscapes"):
        read_semantics(tmp_path / "b.png")
    for values in (np.zeros((2, 2, 2), int), np.zeros((2, 2)), np.array([[-1]]), np.array([[2**40]])):
        np.save(tmp_path / "c.npy", values)
        with pytest.raises(FormatError, match=r"c.npy: .*(train ids are whole numbers|is no train id)"):
            read_semantics(tmp_path / "c.npy")
