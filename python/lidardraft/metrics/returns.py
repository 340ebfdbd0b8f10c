"""Statistics of firings that return: by laser, on surfaces by range, clusters of dropped ones, and lone returns.

The definitions are our own; all that they need of a recording is known firings.
"""

from __future__ import annotations

import numpy as np

from lidardraft.metrics.sweep import Sweep

RANGE_EDGES = np.array([2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 65.0, 80.0, 120.0])  # m
RUN_EDGES = np.array([1, 2, 3, 4, 5, 7, 10, 15, 25, 50, 100, 200, 10_000])  # firings
_LONGEST_HOLE = 8  # firings
_SAME_SURFACE = 0.1  # of the range
_NEAR = 20.0  # m
_SMOOTH = (0.1, 0.05)  # m and share of the range, between a firing and the next but one on a near surface
_ALONE = (0.5, 0.03)  # m and share of the range, within which a neighbour lies


def returns_by_row(sweep: Sweep) -> np.ndarray:
    """Returns and firings of each laser, f64 [H, 2]."""
    valid = sweep.valid
    return np.stack([valid.sum(axis=1), np.full(len(valid), valid.shape[1])], axis=1).astype(np.float64)


def returns_by_range(sweep: Sweep) -> np.ndarray:
    """Returns and firings on surfaces, f64 [len(RANGE_EDGES) - 1, 2], by range.

    A dropped firing is on a surface if it lies in a hole of at most 8 in its row, between two returns whose ranges
    differ by at most a tenth. Its range is their mean. Firings into the sky or into a mirror are not counted.
    """
    depth = sweep.depth
    counts = np.zeros((len(RANGE_EDGES) - 1, 2))
    counts[:, 0] = np.histogram(depth[depth > 0], RANGE_EDGES)[0]
    rows, starts, ends = runs(depth == 0).T
    inner = (ends - starts <= _LONGEST_HOLE) & (starts > 0) & (ends < depth.shape[1])
    rows, starts, ends = rows[inner], starts[inner], ends[inner]
    before, after = depth[rows, starts - 1], depth[rows, ends]
    same = np.abs(before - after) <= _SAME_SURFACE * np.minimum(before, after)
    dropped = np.histogram((before + after)[same] / 2, RANGE_EDGES, weights=(ends - starts)[same])[0]
    counts[:, 1] = counts[:, 0] + dropped
    return counts


def hole_lengths(sweep: Sweep) -> np.ndarray:
    """The number of runs of dropped firings by length, f64 [len(RUN_EDGES) - 1], over all rows."""
    _, starts, ends = runs(~sweep.valid).T
    return np.histogram(ends - starts, RUN_EDGES)[0].astype(np.float64)


def near_holes(sweep: Sweep) -> np.ndarray:
    """Holes of a single firing on near surfaces, and the places for one, f64 [2].

    A place lies in its row between two returns within 20 m whose ranges differ by at most 0.1 m and 5 %.
    """
    depth = sweep.depth
    before, after = depth[:, :-2], depth[:, 2:]
    places = (before > 0) & (after > 0) & (np.maximum(before, after) < _NEAR)
    places &= np.abs(after - before) <= _SMOOTH[0] + _SMOOTH[1] * before
    return np.array([np.count_nonzero(places & (depth[:, 1:-1] == 0)), np.count_nonzero(places)], dtype=np.float64)


def lone_returns(sweep: Sweep) -> np.ndarray:
    """Returns without any neighbour at their range, and all returns, f64 [2].

    A neighbour is one of the eight firings around; it is at their range if it differs by at most 0.5 m and 3 %.
    """
    depth = sweep.depth
    around = np.pad(depth, 1)
    height, width = depth.shape
    reach = _ALONE[0] + _ALONE[1] * depth
    accompanied = np.zeros(depth.shape, dtype=bool)
    for row, column in ((0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (2, 2)):
        other = around[row : row + height, column : column + width]
        accompanied |= (other > 0) & (np.abs(other - depth) <= reach)
    return np.array([np.count_nonzero(sweep.valid & ~accompanied), np.count_nonzero(sweep.valid)], dtype=np.float64)


def runs(mask: np.ndarray) -> np.ndarray:
    """Runs of True along the rows of [H, W]: row, start and end (exclusive) of each, i64 [N, 3]; borders cut them."""
    rows, changes = np.nonzero(np.diff(np.pad(mask, ((0, 0), (1, 1))).astype(np.int8), axis=1))
    return np.stack([rows[::2], changes[::2], changes[1::2]], axis=1)
