"""Roughness within a class: how far neighbouring returns lie off a common plane.

The definition is our own: windows of 3 lasers by 5 firings, all of one class; the residual is the root of the smallest
eigenvalue of the covariance of their points.
"""

from __future__ import annotations

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.sweep import Sweep

RESIDUAL_EDGES = np.concatenate([[0.0], np.geomspace(0.002, 2.0, 25), [np.inf]])  # m
_ROWS, _COLUMNS = 3, 5
_FARTHEST = 30.0  # m
_MOST_WINDOWS = 1500


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
    """Where a window of members alone begins, bool [H - 2, W - 4]; windows do not cross the seam."""
    rows, columns = member.shape[0] - _ROWS + 1, member.shape[1] - _COLUMNS + 1
    upright = np.logical_and.reduce([member[i : rows + i] for i in range(_ROWS)])
    return np.logical_and.reduce([upright[:, j : columns + j] for j in range(_COLUMNS)])
