"""Returns that are alike in a recording and in a simulated street: of one class, or of one place and shape."""

from __future__ import annotations

import numpy as np

from lidardraft.metrics.lifelike import CLASS_SETS
from lidardraft.metrics.profiles import road_level
from lidardraft.metrics.sweep import Sweep
from lidardraft.semantics import BY_NAME

_FLAT = 0.3  # m over or under the road that is still ground, and
_SLOPE = 0.01  # more of it a metre of distance
_LANE = 2.0  # m to either side: the ground there is the road that the sensor drives on
_HIGH = 2.5  # m over the road: over cars and people are facades and plants
_SMOOTH = 0.05  # m off the middle of its neighbours in the row: a return of a facade; of plants more
LANE, GROUND, SMOOTH, ROUGH, LOW = range(5)

_SETS = np.full(256, len(CLASS_SETS))
for _number, _members in enumerate(CLASS_SETS.values()):
    _SETS[[BY_NAME[member].id for member in _members]] = _number


def groups_of(sweep: Sweep, labelled: bool) -> np.ndarray:
    """The group of each return, i64 [H, W]; nothing is said of pixels without one.

    Of a sweep that is `labelled` it is a set of classes; else the lane, other ground, what is high and smooth (mostly
    facades), high and rough (mostly plants), and the rest.
    """
    if labelled:
        assert sweep.label is not None
        return _SETS[sweep.label]
    height = sweep.points[..., 2] - road_level(sweep)
    ground = np.abs(height) < _FLAT + _SLOPE * sweep.depth
    before, after = np.roll(sweep.depth, 1, axis=1), np.roll(sweep.depth, -1, axis=1)
    smooth = (before > 0) & (after > 0) & (np.abs(sweep.depth - (before + after) / 2) < _SMOOTH)
    above = np.where(height > _HIGH, np.where(smooth, SMOOTH, ROUGH), LOW)
    return np.where(ground, np.where(np.abs(sweep.points[..., 1]) < _LANE, LANE, GROUND), above)
