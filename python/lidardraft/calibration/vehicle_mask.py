"""What the vehicle hides: where lasers that look down do not return in one scan after the other."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import Blocked

_DOWN = math.radians(-5.0)  # the road is near there, and returns
_SELDOM = 0.1  # a firing that returns less often is hidden
_ASIDE = 3  # columns to either side that are looked at with each: one dropped firing is no vehicle
_WIDE = math.radians(2.0)  # holes narrower than this are no vehicle


def fit_blocked(sweeps: Sequence[Sweep], elevations: np.ndarray) -> Blocked:
    """For each beam the intervals of azimuth [rad] that are hidden, of sweeps whose columns are azimuths from behind to
    the right on; nothing where none is."""
    rate = np.mean([sweep.valid for sweep in sweeps], axis=0)
    columns = rate.shape[1]
    around = np.pad(rate, ((0, 0), (_ASIDE, _ASIDE)), mode="wrap")
    windows = np.lib.stride_tricks.sliding_window_view(around, 2 * _ASIDE + 1, axis=1)
    hidden = (np.median(windows, axis=2) < _SELDOM) & (elevations[:, None] < _DOWN)
    found = tuple(tuple(_intervals(row, columns)) if row.any() else () for row in hidden)
    return found if any(found) else ()


def _intervals(hidden: np.ndarray, columns: int) -> list[tuple[float, float]]:
    """Runs of a row's hidden columns around the full turn as azimuths; columns count to the right, azimuths to the
    left."""
    step = 2 * math.pi / columns
    if hidden.all():
        return [(-math.pi, math.pi)]
    first = int(np.argmin(hidden))  # a column that is open, from which no run crosses the seam
    changes = np.diff(np.concatenate([[0], np.roll(hidden, -first).astype(np.int8), [0]]))
    starts, ends = np.flatnonzero(changes == 1) + first, np.flatnonzero(changes == -1) + first
    runs = [(start, end) for start, end in zip(starts, ends, strict=True) if (end - start) * step >= _WIDE]
    return [(math.pi - float(end) * step, math.pi - float(start) * step) for start, end in runs]
