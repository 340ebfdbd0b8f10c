"""Masks of objects in files: .npy, .npz, or a PNG of their numbers."""

from __future__ import annotations

import os

import numpy as np

from lidardraft.array_files import opened, read_npy, read_numbers
from lidardraft.errors import FormatError
from lidardraft.files import named

_NAME = "masks"
_KINDS = ("L", "P", "I", "I;16")  # of pictures with one whole number a pixel


def read_masks(path: str | os.PathLike[str]) -> np.ndarray:
    """Masks bool [M, H, W], the best first, or numbers of objects u32 [H, W], 0 for none.

    The file is an .npy file, an .npz file with an array "masks", or a grey or palette PNG, whose values are read.
    Raises `FormatError` on a file that is broken or holds anything else.
    """
    name = os.fspath(path).lower()
    if name.endswith(".npy"):
        array = read_npy(path)
    elif name.endswith(".npz"):
        with opened(path) as archive:
            array = read_numbers(archive, _NAME)
    else:
        from lidardraft.formats.picture import opened_picture  # Pillow: slow to import, so not for --help

        image = opened_picture(path)
        if image.mode not in _KINDS:
            with named(path):
                raise FormatError(f"it has pixels of mode {image.mode}; masks are grey, a number for each object")
        array = np.asarray(image)
    with named(path):
        return _checked(array)


def _checked(array: np.ndarray) -> np.ndarray:
    if array.ndim not in (2, 3) or array.dtype.kind not in "biu":
        said = "masks are bool [M, H, W], or whole numbers [H, W]"
        raise FormatError(f"it holds {array.dtype} {list(array.shape)}; {said}")
    if array.ndim == 3:
        if array.dtype.kind != "b" and array.size and (array.min() < 0 or array.max() > 1):
            raise FormatError(f"it holds {array.min()} to {array.max()}; masks [M, H, W] are true or false")
        return array.astype(bool)
    if array.size and (int(array.min()) < 0 or int(array.max()) >= 2**32):
        raise FormatError(f"it holds {array.min()} to {array.max()}; numbers of objects are 0 to {2**32 - 1}")
    return array.astype(np.uint32)
