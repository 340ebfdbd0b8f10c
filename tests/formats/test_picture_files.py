"""Photographs, what is known of each of their pixels, and the intrinsics of their camera."""

import io
import json
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import ExifTags, Image

from lidardraft.errors import FormatError
from lidardraft.formats.cityscapes import CLASS_FROM_TRAIN_ID, read_semantics
from lidardraft.formats.intrinsics import read_intrinsics
from lidardraft.formats.masks import read_masks
from lidardraft.formats.picture import MAX_PIXELS, read_picture
from lidardraft.semantics import CLASSES

PIXELS = np.random.default_rng(0).integers(0, 256, (20, 30, 3), dtype=np.uint8)


@pytest.mark.parametrize("kind", ["png", "webp"])
def test_pixels_are_read_as_they_were_saved(tmp_path, kind):
    Image.fromarray(PIXELS).save(tmp_path / f"a.{kind}", lossless=True)
    picture = read_picture(tmp_path / f"a.{kind}")
    np.testing.assert_array_equal(picture.pixels, PIXELS)
    assert picture.film_focal_length is None


@pytest.mark.parametrize("mode", ["L", "P", "RGBA", "1", "CMYK"])
def test_pictures_of_all_sorts_become_red_green_blue(tmp_path, mode):
    path = tmp_path / ("a.jpg" if mode == "CMYK" else "a.png")
    Image.fromarray(PIXELS).convert(mode).save(path)
    assert read_picture(path).pixels.shape == (20, 30, 3)


def exif(**values):
    found = Image.Exif()
    for name, value in values.items():
        if name == "Orientation":
            found[ExifTags.Base.Orientation] = value
        else:
            found.get_ifd(ExifTags.IFD.Exif)[ExifTags.Base[name]] = value
    return found


@pytest.mark.parametrize(("written", "read"), [(26, 26.0), (0, None), (None, None)])
def test_the_focal_length_that_the_camera_wrote_down(tmp_path, written, read):
    fields = {} if written is None else {"FocalLengthIn35mmFilm": written}
    Image.fromarray(PIXELS).save(tmp_path / "a.jpg", exif=exif(**fields))
    assert read_picture(tmp_path / "a.jpg").film_focal_length == read


def test_a_picture_is_turned_upright(tmp_path):
    Image.fromarray(PIXELS).save(tmp_path / "a.png", exif=exif(Orientation=6))
    np.testing.assert_array_equal(read_picture(tmp_path / "a.png").pixels, np.rot90(PIXELS, -1))


def huge_png(width, height):
    """A PNG whose header says that it is huge, with hardly any data."""

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")


@pytest.mark.parametrize(("width", "height"), [(10_000, 10_000), (60_000, 60_000), (2**31 - 1, 2**31 - 1)])
def test_a_huge_picture_is_refused_by_its_header(tmp_path, width, height):
    (tmp_path / "a.png").write_bytes(huge_png(width, height))
    with pytest.raises(FormatError, match=r"a\.png: ") as raised:
        read_picture(tmp_path / "a.png")
    assert f"up to {MAX_PIXELS} pixels" in str(raised.value) or "not a whole picture" in str(raised.value)


def test_other_kinds_and_other_depths_are_refused(tmp_path):
    buffer = io.BytesIO()
    Image.fromarray(PIXELS).save(buffer, "gif")
    (tmp_path / "a.png").write_bytes(buffer.getvalue())
    with pytest.raises(FormatError, match=r"a\.png: not a whole picture .JPEG, PNG or WebP.: its kind is not known"):
        read_picture(tmp_path / "a.png")
    Image.fromarray(np.full((4, 4), 900, np.uint16)).save(tmp_path / "b.png")
    with pytest.raises(FormatError, match=r"b\.png has pixels of mode I;16; a photograph has 8 bits a channel"):
        read_picture(tmp_path / "b.png")


# The train ids of cityscapesScripts in their order; 10 is the sky.
NAMES = "road sidewalk building wall fence pole traffic-light traffic-sign vegetation terrain - person rider car truck"
NAMES += " bus train motorcycle bicycle"
TRAIN_IDS = np.array([[*range(19), 255]], dtype=np.uint8)


def test_the_table_is_that_of_the_names():
    names = [CLASSES[CLASS_FROM_TRAIN_ID[k]].name for k in range(19)]
    assert names == ["none" if name == "-" else name for name in NAMES.split()]
    assert CLASS_FROM_TRAIN_ID[255] == 0


def test_train_ids_are_read_from_grey_pictures_and_arrays(tmp_path):
    Image.fromarray(TRAIN_IDS).save(tmp_path / "a.png")
    np.save(tmp_path / "a.npy", TRAIN_IDS.astype(np.int64))
    for name in ("a.png", "a.npy"):
        np.testing.assert_array_equal(read_semantics(tmp_path / name), CLASS_FROM_TRAIN_ID[TRAIN_IDS])


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
    image = Image.fromarray(TRAIN_IDS).convert("P")
    image.putpalette([row.colour[k] for row in CLASSES[1:20] for k in range(3)])
    image.save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_semantics(tmp_path / "a.png"), CLASS_FROM_TRAIN_ID[TRAIN_IDS])


