"""Distances between sets of scans, of several comparisons at once: the two sets, and halves of one for the noise floor.

`sides` i8 [C, N] gives the side of each of N scans in each of C comparisons: 0 recorded, 1 generated, -1 neither. A
distance takes the measurements of scans one after the other (`add`), and gives one number for each comparison
(`distances`). `histogram_mmd` is LiDARGen's score of two sets alone (Zyrianov et al., ECCV 2022; constants from
vzyrianov/lidargen, metrics/histogram).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.files import named
from lidardraft.metrics.profiles import jensen_shannon

KERNEL_WIDTH = 0.5  # of LiDARGen and R2DM
BINS, HALF_EXTENT = 100, 80.0  # m; cells of 1.6 m
MIN_DISTANCE, MAX_DISTANCE = 3.0, 70.0  # m from the sensor, exclusive
_CELLS = 200  # along an edge of the square in which top views are matched
_BLOCK = 256  # scans on each side that are compared at once
_HELD = 4  # blocks of generated top views that are held at once, in 0.6 GB


class Distance(Protocol):
    """The interface of the distances in this file."""

    def add(self, measured: np.ndarray) -> None:
        """Add the measurement of the next scan."""

    def distances(self) -> np.ndarray:
        """The distance of each comparison, f64 [C]."""


class PooledDivergence:
    """Jensen-Shannon distance of summed counts: the square root of the divergence in nats."""

    def __init__(self, sides: np.ndarray, cells: int) -> None:
        self._sides = iter(sides.T)
        self._sums = np.zeros((len(sides), 2, cells), dtype=np.uint32)

    def add(self, measured: np.ndarray) -> None:
        """Add the cells [M, 2] of a scan: the index, each once, and the count."""
        cells, counts = measured.T
        for sums, side in zip(self._sums, next(self._sides), strict=True):
            if side >= 0:
                sums[side, cells] += counts.astype(np.uint32)

    def distances(self) -> np.ndarray:
        """The distance of each comparison, f64 [C]."""
        there = (sums[:, sums.any(axis=0)].astype(np.float64) for sums in self._sums)
        return np.array([jensen_shannon(*sums) for sums in there])


class KernelDiscrepancy:
    """Squared maximum mean discrepancy of histograms [R, S] of sum 1: a Gaussian kernel of width 0.5, means over all
    pairs, including a scan with itself. Keeps 4 bytes a bin."""

    def __init__(self, sides: np.ndarray, squared_distances: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> None:
        self._sides, self._histograms = sides, list[np.ndarray]()
        self._squared_distances = squared_distances

    def add(self, measured: np.ndarray) -> None:
        """Add the counts [R, S] of a scan."""
        if not measured.any():
            raise LidarDraftError("no point lies in the top view")
        self._histograms.append((measured / measured.sum()).astype(np.float32))

    def distances(self) -> np.ndarray:
        """The discrepancy of each comparison, f64 [C]."""
        # w^T K w for each comparison, with w = 1 / N on one side and -1 / M on the other; w sums to 0, so K - 1 will do
        weights = np.stack([(s == 0) / np.sum(s == 0) - (s == 1) / np.sum(s == 1) for s in self._sides])
        found = np.zeros(len(weights))
        for first, second in _blocks(len(self._histograms), len(self._histograms)):
            if first.start <= second.start:
                blocks = (np.stack(self._histograms[part]).astype(np.float64) for part in (first, second))
                kernel = np.expm1(-self._squared_distances(*blocks) / (2 * KERNEL_WIDTH**2))
                times = 1 if first == second else 2
                found += times * ((weights[:, first] @ kernel) * weights[:, second]).sum(axis=1)
        return found


def euclidean(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Squared Euclidean distances [N, M] of histograms [N, R, S] and [M, R, S], as in R2DM."""
    one, other = first.reshape(len(first), -1), second.reshape(len(second), -1)
    squares = (one**2).sum(axis=1)[:, None] + (other**2).sum(axis=1)
    return np.asarray(np.maximum(squares - 2 * one @ other.T, 0.0))


