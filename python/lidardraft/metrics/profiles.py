"""Histograms of a sweep (range, height over the road, intensity), the fall of intensity with range, and distances.

The definitions of the histograms are our own.
"""

from __future__ import annotations

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.returns import RANGE_EDGES
from lidardraft.metrics.sweep import Sweep

RANGE_BINS = np.arange(0.0, 121.0, 1.0)  # m
HEIGHT_BINS = np.arange(-3.0, 15.05, 0.1)  # m over the road
INTENSITY_BINS = 50
_ROAD_NEAR, _ROAD_FAR = 3.0, 15.0  # m from the sensor, between which to look for the road


def range_histogram(sweep: Sweep) -> np.ndarray:
    """Returns by range in steps of 1 m to 120 m."""
    return np.histogram(sweep.depth[sweep.valid], RANGE_BINS)[0].astype(np.float64)


def height_histogram(sweep: Sweep, road: float | None = None) -> np.ndarray:
    """Returns by height over the road in steps of 0.1 m, -3 to 15 m; `road` is its level [m], if known."""
    level = road_level(sweep) if road is None else road
    return np.histogram(sweep.points[sweep.valid, 2] - level, HEIGHT_BINS)[0].astype(np.float64)


def road_level(sweep: Sweep) -> float:
    """Height [m] of the road under the sensor: the most frequent one of returns 3 to 15 m off and 1 m below or more."""
    z = sweep.points[(sweep.depth > _ROAD_NEAR) & (sweep.depth < _ROAD_FAR) & (sweep.points[..., 2] < -1.0), 2]
    if not len(z):
        raise LidarDraftError("no return 1 m or more below the sensor; the height of the road is unknown")
    counts, edges = np.histogram(z, np.arange(-4.0, -0.95, 0.05))
    most = int(np.argmax(counts))
    return float((edges[most] + edges[most + 1]) / 2)


def intensity_histogram(sweep: Sweep, labels: tuple[int, ...] | None = None) -> np.ndarray:
    """Returns by intensity in 50 equal steps, of all or of some classes; the borders miss KITTI's hundredths."""
    values = np.floor(_intensity(sweep)[_where(sweep, labels)] * INTENSITY_BINS + 0.25)
    return np.bincount(np.clip(values, 0, INTENSITY_BINS - 1).astype(int), minlength=INTENSITY_BINS).astype(np.float64)


def intensity_by_range(sweep: Sweep, labels: tuple[int, ...] | None = None) -> np.ndarray:
    """Sum of intensity, and returns, by range in `returns.RANGE_EDGES`: f64 [len(RANGE_EDGES) - 1, 2]."""
    where = _where(sweep, labels)
    depth, weights = sweep.depth[where], _intensity(sweep)[where]
    sums = np.histogram(depth, RANGE_EDGES, weights=weights)[0]
    return np.stack([sums, np.histogram(depth, RANGE_EDGES)[0]], axis=1).astype(np.float64)


def intensity_by_row(sweep: Sweep) -> np.ndarray:
    """Sum of intensity, and returns, of each laser: f64 [H, 2]."""
    return np.stack([_intensity(sweep).sum(axis=1), sweep.valid.sum(axis=1)], axis=1).astype(np.float64)


def _where(sweep: Sweep, labels: tuple[int, ...] | None) -> np.ndarray:
    if labels is None:
        return sweep.valid
    if sweep.label is None:
        raise LidarDraftError("the sweep has no labels; a histogram of a class needs them")
    return sweep.valid & np.isin(sweep.label, labels)


def _intensity(sweep: Sweep) -> np.ndarray:
    if sweep.intensity is None:
        raise LidarDraftError("the sweep has no intensity")
    return sweep.intensity


def jensen_shannon(first: np.ndarray, second: np.ndarray) -> float:
    """Jensen-Shannon distance of two histograms of counts or shares, of one shape: 0 for equal ones, 0.8326 at most.

    The square root of the divergence in nats (Endres and Schindelin, IEEE Trans. Information Theory 49, 2003). Raises
    `LidarDraftError` for a histogram without counts.
    """
    if first.shape != second.shape:
        raise LidarDraftError(f"histograms have the shapes {first.shape} and {second.shape}; they must be equal")
    if not (first.sum() > 0 and second.sum() > 0):
        raise LidarDraftError("a histogram is empty; a distance needs counts on both sides")
    from scipy.special import rel_entr  # slow to import: a tenth of a second

    p, q = first / first.sum(), second / second.sum()
    mean = (p + q) / 2
    # scipy's jensenshannon is NaN if rounding makes the divergence of equal histograms negative.
    return float(np.sqrt(max(rel_entr(p, mean).sum() + rel_entr(q, mean).sum(), 0.0) / 2))


def wasserstein(first: np.ndarray, second: np.ndarray) -> float:
    """Earth mover's distance (Wasserstein-1) of two samples of numbers [N] and [M], in their unit."""
    if not (len(first) and len(second)):
        raise LidarDraftError("a sample is empty; a distance needs values on both sides")
    from scipy.stats import wasserstein_distance

    return float(wasserstein_distance(first, second))
