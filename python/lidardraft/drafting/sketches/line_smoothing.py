"""Lines of a hand without its wobble: points evenly apart, smoothed along the line, their ends in place."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

_MOST_POINTS = 10_000


def resampled(points: np.ndarray, step: float) -> tuple[np.ndarray, float]:
    """At least four points along a polyline [N, 2], evenly apart by about a step; and how far that is."""
    off = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(off)])
    kept = np.concatenate([[True], off > 0])
    count = max(4, min(_MOST_POINTS, math.ceil(along[-1] / step) + 1))
    places = np.linspace(0.0, along[-1], count)
    line = np.stack([np.interp(places, along[kept], points[kept, axis]) for axis in (0, 1)], axis=1)
    return line, max(float(along[-1]) / (count - 1), 1e-9)


def smooth(line: np.ndarray, deviation: float, closed: bool) -> np.ndarray:
    """A line [N, 2] convolved with a Gaussian of a standard deviation in points."""
    padded, more = _continued(line, math.ceil(4 * deviation), closed)
    wide = ndimage.gaussian_filter1d(padded, max(deviation, 1e-6), axis=0)
    return _ended(wide[more : more + len(line)], closed)


def without_bumps(line: np.ndarray, window: int, closed: bool) -> np.ndarray:
    """A line [N, 2] whose places are medians of an odd number of points: what is shorter than half of it is gone."""
    padded, more = _continued(line, window // 2, closed)
    wide = ndimage.median_filter(padded, size=(window, 1))
    return _ended(wide[more : more + len(line)], closed)


def _continued(line: np.ndarray, more: int, closed: bool) -> tuple[np.ndarray, int]:
    """The line with up to `more` points before and behind it, and their number: it goes round, or is turned about its
    ends, so that these stay where they are."""
    more = min(len(line) - 1, more)
    if closed:
        ring = line[:-1]
        return np.concatenate([ring[len(ring) - more :], line, ring[1 : 1 + more]]), more
    begin, end = 2 * line[0] - line[more:0:-1], 2 * line[-1] - line[-2 : -2 - more : -1]
    return np.concatenate([begin, line, end]), more


def _ended(line: np.ndarray, closed: bool) -> np.ndarray:
    return np.concatenate([line[:-1], line[:1]]) if closed else line