def test_other_tables_are_refused(tmp_path):
    Image.fromarray(np.array([[1, 26, 7]], dtype=np.uint8)).save(tmp_path / "a.png")  # label ids, not train ids
    with pytest.raises(FormatError, match=r"a.png: 26 at row 0, column 1 is not a train id of Cityscapes"):
        read_semantics(tmp_path / "a.png")
    Image.fromarray(np.full((2, 2, 3), 9, dtype=np.uint8)).save(tmp_path / "b.png")
    with pytest.raises(FormatError, match=r"b.png: \(9, 9, 9\) is not the colour of a class of Cityscapes"):
        read_semantics(tmp_path / "b.png")
    for values in (np.zeros((2, 2, 2), int), np.zeros((2, 2)), np.array([[-1]]), np.array([[2**40]])):
        np.save(tmp_path / "c.npy", values)
        with pytest.raises(FormatError, match=r"c.npy: .*(train ids are whole numbers|is not a train id)"):
            read_semantics(tmp_path / "c.npy")


MASKS = np.zeros((2, 4, 5), dtype=bool)
MASKS[0, :2], MASKS[1, 2:, 3:] = True, True
NUMBERS = MASKS[0] * 7 + MASKS[1] * 300


def test_masks_are_read_from_arrays(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "a.npz", masks=MASKS, scores=np.ones(2))
    np.save(tmp_path / "a.npy", MASKS.astype(np.uint8))
    for name in ("a.npz", "a.npy"):
        found = read_masks(tmp_path / name)
        assert found.dtype == bool
        np.testing.assert_array_equal(found, MASKS)


@pytest.mark.parametrize("mode", ["I;16", "L"])
def test_numbers_are_read_from_pictures(tmp_path: Path, mode: str) -> None:
    numbers = NUMBERS.astype(np.uint16) if mode == "I;16" else (NUMBERS % 255).astype(np.uint8)
    Image.fromarray(numbers).save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_masks(tmp_path / "a.png"), numbers)


@pytest.mark.parametrize(
    ("array", "said"),
    [
        (np.ones((2, 3, 4), np.float32), r"it holds float32 \[2, 3, 4\]; masks are bool"),
        (np.ones(4, bool), r"it holds bool \[4\]; masks are bool"),
        (np.full((2, 3, 4), 2), r"it holds 2 to 2; masks \[M, H, W\] are true or false"),
        (np.full((3, 4), -1), r"it holds -1 to -1; numbers of objects are 0 to"),
    ],
)
def test_arrays_that_are_no_masks(tmp_path: Path, array: np.ndarray, said: str) -> None:
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(FormatError, match=rf"a\.npy: {said}"):
        read_masks(tmp_path / "a.npy")


def test_files_that_hold_no_masks(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", segments=MASKS)
    with pytest.raises(FormatError, match=r"a\.npz: 'masks' is missing"):
        read_masks(tmp_path / "a.npz")
    Image.new("RGB", (5, 4)).save(tmp_path / "a.png")
    with pytest.raises(FormatError, match=r"a\.png: it has pixels of mode RGB"):
        read_masks(tmp_path / "a.png")


K = [[721.5, 0, 609.5], [0, 720.5, 172.8], [0, 0, 1]]
FOUR = [721.5, 720.5, 609.5, 172.8]


@pytest.mark.parametrize(
    "content",
    [
        K,
        FOUR,
        {"K": K},
        {"intrinsics": FOUR},
        dict(zip(("fx", "fy", "cx", "cy"), FOUR, strict=True)),
        {"camera_matrix": {"rows": 3, "cols": 3, "data": [value for row in K for value in row]}},
    ],
)
def test_json(tmp_path: Path, content: object) -> None:
    (tmp_path / "camera.json").write_text(json.dumps(content))
    np.testing.assert_array_equal(read_intrinsics(tmp_path / "camera.json"), FOUR)


@pytest.mark.parametrize(
    "text",
    [
        "P0: 1 0 2 0 0 1 2 0 0 0 1 0\nP2: 721.5 0 609.5 44.9 0 720.5 172.8 0.2 0 0 1 0.003\nTr_velo_to_cam: 0\n",
        "calib_time: 09-Jan\nK_02: 1 0 1 0 1 1 0 0 1\nP_rect_02: 721.5 0 609.5 0 0 720.5 172.8 0 0 0 1 0\n",
    ],
)
def test_calibrations_of_kitti(tmp_path: Path, text: str) -> None:
    (tmp_path / "calib.txt").write_text(text)
    np.testing.assert_array_equal(read_intrinsics(tmp_path / "calib.txt"), FOUR)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.json", '{"fx": 3}', "it holds no intrinsics"),
        ("a.json", "[1, 2, 3]", "it holds no intrinsics"),
        ("a.json", '["a", 1, 1, 1]', "it holds no intrinsics"),
        ("a.json", "[NaN, 1, 1, 1]", "it holds no intrinsics"),
        ("a.txt", "nothing", "not a calibration of KITTI"),
        ("a.txt", "P2: 1 2 x", "P2: .* is not 9 or 12 finite numbers"),
        ("a.txt", "P2: 1 2 3", "P2: .* is not 9 or 12 finite numbers"),
        ("a.txt", "x" * 2**20 + "x", "such files of up to 1048576"),
    ],
)
def test_files_that_say_none(tmp_path: Path, name: str, text: str, said: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(FormatError, match=rf"{name}.*{said}"):
        read_intrinsics(tmp_path / name)
