"""What the vehicle under a sensor hides: azimuths that each beam does not look out to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.json_fields import are_numbers

Blocked = tuple[tuple[tuple[float, float], ...], ...]


def checked_blocked(name: str, blocked: Any, beams: int) -> Blocked:
    """For each beam its intervals of azimuth [rad] from a start counter-clockwise to an end; nothing for none at all.

    Raises `SensorError` naming the interval of the sensor `name` that cannot be.
    """
    if not isinstance(blocked, list | tuple) or len(blocked) not in (0, beams):
        raise SensorError(
            f"{name}: blocked is {blocked!r:.50}; it must be a list of intervals for each of {beams} beams"
        )
    for beam, intervals in enumerate(blocked):
        if not isinstance(intervals, list | tuple):
            raise SensorError(f"{name}: blocked of beam {beam} is {intervals!r:.50}; it must be a list of intervals")
        for interval in intervals:
            if not are_numbers(interval, 2) or not 0.0 < interval[1] - interval[0] <= 2 * math.pi + 1e-9:
                raise SensorError(
                    f"{name}: blocked of beam {beam} has {interval!r:.50}; it must be a start and an end [rad], "
                    "which comes after it by a full turn or less"
                )
    found = tuple(tuple((float(start), float(end)) for start, end in intervals) for intervals in blocked)
    return found if any(found) else ()


def blocked_pixels(blocked: Blocked, azimuths: np.ndarray) -> np.ndarray:
    """Which pixels are `blocked` (or none), bool [H, W], that look to `azimuths` [H, W]; read-only."""
    pixels = np.zeros(azimuths.shape, dtype=bool)
    for row, intervals, towards in zip(pixels, blocked or ((),) * len(pixels), azimuths, strict=True):
        for start, end in intervals:
            row |= (towards - start) % (2 * math.pi) < end - start
    pixels.flags.writeable = False
    return pixels


def blank_pixels(images: Mapping[str, Any], pixels: np.ndarray) -> None:
    """Write no return into the arrays [..., H, W] and [..., H, W, 3] of `images` where `pixels` [H, W] is True."""
    for name, image in images.items():
        if isinstance(image, np.ndarray):
            where = pixels[..., None] if name == "normal" else pixels
            np.copyto(image, image.dtype.type(-1 if name == "primitive" else 0), where=where)
