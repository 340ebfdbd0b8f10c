"""Photographs, JPEG, PNG or WebP: pixels, and the focal length that the camera recorded."""

from __future__ import annotations

import io
import math
import os
import warnings
from dataclasses import dataclass

import numpy as np
from PIL import ExifTags, Image, ImageOps, UnidentifiedImageError

from lidardraft.errors import FormatError
from lidardraft.files import expecting, named, read_bytes

MAX_PIXELS = 52_000_000  # more than cameras that take one picture at a time
_KINDS = ("JPEG", "PNG", "WEBP")


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """Pixels u8 [H, W, 3], upright, and the focal length [mm] on film of 36 x 24 mm, if the file has it."""

    pixels: np.ndarray
    film_focal_length: float | None = None


def read_picture(path: str | os.PathLike[str]) -> Picture:
    """The picture of a file, turned as its EXIF data say.

    Raises `FormatError` if the file is not a picture, is truncated, or has more than `MAX_PIXELS`; the header is read
    before memory is allocated.
    """
    with opened_picture(path) as image:
        if image.mode[:1] in "IF":
            raise FormatError(f"{os.fspath(path)} has pixels of mode {image.mode}; a photograph has 8 bits a channel")
        focal_length = _film_focal_length(image)
        ImageOps.exif_transpose(image, in_place=True)
        pixels = np.asarray(image if image.mode == "RGB" else image.convert("RGB"))  # a copy has 4 bytes a pixel
    return Picture(pixels, focal_length)


def opened_picture(path: str | os.PathLike[str]) -> Image.Image:
    """Pillow's image of a file with its pixels as stored; raises `FormatError` as `read_picture` does."""
    data = read_bytes(path)
    with named(path):
        with warnings.catch_warnings(), expecting("a whole picture (JPEG, PNG or WebP)"):
            warnings.simplefilter("ignore")  # Pillow's, on many pixels and odd metadata
            image = _image_of(data)
            if math.prod(image.size) <= MAX_PIXELS:
                image.load()
                return image
        across, down = image.size
        raise FormatError(f"it has {across} x {down} pixels; pictures of up to {MAX_PIXELS} pixels are read")


def _image_of(data: bytes) -> Image.Image:
    try:
        return Image.open(io.BytesIO(data), formats=_KINDS)
    except UnidentifiedImageError:
        raise ValueError("its kind is not known") from None


def _film_focal_length(image: Image.Image) -> float | None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = image.getexif().get_ifd(ExifTags.IFD.Exif).get(ExifTags.Base.FocalLengthIn35mmFilm)
            length = float(found) if found is not None else 0.0
        except Exception:  # as for the picture itself, Pillow raises any error
            return None
    return length if math.isfinite(length) and length > 0 else None  # 0 means unknown
