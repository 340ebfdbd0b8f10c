"""Groups of returns that are alike in a recording and in a simulated street: by class, or by place and shape."""

from __future__ import annotations

import numpy as np

from lidardraft.metrics.lifelike import CLASS_SETS
from lidardraft.metrics.profiles import road_level
from lidardraft.metrics.sweep import Sweep
from lidardraft.semantics import BY_NAME

_FLAT = 0.3  # m over or under the road that count as ground, and
_SLOPE = 0.01  # more of it a metre of distance
_LANE = 2.0  # m to either side: the ground there is the road that the sensor drives on
_HIGH = 2.5  # m over the road: above cars and people are facades and plants
_SMOOTH = 0.05  # m off the middle of the neighbours in the row: facades; plants have more
LANE, GROUND, SMOOTH, ROUGH, LOW = range(5)

_SETS = np.full(256, len(CLASS_SETS))
for _number, _members in enumerate(CLASS_SETS.values()):
    _SETS[[BY_NAME[member].id for member in _members]] = _number


def groups_of(sweep: Sweep, labelled: bool) -> np.ndarray:
    """The group of each return, i64 [H, W]; pixels without a return have no meaning.

    If the sweep is `labelled`, groups are sets of classes. Else they are lane, other ground, high and smooth (mostly
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
