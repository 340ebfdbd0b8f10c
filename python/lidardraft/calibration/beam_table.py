"""The lasers of a unit: their origins and elevations, the offsets of their ranges, and views that the vehicle hides.

All returns of a laser lie on a cone about the axis of the head: z = height + distance from the axis x tan(elevation).
A laser with a range offset puts its returns before or behind the plane that its neighbours see. An offset that a whole
block has in common bends no plane, and stays 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.formats.recording import Recording
from lidardraft.metrics.sweep import Sweep, firing_step
from lidardraft.scene.sensor import Blocked

_MOST_POINTS = 20_000  # of a laser: more add no information
FEWEST_POINTS = 20
_COUNTED = 12  # scans whose firings are counted
_SCALE = 0.005  # m off the cone, beyond which a return counts less (Cauchy): motion, or shakes of the head
_ROUNDS = 12
_DRAWN = 1e-9
_ALIKE_HEIGHTS = 0.012  # m
_FINEST = 1e-3  # m: no recording is less noisy
_ALIKE = 0.5  # length of the mean direction of a laser's firings against their columns, at least
_SURE = 0.005  # m: a laser with a less certain height takes that of the nearest certain one


@dataclass(frozen=True)
class BeamTable:
    """Lasers from the highest: `elevations` and `azimuth_offsets` [rad], `heights` over the sensor's origin [m], and
    their numbers `rings` in the recording.

    `columns` is the number of firings in a turn, `residual` the root mean square distance of returns from their cones
    [m], `angle_residual` the same over their distance [rad]. Azimuth offsets are known if firings are numbered, else
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
        """The row of each point, i64 [N]; raises `FormatError` for a ring that is not in the table."""
        row = np.full(int(max(self.rings.max(), recording.ring.max())) + 1, -1)
        row[self.rings] = np.arange(len(self.rings))
        rows: np.ndarray = row[recording.ring]
        if (rows < 0).any():
            ring = recording.ring[rows < 0][0]
            raise FormatError(f"{recording.name} has a ring {ring}, which the other scans do not have")
        return rows


