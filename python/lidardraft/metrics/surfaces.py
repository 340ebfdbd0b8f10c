"""Surfaces seen through neighbouring returns: mixed pixels at edges, steps and bends between firings, and roughness.

Beams are wide: if one falls half on a near and half on a far surface, a sensor may report a mean of both (mixed pixels,
Hebert and Krotkov, IROS 1991). Roughness is the distance of neighbouring returns of one class from a common plane: in
windows of 3 lasers by 5 firings, the root of the smallest eigenvalue of the covariance of their points. The
definitions are our own.
"""

from __future__ import annotations

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.sweep import Sweep

_STEP = 1.0  # m between near and far
_CLEAR = 0.3  # m from both
_SMOOTH = 0.2  # m, at most, from firing to firing on either side
STEP_EDGES = np.concatenate([[0.0], np.geomspace(0.002, 64.0, 31), [np.inf]])  # m
RESIDUAL_EDGES = np.concatenate([[0.0], np.geomspace(0.002, 2.0, 25), [np.inf]])  # m
_ROWS, _COLUMNS = 3, 5
_FARTHEST = 30.0  # m
_MOST_WINDOWS = 1500


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
    """Distances of returns from the middle of their neighbours in a row, by size: f64 [len(STEP_EDGES) - 1].

    On smooth surfaces this is the noise of the range; in foliage and at edges it is their depth.
    """
    bend, inside = bends(sweep.depth)
    return np.histogram(bend[inside], STEP_EDGES)[0].astype(np.float64)


def bends(depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance of each return from the middle of its neighbours in the row [H, W - 2], and the mask of all three."""
    before, here, after = depth[:, :-2], depth[:, 1:-1], depth[:, 2:]
    return np.abs(here - (before + after) / 2), (before > 0) & (here > 0) & (after > 0)


def _column(depth: np.ndarray, offset: int) -> np.ndarray:
    """The image of the pixels `offset` columns to the right; beyond the border is no return."""
    return np.pad(depth, ((0, 0), (2, 2)))[:, 2 + offset : 2 + offset + depth.shape[1]]


def _near(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return (first > 0) & (second > 0) & (np.abs(first - second) <= _SMOOTH)


def plane_residuals(sweep: Sweep, labels: tuple[int, ...]) -> np.ndarray:
    """Residuals [N], m, of up to 1500 windows, evenly spread, whose returns have one of `labels` and are within 30 m.

    Raises `LidarDraftError` for a sweep without labels.
    """
    if sweep.label is None:
        raise LidarDraftError("the sweep has no labels; roughness within a class needs them")
    member = np.isin(sweep.label, labels) & sweep.valid & (sweep.depth < _FARTHEST)
    rows, columns = np.nonzero(_whole_windows(member))
    if not len(rows):
        return np.empty(0)
    chosen = np.unique(np.linspace(0, len(rows) - 1, _MOST_WINDOWS).astype(int))
    rows, columns = rows[chosen], columns[chosen]
    windows = np.stack(
        [sweep.points[rows + i, columns + j] for i in range(_ROWS) for j in range(_COLUMNS)], axis=1
    ).astype(np.float64)
    windows -= windows.mean(axis=1, keepdims=True)
    covariance = np.einsum("nki,nkj->nij", windows, windows) / (_ROWS * _COLUMNS)
    return np.sqrt(np.clip(np.linalg.eigvalsh(covariance)[:, 0], 0.0, None))


def residual_histogram(sweep: Sweep, labels: tuple[int, ...]) -> np.ndarray:
    """The residuals of `plane_residuals`, counted by size: f64 [len(RESIDUAL_EDGES) - 1]."""
    return np.histogram(plane_residuals(sweep, labels), RESIDUAL_EDGES)[0].astype(np.float64)


def _whole_windows(member: np.ndarray) -> np.ndarray:
    """The mask of starts of windows with members only, bool [H - 2, W - 4]; windows do not cross the seam."""
    rows, columns = member.shape[0] - _ROWS + 1, member.shape[1] - _COLUMNS + 1
    upright = np.logical_and.reduce([member[i : rows + i] for i in range(_ROWS)])
    return np.logical_and.reduce([upright[:, j : columns + j] for j in range(_COLUMNS)])
