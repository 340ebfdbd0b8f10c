"""The lasers of a unit: where each of them starts and how high it looks.

All returns of a laser lie on a cone about the axis of the head: z = height + distance from the axis x tan(elevation).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.formats.recording import Recording
from lidardraft.metrics.sweep import firing_step

_MOST_POINTS = 40_000  # of a laser: more say nothing new
_FEWEST_POINTS = 20
_SCALE = 0.005  # m off the cone, beyond which a return counts less (Cauchy): a motion, a shake of the head
_ROUNDS = 12
_ALIKE_HEIGHTS = 0.012  # m
_FINEST = 1e-3  # m: no recording is less noisy
_ALIKE = 0.5  # length of the mean direction of a laser's firings, seen from their columns
_SURE = 0.005  # m: a height less sure than this is that of the nearest laser whose is


@dataclass(frozen=True)
class BeamTable:
    """Lasers from the highest: `elevations` and `azimuth_offsets` [rad], `heights` over the sensor's origin [m], and
    the numbers `rings` that the recording has for them.

    `columns` is the number of firings in a turn, `residual` the root mean square distance of returns from their cones
    [m], `angle_residual` the same over their distance [rad]. Azimuth offsets are known where firings are numbered, else
    0.
    """

    elevations: np.ndarray
    heights: np.ndarray
    azimuth_offsets: np.ndarray
    rings: np.ndarray
    columns: int
    residual: float
    angle_residual: float

    def rows(self, recording: Recording) -> np.ndarray:
        """The row of each point, i64 [N]; raises `FormatError` for a ring that the table does not have."""
        row = np.full(int(max(self.rings.max(), recording.ring.max())) + 1, -1)
        row[self.rings] = np.arange(len(self.rings))
        rows: np.ndarray = row[recording.ring]
        if (rows < 0).any():
            ring = recording.ring[rows < 0][0]
            raise FormatError(f"{recording.name} has a ring {ring}, which the other scans do not have")
        return rows


def fit_beam_table(recordings: Sequence[Recording]) -> BeamTable:
    """The lasers of recordings of one unit. Raises `FormatError` where a laser has too few returns to say."""
    rings = np.unique(np.concatenate([np.unique(r.ring) for r in recordings]))
    returns = [_returns(recordings, int(ring)) for ring in rings]
    elevations, heights, unsure = np.array([_cone(*one) for one in returns]).T
    if (unsure <= _SURE).any():  # a laser whose returns all lie at one distance starts where the nearest one does
        sure = np.where(unsure <= _SURE, elevations, np.inf)
        slopes = [math.atan(float(np.median(z / out))) for out, z in returns]
        heights = np.array([heights[np.argmin(np.abs(sure - slope))] if u > _SURE else h
                            for h, u, slope in zip(heights, unsure, slopes, strict=True)])  # fmt: skip
    else:
        heights = np.zeros(len(rings))
    heights = _grouped(heights)
    elevations = np.array(
        [math.atan(float(np.median((z - h) / out))) for (out, z), h in zip(returns, heights, strict=True)]
    )
    off = [
        (z - h) * math.cos(e) - out * math.sin(e) for (out, z), h, e in zip(returns, heights, elevations, strict=True)
    ]
    angles = [one / np.maximum(np.hypot(out, z), 1.0) for one, (out, z) in zip(off, returns, strict=True)]
    order = np.argsort(-elevations, kind="stable")
    if (np.diff(elevations[order]) >= 0).any():
        raise FormatError("two lasers have the same elevation; their rings are not those of one unit")
    columns = _columns(recordings)
    return BeamTable(
        elevations=elevations[order],
        heights=heights[order],
        azimuth_offsets=_azimuth_offsets(recordings, rings[order], columns),
        rings=rings[order],
        columns=columns,
        residual=_rms(np.concatenate(off)),
        angle_residual=_rms(np.concatenate(angles)),
    )


def _returns(recordings: Sequence[Recording], ring: int) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the axis and height of a laser's returns, f64 [N]; raises `FormatError` where there are few."""
    points = np.concatenate([r.points[r.ring == ring] for r in recordings]).astype(np.float64)
    if len(points) < _FEWEST_POINTS:
        raise FormatError(f"ring {ring} has {len(points)} returns; a laser needs {_FEWEST_POINTS} to be fitted")
    points = points[:: max(1, len(points) // _MOST_POINTS)]
    return np.maximum(np.hypot(points[:, 0], points[:, 1]), 1e-3), points[:, 2]


def _grouped(heights: np.ndarray) -> np.ndarray:
    """Heights with one value for those that lie within _ALIKE_HEIGHTS: lasers of one height are cast together, which
    takes half the time."""
    grouped, order = heights.copy(), np.argsort(heights)
    start = 0
    for end in range(1, len(order) + 1):
        if end == len(order) or heights[order[end]] - heights[order[start]] > _ALIKE_HEIGHTS:
            group = order[start:end]
            grouped[group] = (heights[group].min() + heights[group].max()) / 2
            start = end
    return grouped


def _cone(out: np.ndarray, z: np.ndarray) -> tuple[float, float, float]:
    """Elevation [rad], height and its standard error [m], by reweighted least squares."""
    design = np.stack([out, np.ones_like(out)], axis=1)
    weight = np.ones_like(out)
    for _ in range(_ROUNDS):
        solution, *_ = np.linalg.lstsq(design * weight[:, None], z * weight, rcond=None)
        weight = 1.0 / np.sqrt(1.0 + ((z - design @ solution) / _SCALE) ** 2)
    left = max(_rms((z - design @ solution) * weight), _FINEST)
    error = left / max(_rms(out - out.mean()), 1e-9) * _rms(out) / math.sqrt(len(out))
    return math.atan(solution[0]), float(solution[1]), error


def _azimuth_offsets(recordings: Sequence[Recording], rings: np.ndarray, columns: int) -> np.ndarray:
    """By how much each laser looks further to the left than the mean of all, where firings are numbered [rad]."""
    turned, returns = np.zeros(len(rings), dtype=complex), np.zeros(len(rings))
    for recording in recordings:
        if recording.column is None:
            return np.zeros(len(rings))
        ahead = np.exp(1j * (_azimuths(recording) + 2 * np.pi * (recording.column + 0.5) / columns - np.pi))
        for row, ring in enumerate(rings):
            mine = ahead[recording.ring == ring]
            turned[row] += mine.sum()
            returns[row] += len(mine)
    if (np.abs(turned) < _ALIKE * returns).any():  # columns that are no firings, or count the other way
        return np.zeros(len(rings))
    offsets = np.angle(turned)
    middle = np.angle(np.exp(1j * offsets).mean())
    found: np.ndarray = np.angle(np.exp(1j * (offsets - middle)))
    return found


def _columns(recordings: Sequence[Recording]) -> int:
    """Firings in a turn, by the step from one to the next."""
    steps = []
    for recording in recordings:
        turned = -_azimuths(recording) % (2 * np.pi)
        if recording.column is None:
            steps.append(firing_step(turned, recording.ring))
            continue
        order = np.lexsort((recording.column, recording.ring))
        firings = np.diff(recording.column[order])
        same = (np.diff(recording.ring[order]) == 0) & (firings > 0) & (firings < 8)
        step = np.angle(np.exp(1j * np.diff(turned[order])))[same] / firings[same]
        steps.append(abs(float(np.median(step))) if len(step) else math.inf)
    if not math.isfinite(max(steps)) or not min(steps) > 0:
        raise FormatError("no laser has two returns side by side; the step between firings is unknown")
    return round(2 * math.pi / float(np.median(steps)))


def _azimuths(recording: Recording) -> np.ndarray:
    azimuths: np.ndarray = np.arctan2(recording.points[:, 1], recording.points[:, 0]).astype(np.float64)
    return azimuths


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
