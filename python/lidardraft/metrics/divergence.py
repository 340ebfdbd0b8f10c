"""Distances between distributions, as the scores of this folder use them."""

from __future__ import annotations

import numpy as np
from scipy.special import rel_entr
from scipy.stats import wasserstein_distance

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
    # scipy's jensenshannon is NaN where rounding makes the divergence of equal histograms negative.
    return float(np.sqrt(max(rel_entr(p, mean).sum() + rel_entr(q, mean).sum(), 0.0) / 2))


def wasserstein(first: np.ndarray, second: np.ndarray) -> float:
    """Earth mover's distance (Wasserstein-1) of two samples of numbers [N] and [M], in their unit."""
    if not (len(first) and len(second)):
        raise LidarDraftError("a sample is empty; a distance needs values on both sides")
    return float(wasserstein_distance(first, second))
