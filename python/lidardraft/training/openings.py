"""What of a street a layout might leave open: trained on all of it, a network completes any."""

from __future__ import annotations

import numpy as np

from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import BY_NAME, CLASSES, GROUND

# How often each is drawn: an azimuth sector, all but such a sector, all but objects, all but objects and the road, all
# that stands for nothing said (terrain, and where no shape is hit), everything. Estimates of ours of what people bring.
_SHARES = {"sector": 0.2, "all but a sector": 0.15, "all but objects": 0.15, "all but the road": 0.2, "filler": 0.2}
_SECTOR = (np.pi / 4, np.pi)  # rad, of open sectors
_VIEW = (np.pi / 3, 2 * np.pi / 3)  # rad, of what a camera sees
_FILLER = [BY_NAME[name].id for name in ("none", "terrain")]
_ROAD = [BY_NAME[name].id for name in GROUND if name != "terrain"]
_THINGS = [row.id for row in CLASSES if row.is_thing]
_KEPT_STUFF = 0.3  # how often a class of stuff is given all the same


def sample_opening(condition_image: RangeImage, rng: np.random.Generator) -> np.ndarray:
    """Pixels, bool [H, W], that a draft of the place of a condition image may leave open."""
    kinds, label = list(_SHARES), condition_image.label
    kind = rng.choice([*kinds, "everything"], p=[*_SHARES.values(), 1 - sum(_SHARES.values())])
    if kind == "everything":
        return np.ones(label.shape, dtype=bool)
    if kind == "filler":
        return np.isin(label, _FILLER)
    if kind == "sector":
        return _sector(label.shape, condition_image.sensor.azimuth_span, rng.uniform(*_SECTOR), rng)
    if kind == "all but a sector":
        return ~_sector(label.shape, condition_image.sensor.azimuth_span, rng.uniform(*_VIEW), rng)
    given = _THINGS if kind == "all but objects" else [*_THINGS, *_ROAD]
    stuff = [id for id in np.unique(label).tolist() if id not in (*given, *_FILLER) and rng.random() < _KEPT_STUFF]
    return ~np.isin(label, [*given, *stuff])


def _sector(shape: tuple[int, ...], span: float, width: float, rng: np.random.Generator) -> np.ndarray:
    """The columns of a sector `width` [rad] wide, anywhere in an image that spans `span` [rad], of which it is at most
    three quarters."""
    columns = max(round(shape[1] * min(width / span, 0.75)), 1)
    inside = (np.arange(shape[1]) + rng.integers(shape[1])) % shape[1] < columns
    return np.broadcast_to(inside, shape)
