"""Photographs, JPEG, PNG or WebP: pixels, and the focal length that the camera wrote down."""

from __future__ import annotations

import io
import math
import os
import warnings
from dataclasses import dataclass

import numpy as np
from PIL import ExifTags, Image, ImageOps, UnidentifiedImageError

from lidardraft.errors import FormatError
from lidardraft.files import named, read_bytes, regular_size

MAX_PIXELS = 52_000_000  # more than cameras have that take one picture at a time
_MAX_BYTES = 2**28
_KINDS = ("JPEG", "PNG", "WEBP")
# What Pillow raises on a file that is truncated, corrupt or of another kind.
_BROKEN = (OSError, SyntaxError, ValueError, LookupError, TypeError, Image.DecompressionBombError, EOFError)


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """Pixels u8 [H, W, 3], upright, and the focal length [mm] as of film of 36 x 24 mm, where the file says it."""

    pixels: np.ndarray
    film_focal_length: float | None = None


def read_picture(path: str | os.PathLike[str]) -> Picture:
    """The picture of a file, turned as its EXIF data say.

    Raises `FormatError` on what is no picture, a truncated one, or one of more than `MAX_PIXELS`; its header is read
    before memory is taken for it.
    """
    with opened_picture(path) as image:
        if image.mode[:1] in "IF":
            raise FormatError(f"{os.fspath(path)} has pixels of mode {image.mode}; a photograph has 8 bits a channel")
        focal_length = _film_focal_length(image)
        ImageOps.exif_transpose(image, in_place=True)
        pixels = np.asarray(image if image.mode == "RGB" else image.convert("RGB"))  # a copy has 4 bytes a pixel
    return Picture(pixels, focal_length)


def opened_picture(path: str | os.PathLike[str]) -> Image.Image:
    """Pillow's image of a file, with its pixels, as they are stored; raises `FormatError` as `read_picture` does."""
    with named(path):
        if (size := regular_size(path)) > _MAX_BYTES:
            raise FormatError(f"it has {size} bytes; pictures of up to {_MAX_BYTES} are read")
        data = read_bytes(path)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # Pillow's, of many pixels and of odd metadata
                image = Image.open(io.BytesIO(data), formats=_KINDS)
                if math.prod(image.size) <= MAX_PIXELS:
                    image.load()
                    return image
        except _BROKEN as error:
            raise FormatError(f"not a whole picture (JPEG, PNG or WebP): {_said(error)}") from None
        across, down = image.size
        raise FormatError(f"it has {across} x {down} pixels; pictures of up to {MAX_PIXELS} pixels are read")


def _said(error: Exception) -> str:
    return "its kind is not known" if isinstance(error, UnidentifiedImageError) else str(error)


def _film_focal_length(image: Image.Image) -> float | None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = image.getexif().get_ifd(ExifTags.IFD.Exif).get(ExifTags.Base.FocalLengthIn35mmFilm)
            length = float(found) if found is not None else 0.0
        except _BROKEN:
            return None
    return length if math.isfinite(length) and length > 0 else None  # 0 says that it is not known
