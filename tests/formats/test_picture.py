import io
import struct
import zlib

import numpy as np
import pytest
from PIL import ExifTags, Image

from lidardraft.errors import FormatError
from lidardraft.formats.picture import MAX_PIXELS, read_picture

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


def test_a_truncated_picture_is_named(tmp_path):
    Image.fromarray(np.tile(PIXELS, (8, 8, 1))).save(tmp_path / "a.jpg")
    whole = (tmp_path / "a.jpg").read_bytes()
    for length in (0, 3, 200, len(whole) // 2):
        (tmp_path / "b.jpg").write_bytes(whole[:length])
        with pytest.raises(FormatError, match=r"b\.jpg: not a whole picture"):
            read_picture(tmp_path / "b.jpg")


def test_other_kinds_and_other_depths_are_refused(tmp_path):
    buffer = io.BytesIO()
    Image.fromarray(PIXELS).save(buffer, "gif")
    (tmp_path / "a.png").write_bytes(buffer.getvalue())
    with pytest.raises(FormatError, match=r"a\.png: not a whole picture .JPEG, PNG or WebP.: its kind is not known"):
        read_picture(tmp_path / "a.png")
    Image.fromarray(np.full((4, 4), 900, np.uint16)).save(tmp_path / "b.png")
    with pytest.raises(FormatError, match=r"b\.png has pixels of mode I;16; a photograph has 8 bits a channel"):
        read_picture(tmp_path / "b.png")
