"""Class images of Cityscapes: train ids, or colours (Cordts et al., CVPR 2016; tables of cityscapesScripts, MIT)."""

from __future__ import annotations

import os

import numpy as np

from lidardraft.array_files import read_npy
from lidardraft.errors import FormatError
from lidardraft.files import named
from lidardraft.formats.picture import opened_picture
from lidardraft.semantics import CLASSES

_SKY = 10
_VOID = 255
_SKY_COLOUR = (70, 130, 180)
# Class ids 1 to 10 are train ids plus one, 11 to 18 are train ids; sky (10) and void (255) return no ray.
CLASS_FROM_TRAIN_ID = np.zeros(256, dtype=np.uint8)
CLASS_FROM_TRAIN_ID[:_SKY] = np.arange(1, 11)
CLASS_FROM_TRAIN_ID[11:19] = np.arange(11, 19)
_KNOWN = np.zeros(256, dtype=bool)
_KNOWN[[*range(19), _VOID]] = True
_CLASS_OF_COLOUR = {row.colour: row.id for row in CLASSES[:19]} | {_SKY_COLOUR: 0}


def read_semantics(path: str | os.PathLike[str]) -> np.ndarray:
    """Class ids u8 [H, W] of a file of train ids 0 to 18 and 255, `.npy` or a grey PNG, or of a PNG in colours.

    Raises `FormatError` on a file that is broken or holds other numbers or colours.
    """
    with named(path):
        if os.fspath(path).lower().endswith(".npy"):
            return _from_ids(read_npy(path))
        image = opened_picture(path)
        if image.mode in ("L", "P"):
            values = np.asarray(image)
            if image.mode == "L" or _KNOWN[values].all():
                return _from_ids(values)
        return _from_colours(np.asarray(image if image.mode == "RGB" else image.convert("RGB")))


def _from_ids(values: np.ndarray) -> np.ndarray:
    if values.ndim != 2 or values.dtype.kind not in "iu":
        raise FormatError(f"it holds {values.dtype} {list(values.shape)}; train ids are whole numbers [H, W]")
    wrong = (values < 0) | (values > _VOID)
    wrong |= ~_KNOWN[np.where(wrong, 0, values)]
    if wrong.any():
        row, column = np.argwhere(wrong)[0].tolist()
        raise FormatError(
            f"{values[row, column]} at row {row}, column {column} is not a train id of Cityscapes; they are 0 to 18, "
            f"and {_VOID} for pixels without one"
        )
    return CLASS_FROM_TRAIN_ID[values]


def _from_colours(pixels: np.ndarray) -> np.ndarray:
    ids = np.full(2**24, _VOID, dtype=np.uint8)  # by the colour as one number
    for (red, green, blue), id in _CLASS_OF_COLOUR.items():
        ids[red << 16 | green << 8 | blue] = id
    found = np.empty(pixels.shape[:2], dtype=np.uint8)
    for row, colours in enumerate(pixels):  # row by row: numbers of a whole picture are larger than it is
        found[row] = ids[colours.astype(np.uint32) @ np.array([65536, 256, 1], dtype=np.uint32)]
        if (unknown := np.flatnonzero(found[row] == _VOID)).size:
            raise FormatError(f"{tuple(colours[unknown[0]].tolist())} is not the colour of a class of Cityscapes")
    return found
