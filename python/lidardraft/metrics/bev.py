"""The bird's-eye-view score between two sets of scans, as LiDARGen defines it.

Zyrianov et al., "Learning to Generate Realistic LiDAR Point Clouds", ECCV 2022; constants from the code of the authors
(vzyrianov/lidargen, metrics/histogram). The score is symmetric in the two sets.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.files import named
from lidardraft.metrics.comparisons import KernelDiscrepancy, spectral

BINS = 100
HALF_EXTENT = 80.0  # m; cells of 1.6 m
MIN_DISTANCE = 3.0  # m from the sensor, exclusive
MAX_DISTANCE = 70.0  # m from the sensor, exclusive


def bev_histogram(points: np.ndarray) -> np.ndarray:
    """Counts f64 [100, 100] of sensor-frame points [N, 3] by x and y in [-80 m, 80 m], for distances of 3 to 70 m."""
    distance = np.linalg.norm(points, axis=1)
    x, y = points[(distance > MIN_DISTANCE) & (distance < MAX_DISTANCE), :2].T
    span = (-HALF_EXTENT, HALF_EXTENT)
    return np.histogram2d(x, y, bins=BINS, range=(span, span))[0]


def bev_mmd(recorded: Iterable[np.ndarray], generated: Iterable[np.ndarray]) -> float:
    """Squared maximum mean discrepancy of the histograms of scans [N, 3], each divided by its sum.

    The kernel is Gaussian in the matrix 2-norm (the largest singular value) of the difference of two histograms; the
    means are over all pairs, those of a scan with itself included.
    """
    return histogram_mmd(_histograms(recorded), _histograms(generated))


def histogram_mmd(recorded: np.ndarray, generated: np.ndarray) -> float:
    """`bev_mmd` of histograms [N, 100, 100] that `bev_histogram` has counted."""
    discrepancy = KernelDiscrepancy(np.repeat([0, 1], [len(recorded), len(generated)])[None], spectral)
    for number, histogram in enumerate([*recorded, *generated]):
        with named(f"scan {number if number < len(recorded) else number - len(recorded)}"):
            discrepancy.add(histogram)
    return float(discrepancy.distances()[0])


def _histograms(scans: Iterable[np.ndarray]) -> np.ndarray:
    histograms = [bev_histogram(points) for points in scans]
    if not histograms:
        raise LidarDraftError("a set of scans is empty; a score needs at least one scan on each side")
    return np.stack(histograms)
