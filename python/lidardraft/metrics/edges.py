"""Edges: how often a firing that meets two surfaces returns a range between them, a mixed pixel.

The definition is our own. Beams are wide: where one falls half on a near and half on a far surface, a sensor may report
a mean of both (mixed pixels, Hebert and Krotkov, IROS 1991).
"""

from __future__ import annotations

import numpy as np

from lidardraft.metrics.sweep import Sweep

_STEP = 1.0  # m between near and far
_CLEAR = 0.3  # m from both
_SMOOTH = 0.2  # m, at most, from firing to firing on either side
STEP_EDGES = np.concatenate([[0.0], np.geomspace(0.002, 64.0, 31), [np.inf]])  # m


def mixed_share(sweep: Sweep) -> float:
    """Share of the edges in rows that have a mixed pixel between near and far; NaN without edges.

    An edge lies between two smooth pieces (two returns each) whose ends are more than 1 m apart in range; a mixed
    pixel is at least 0.3 m from both.
    """
    depth = sweep.depth
    left, right = _column(depth, -1), _column(depth, 1)
    smooth_left = _near(_column(depth, -2), left)
    smooth_right = _near(right, _column(depth, 2))
    lower, upper = np.minimum(left, right), np.maximum(left, right)
    apart = smooth_left & smooth_right & (upper - lower > _STEP)
    mixed = apart & (depth > lower + _CLEAR) & (depth < upper - _CLEAR)
    direct = _near(left, depth) & smooth_right & (right > 0) & (np.abs(right - depth) > _STEP)
    edges = mixed.sum() + direct.sum()
    return float(mixed.sum() / edges) if edges else float("nan")


def range_steps(sweep: Sweep) -> np.ndarray:
    """Steps in range from firing to firing of a laser, counted by size: f64 [len(STEP_EDGES) - 1]."""
    depth = sweep.depth
    after = _column(depth, 1)
    both = (depth > 0) & (after > 0)
    return np.histogram(np.abs(after - depth)[both], STEP_EDGES)[0].astype(np.float64)


def range_bends(sweep: Sweep) -> np.ndarray:
    """How far a return lies off the middle of its neighbours in a row, counted by size: f64 [len(STEP_EDGES) - 1].

    On smooth surfaces that is the noise of the range; in foliage and at edges it is their depth.
    """
    depth = sweep.depth
    before, after = _column(depth, -1), _column(depth, 1)
    all_three = (depth > 0) & (before > 0) & (after > 0)
    return np.histogram(np.abs(depth - (before + after) / 2)[all_three], STEP_EDGES)[0].astype(np.float64)


def _column(depth: np.ndarray, offset: int) -> np.ndarray:
    """The image with the pixel `offset` columns to the right in each place; beyond the border is no return."""
    return np.pad(depth, ((0, 0), (2, 2)))[:, 2 + offset : 2 + offset + depth.shape[1]]


def _near(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return (first > 0) & (second > 0) & (np.abs(first - second) <= _SMOOTH)