def spectral(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Squared distances [N, M] in the matrix 2-norm, the largest singular value of a difference, as in LiDARGen."""
    return np.stack([np.linalg.norm(histogram - second, ord=2, axis=(1, 2)) ** 2 for histogram in first])


def bev_histogram(points: np.ndarray) -> np.ndarray:
    """Counts f64 [100, 100] of sensor-frame points [N, 3] by x and y in [-80 m, 80 m], for distances of 3 to 70 m."""
    distance = np.linalg.norm(points, axis=1)
    x, y = points[(distance > MIN_DISTANCE) & (distance < MAX_DISTANCE), :2].T
    span = (-HALF_EXTENT, HALF_EXTENT)
    return np.histogram2d(x, y, bins=BINS, range=(span, span))[0]


def histogram_mmd(recorded: np.ndarray, generated: np.ndarray) -> float:
    """Squared maximum mean discrepancy of histograms [N, 100, 100] by `bev_histogram`, each divided by its sum.

    The kernel is Gaussian in the matrix 2-norm (the largest singular value) of the difference of two histograms. The
    means are over all pairs, including a scan with itself.
    """
    discrepancy = KernelDiscrepancy(np.repeat([0, 1], [len(recorded), len(generated)])[None], spectral)
    for number, histogram in enumerate([*recorded, *generated]):
        with named(f"scan {number if number < len(recorded) else number - len(recorded)}"):
            discrepancy.add(histogram)
    return float(discrepancy.distances()[0])


class MatchingDistance:
    """LiDM's minimum matching distance: for each recorded top view, the chamfer distance to the nearest generated one.

    Top views are the occupied cells of a 200 x 200 square of edge 1. The chamfer distance is the mean, over both, of
    the squared distances from the cells of one to the nearest of the other. Keeps 5 kB a scan.
    """

    def __init__(self, sides: np.ndarray) -> None:
        self._sides, self._occupied = sides, list[np.ndarray]()

    def add(self, measured: np.ndarray) -> None:
        """Add the indices [M] of the occupied cells of a scan, row by row."""
        if not len(measured):
            raise LidarDraftError("no point lies in the top view")
        occupied = np.zeros(_CELLS**2, dtype=bool)
        occupied[measured] = True
        self._occupied.append(np.packbits(occupied))

    def distances(self) -> np.ndarray:
        """The distance of each comparison, f64 [C]."""
        nearest = np.full(self._sides.shape, np.inf)
        for at in range(0, len(self._occupied), _HELD * _BLOCK):
            generated = np.arange(at, min(at + _HELD * _BLOCK, len(self._occupied)))
            generated = generated[(self._sides[:, generated] == 1).any(axis=0)]
            asked = (self._sides[:, generated] == 1).any(axis=1)  # comparisons
            recorded = np.flatnonzero((self._sides[asked] == 0).any(axis=0))
            if len(generated):
                others = self._loaded(generated)
                for part, _ in _blocks(len(recorded), 1):
                    rows = recorded[part]
                    distances = _chamfer(self._loaded(rows), others)
                    for comparison in np.flatnonzero(asked):
                        least = distances[:, self._sides[comparison, generated] == 1].min(axis=1)
                        nearest[comparison, rows] = np.minimum(nearest[comparison, rows], least)
        return np.array([near[side == 0].mean() for near, side in zip(nearest, self._sides, strict=True)])

    def _loaded(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Occupancy f32 [K, 40000] of scans, and the squared distance of each cell to the nearest occupied one."""
        from scipy.ndimage import distance_transform_edt

        occupied = np.unpackbits(np.stack([self._occupied[number] for number in numbers]), axis=1).astype(np.float32)
        free = occupied.reshape(-1, _CELLS, _CELLS) == 0
        return occupied, np.stack([(distance_transform_edt(scan) ** 2).astype(np.float32).ravel() for scan in free])


def _chamfer(first: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Chamfer distances [N, M]: since each cell has its distance to each top view, they are products of matrices."""
    (one, to_one), (other, to_other) = first, second
    there, back = one @ to_other.T / one.sum(axis=1)[:, None], to_one @ other.T / other.sum(axis=1)
    return (there + back).astype(np.float64) / (2 * _CELLS**2)


class FrechetDistance:
    """Frechet distance of Gaussians fitted to features [D], with unbiased covariances. Keeps 4 bytes a feature."""

    def __init__(self, sides: np.ndarray) -> None:
        self._sides, self._features = sides, list[np.ndarray]()

    def add(self, measured: np.ndarray) -> None:
        """Add the features [D] of a scan."""
        self._features.append(measured.astype(np.float32))

    def distances(self) -> np.ndarray:
        """The distance of each comparison, f64 [C]."""
        features = np.stack(self._features)
        return np.array([_frechet(*(features[side == k].astype(np.float64) for k in (0, 1))) for side in self._sides])


def _frechet(first: np.ndarray, second: np.ndarray) -> float:
    """The distance of features [N, D] and [M, D].

    A and B are both without their means, divided by the square roots of N - 1 and M - 1. The trace of the root of the
    product of the covariances is the sum of the singular values of A B^T: no root of a [D, D] matrix is needed.
    """
    if min(len(first), len(second)) < 2:
        raise LidarDraftError("a Frechet distance needs two scans at least on each side")
    centred = [(x - x.mean(axis=0)) / np.sqrt(len(x) - 1) for x in (first, second)]
    reduced = [np.asarray(np.linalg.qr(x, mode="r")) if len(x) > x.shape[1] else x for x in centred]
    spread = sum(float((x**2).sum()) for x in centred) - 2 * np.linalg.norm(reduced[0] @ reduced[1].T, ord="nuc")
    return float(((first.mean(axis=0) - second.mean(axis=0)) ** 2).sum() + spread)


def _blocks(rows: int, columns: int) -> Iterator[tuple[slice, slice]]:
    """The parts of a table of pairs that are compared at once."""
    for row in range(0, rows, _BLOCK):
        for column in range(0, columns, _BLOCK):
            yield slice(row, min(row + _BLOCK, rows)), slice(column, min(column + _BLOCK, columns))