def fit_beam_table(recordings: Sequence[Recording]) -> BeamTable:
    """The lasers of recordings of one unit. Raises `FormatError` if a laser has too few returns."""
    rings, laser, out, z = returns_of_lasers(recordings, _MOST_POINTS)
    counts = np.bincount(laser)
    for few in np.flatnonzero(counts < FEWEST_POINTS)[:1]:
        raise FormatError(f"ring {rings[few]} has {counts[few]} returns; a laser needs {FEWEST_POINTS} to be fitted")
    ends = np.cumsum(counts)[:-1]
    elevations, heights, unsure = cones(laser, out, z)
    if (unsure <= _SURE).any():  # a laser whose returns all lie at one distance gets the height of the nearest one
        sure = np.where(unsure <= _SURE, elevations, np.inf)
        slopes = np.arctan(_medians(z / out, ends))
        nearest = np.argmin(np.abs(sure - slopes[:, None]), axis=1)
        heights = np.where(unsure > _SURE, heights[nearest], heights)
    else:
        heights = np.zeros(len(rings))
    heights = _grouped(heights)
    elevations = np.arctan(_medians((z - heights[laser]) / out, ends))
    off = off_cones(laser, out, z, elevations, heights)
    order = np.argsort(-elevations, kind="stable")
    if (np.diff(elevations[order]) >= 0).any():
        raise FormatError("two lasers have the same elevation; their rings are not those of one unit")
    columns = _columns(recordings[:: max(1, len(recordings) // _COUNTED)])
    return BeamTable(
        elevations=elevations[order],
        heights=heights[order],
        azimuth_offsets=_azimuth_offsets(recordings, rings[order], columns),
        rings=rings[order],
        columns=columns,
        residual=_rms(off),
        angle_residual=_rms(off / np.maximum(np.hypot(out, z), 1.0)),
    )


def returns_of_lasers(recordings: Sequence[Recording], most: int) -> tuple[np.ndarray, ...]:
    """The rings [R] of recordings, ascending, and some `most` returns of each. Of these returns: the index of the ring,
    i64 [N], the distance from the axis and the height [m], f64 [N]."""
    ring = np.concatenate([one.ring for one in recordings])
    counts = np.bincount(ring)
    rings = np.flatnonzero(counts)
    order = np.argsort(ring.astype(np.int16), kind="stable")
    in_ring = np.arange(len(ring)) - np.repeat(np.cumsum(counts) - counts, counts)
    chosen = order[in_ring % np.repeat(np.maximum(1, counts // most), counts) == 0]
    x, y, z = np.concatenate([one.points for one in recordings])[chosen].T.astype(np.float64)
    return rings, np.searchsorted(rings, ring[chosen]), np.maximum(np.hypot(x, y), 1e-3), z


def _medians(values: np.ndarray, ends: np.ndarray) -> np.ndarray:
    return np.array([np.median(part) for part in np.split(values, ends)])


def _grouped(heights: np.ndarray) -> np.ndarray:
    """Heights, with one value for those within _ALIKE_HEIGHTS: lasers of one height are cast together, which takes half
    the time."""
    grouped, order = heights.copy(), np.argsort(heights)
    start = 0
    for end in range(1, len(order) + 1):
        if end == len(order) or heights[order[end]] - heights[order[start]] > _ALIKE_HEIGHTS:
            group = order[start:end]
            grouped[group] = (heights[group].min() + heights[group].max()) / 2
            start = end
    return grouped


def cones(laser: np.ndarray, out: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Elevation [rad], height and its standard error [m] of each laser, f64 [R], by reweighted least squares. The
    inputs [N] are the index of the laser, the distance from the axis and the height of each return."""
    share = np.ones_like(out)
    for _ in range(_ROUNDS):
        n, x, y, xx, xy = (np.bincount(laser, share * each) for each in (np.ones_like(out), out, z, out * out, out * z))
        drawn = _DRAWN * n  # to 0, if all returns lie at one distance
        least = (xx + drawn) * (n + drawn) - x * x
        slope, height = ((n + drawn) * xy - x * y) / least, ((xx + drawn) * y - x * xy) / least
        square = (z - slope[laser] * out - height[laser]) ** 2
        share = 1.0 / (1.0 + square / _SCALE**2)
    count, mean, squares = (np.bincount(laser, each) for each in (np.ones_like(out), out, out * out))
    left = np.maximum(np.sqrt(np.bincount(laser, square * share) / count), _FINEST)
    spread = np.sqrt(np.maximum(squares / count - (mean / count) ** 2, 1e-18))
    return np.arctan(slope), height, left / spread * np.sqrt(squares) / count


def off_cones(
    laser: np.ndarray, out: np.ndarray, z: np.ndarray, elevations: np.ndarray, heights: np.ndarray
) -> np.ndarray:
    """The distances of returns above the cones of their lasers [N], m."""
    return (z - heights[laser]) * np.cos(elevations)[laser] - out * np.sin(elevations)[laser]


def _azimuth_offsets(recordings: Sequence[Recording], rings: np.ndarray, columns: int) -> np.ndarray:
    """The azimuth of each laser left of the mean of all [rad]; 0 if firings are not numbered."""
    count = int(rings.max()) + 1
    turned, returns = np.zeros(count, dtype=complex), np.zeros(count)
    for recording in recordings:
        if recording.column is None:
            return np.zeros(len(rings))
        ahead = _azimuths(recording) + 2 * np.pi * (recording.column + 0.5) / columns - np.pi
        turned += np.bincount(recording.ring, np.cos(ahead), count)
        turned += 1j * np.bincount(recording.ring, np.sin(ahead), count)
        returns += np.bincount(recording.ring, minlength=count)
    turned, returns = turned[rings], returns[rings]
    if (np.abs(turned) < _ALIKE * returns).any():  # columns that are not firings, or count the other way
        return np.zeros(len(rings))
    offsets = np.angle(turned)
    middle = np.angle(np.exp(1j * offsets).mean())
    found: np.ndarray = np.angle(np.exp(1j * (offsets - middle)))
    return found


def _columns(recordings: Sequence[Recording]) -> int:
    """The number of firings in a turn, from the step between two."""
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


_LASERS, _FIRINGS, _STRIDE = 8, 16, 4  # of a patch, and lasers between two patches
_FILLED = 0.9  # of a patch
_FARTHEST = 30.0  # m
_FLAT = 0.03  # m off the plane, along the rays: the median of a patch
_STEEPEST = 0.05  # cosine of incidence: at more grazing ones millimetres of height are centimetres of range
_FEWEST = 20  # patches of a laser
_MOST_PATCHES = 20_000
_PLANE_ROUNDS = 5
_MOST = 0.2  # m


def fit_range_offsets(recorded: Sequence[Sweep], table: BeamTable) -> np.ndarray:
    """The range offset of each laser [H], m; 0 for lasers that saw too few flat surfaces."""
    origins = np.stack([np.zeros_like(table.heights), np.zeros_like(table.heights), table.heights], axis=1)
    offsets = np.zeros(len(table.heights))
    if len(offsets) < _LASERS:
        return offsets
    patches, lasers = (some[:: max(1, len(some) // _MOST_PATCHES)] for some in _patches(recorded))
    if not len(patches):
        return offsets
    rays = patches - origins[lasers][:, :, None]
    rays /= np.maximum(np.linalg.norm(rays, axis=3, keepdims=True), 1e-6)
    for _ in range(_PLANE_ROUNDS):
        off, flat = _off_plane(patches - offsets[lasers][:, :, None, None] * rays, rays)
        for laser in range(len(offsets)):
            found = off[(lasers == laser) & flat[:, None]]
            if len(found) >= _FEWEST:
                offsets[laser] += np.median(found)
    return np.clip(offsets, -_MOST, _MOST)


def _patches(recorded: Sequence[Sweep]) -> tuple[np.ndarray, np.ndarray]:
    """Points [N, _LASERS, _FIRINGS, 3] of filled, near patches, and their lasers [N, _LASERS]."""
    found, lasers = [], []
    for sweep in recorded:
        height, width = sweep.depth.shape
        there = (sweep.depth > 0) & (sweep.depth < _FARTHEST)
        for row in range(0, height - _LASERS + 1, _STRIDE):
            rows, columns = slice(row, row + _LASERS), width - width % _FIRINGS
            filled = there[rows, :columns].reshape(_LASERS, -1, _FIRINGS).mean(axis=(0, 2)) >= _FILLED
            points = sweep.points[rows, :columns].reshape(_LASERS, -1, _FIRINGS, 3).transpose(1, 0, 2, 3)[filled]
            found.append(points.astype(np.float64))
            lasers.append(np.broadcast_to(np.arange(row, row + _LASERS), (len(points), _LASERS)))
    return np.concatenate(found), np.concatenate(lasers)


def _off_plane(points: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The range of each laser beyond the plane of its patch [N, _LASERS], m, and the mask [N] of flat patches."""
    shape, points, rays = points.shape[:3], *(each.reshape(len(each), -1, 3) for each in (points, rays))
    weight, drawn = np.ones(points.shape[:2]), 1e-9 * np.eye(3)
    for _ in range(3):
        # planes are n p = 1: no ray sees those through the sensor
        weighted = points * weight[..., None]
        normal = np.linalg.solve(points.transpose(0, 2, 1) @ weighted + drawn, weighted.sum(axis=1)[..., None])
        along = (rays @ normal)[..., 0]
        off = ((points @ normal)[..., 0] - 1.0) / np.where(np.abs(along) > 1e-6, along, 1e-6)
        weight = 1.0 / (1.0 + (off / _FLAT) ** 2)
    steep = np.median(along, axis=1) / np.linalg.norm(normal[..., 0], axis=1)
    flat: np.ndarray = (np.median(np.abs(off), axis=1) < _FLAT) & (steep > _STEEPEST)
    return np.median(off.reshape(shape), axis=2), flat


_DOWN = math.radians(-5.0)  # the road is near there and returns
_SELDOM = 0.1  # a firing that returns less often is hidden
_ASIDE = 3  # columns to either side of each in a median: one dropped firing is not a vehicle
_WIDE = math.radians(2.0)  # holes narrower than this are not a vehicle
_OWN = 0.5  # of the way to the road: nearer returns may be of the vehicle itself
_OWN_REACH, _STEADY = 2.2, 0.05  # m: limit of such returns, and the scatter of their ranges, as they move with it
_FEWEST_SWEEPS = 5  # of different places, so that other things do not look steady


def fit_blocked(sweeps: Sequence[Sweep], elevations: np.ndarray, height: float) -> Blocked:
    """The hidden intervals of azimuth [rad] of each beam, from sweeps whose columns are azimuths from behind to the
    right; empty if none is hidden. The sensor is at a `height` [m] over the road.

    The vehicle hides views without returns and, if there are enough sweeps, views with returns of itself.
    """
    valid = np.array([sweep.valid for sweep in sweeps])
    rate = np.mean(valid & ~_own(sweeps, elevations, height), axis=0)
    columns = rate.shape[1]
    around = np.pad(rate, ((0, 0), (_ASIDE, _ASIDE)), mode="wrap")
    windows = np.lib.stride_tricks.sliding_window_view(around, 2 * _ASIDE + 1, axis=1)
    hidden = np.median(windows, axis=2) < _SELDOM
    hidden &= (elevations[:, None] < _DOWN) | hidden.all(axis=0)  # all beams hidden: outside the field of view
    found = tuple(tuple(_intervals(row, columns)) if row.any() else () for row in hidden)
    return found if any(found) else ()


def _own(sweeps: Sequence[Sweep], elevations: np.ndarray, height: float) -> np.ndarray:
    """The returns of the vehicle, bool [N, H, W]: nearer than the road by far, and at one place in all sweeps."""
    depth = np.array([sweep.depth for sweep in sweeps])
    out = np.array([np.hypot(sweep.points[..., 0], sweep.points[..., 1]) for sweep in sweeps])
    reach = np.minimum(_OWN * height / np.tan(np.maximum(-elevations, _DRAWN)), _OWN_REACH)
    near = (depth > 0) & (out < reach[:, None])
    count = np.maximum(near.sum(axis=0), 1)
    mean = (depth * near).sum(axis=0) / count
    scatter = np.sqrt((np.square(depth - mean) * near).sum(axis=0) / count)
    own: np.ndarray = near & (scatter < _STEADY) & (len(sweeps) >= _FEWEST_SWEEPS)
    return own


def _intervals(hidden: np.ndarray, columns: int) -> list[tuple[float, float]]:
    """Runs of a row's hidden columns around the full turn, as azimuths; columns count to the right, azimuths to the
    left."""
    step = 2 * math.pi / columns
    if hidden.all():
        return [(-math.pi, math.pi)]
    first = int(np.argmin(hidden))  # an open column: no run crosses the seam from there
    changes = np.diff(np.concatenate([[0], np.roll(hidden, -first).astype(np.int8), [0]]))
    starts, ends = np.flatnonzero(changes == 1) + first, np.flatnonzero(changes == -1) + first
    runs = [(start, end) for start, end in zip(starts, ends, strict=True) if (end - start) * step >= _WIDE]
    return [(math.pi - float(end) * step, math.pi - float(start) * step) for start, end in runs]
