"""The fields of points: their names in files, and the scales of intensities.

The scale is the number for an intensity of 1. It is known for some formats and for whole numbers; it is never guessed
from the largest value of a scan.
"""

from __future__ import annotations

import os
import warnings

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.json_fields import is_number

# The names of a field, in lower case; the first one found in a file counts. CloudCompare puts `scalar_` before each.
NAMES = {
    **{axis: (axis,) for axis in "xyz"},
    "intensity": ("intensity", "reflectivity", "reflectance", "remission", "signal", "i"),
    "ring": ("ring", "channel", "laser_id", "laser", "line"),
}
# By the ending of a file, else by the type of whole numbers, as in LAS.
SCALES = dict.fromkeys((".pcd.bin", ".pkl.gz", ".pcap", ".osf"), 255.0) | {".bin": 1.0}
SCALES |= {"uint8": 255.0, "uint16": 65535.0}
_LIKELY = (255.0, 4095.0, 65535.0)
_MOST_CLIPPED = 0.01  # the largest share of intensities over their scale


def named_fields(names: list[str]) -> dict[str, str]:
    """The fields of `NAMES` found among the names, with their names in the file."""
    plain = {name.lower().removeprefix("scalar_"): name for name in reversed(names)}
    found = {field: next((plain[name] for name in known if name in plain), None) for field, known in NAMES.items()}
    return {field: name for field, name in found.items() if name is not None}


def unit_intensity(
    values: np.ndarray, scale: float | None, *, of: str | os.PathLike[str], returned: np.ndarray | slice = slice(None)
) -> np.ndarray:
    """Intensities f32 [N] in 0 to 1 from `values` [N]; only those of returns count if `returned` bool [N] is given.
    `of` is the name of the scan in messages.

    Without a `scale` it is that of whole numbers, or 1. If 1 % of the values or fewer exceed it, they are clipped, with
    a `UserWarning`. Raises `FormatError` if more do: then the scale is unknown.
    """
    if scale is not None and not (is_number(scale) and scale > 0):
        raise FormatError(f"intensity_scale is {scale!r}; it must be a number over 0")
    known = scale or SCALES.get(values.dtype.name) or 1.0
    seen = values[returned].astype(np.float64)
    most, over = seen.max(initial=0.0), int((seen > known).sum())
    likely = next((number for number in _LIKELY if number >= most), most)
    if over > _MOST_CLIPPED * len(seen):
        held = f"intensities have a median of {np.median(seen):.4g} and a maximum of {most:.6g}, over {known:g}"
        raise FormatError(f"{held}; give their scale as --intensity-scale (intensity_scale), likely {likely:g}")
    if scale is None and values.dtype == np.uint16 and most > 0 and likely < known:
        said = f"intensities of 16 bits are divided by {known:g}, but the largest is {most:g}"
        warnings.warn(f"{os.fspath(of)}: {said}: give --intensity-scale {likely:g} if that means 1", stacklevel=2)
    if over:
        said = f"{over} of {len(seen)} intensities are over {known:g}, at most {most:.9g}; they are clipped"
        warnings.warn(f"{os.fspath(of)}: {said}", stacklevel=2)
    unit: np.ndarray = np.minimum(values.astype(np.float32) / np.float32(known), np.float32(1))
    return unit
