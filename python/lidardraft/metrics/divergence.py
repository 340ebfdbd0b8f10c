"""Distances between distributions, as the scores of this folder use them."""

from __future__ import annotations

import numpy as np

from lidardraft.errors import LidarDraftError


def jensen_shannon(first: np.ndarray, second: np.ndarray) -> float:
    """Jensen-Shannon distance of two histograms of counts or shares, of one shape: 0 for equal ones, 0.8326 at most.

    The square root of the divergence in nats (Endres and Schindelin, IEEE Trans. Information Theory 49, 2003). Raises
    `LidarDraftError` for a histogram without counts.
    """
    if first.shape != second.shape:
        raise LidarDraftError(f"histograms have the shapes {first.shape} and {second.shape}; they must be equal")
    if not (first.sum() > 0 and second.sum() > 0):
        raise LidarDraftError("a histogram is empty; a distance needs counts on both sides")
    p, q = first / first.sum(), second / second.sum()
    mean = (p + q) / 2
    return float(np.sqrt(max((_kullback_leibler(p, mean) + _kullback_leibler(q, mean)) / 2, 0.0)))


def wasserstein(first: np.ndarray, second: np.ndarray) -> float:
    """Earth mover's distance (Wasserstein-1) of two samples of numbers [N] and [M], in their unit."""
    if not (len(first) and len(second)):
        raise LidarDraftError("a sample is empty; a distance needs values on both sides")
    both = np.sort(np.concatenate([first, second]))
    below = [np.searchsorted(np.sort(sample), both[:-1], side="right") / len(sample) for sample in (first, second)]
    return float(np.sum(np.abs(below[0] - below[1]) * np.diff(both)))


def _kullback_leibler(p: np.ndarray, q: np.ndarray) -> float:
    positive = p > 0
    return float(np.sum(p[positive] * np.log(p[positive] / q[positive])))
