"""The intensity curve of a unit: simulated streets get the quantiles of its recorded readings.

No data sheet gives the reading of an echo. But the returns of a cell (one group, laser and range bin) have the same
ranks in recorded readings as in the responses of simulated streets. So quantiles of cells are matched, in logarithms
of responses, in four steps:

1. `_fit_shared`: one curve for all lasers, a gain for each range bin, a gain and an offset for each laser.
2. `_own_curves` and `_own_focus`: a curve and range gains for each laser, near the shared ones if it has few returns.
3. `_raised_cutoffs`: the least reading over 0 of a laser is its cut-off, or up to twice that if it reads 0 more often.
4. Responses ten times those of nearly all returns read as the brightest recorded ones: retroreflectors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.calibration.surface_groups import groups_of
from lidardraft.errors import FormatError
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor_model import IntensityCurve

_RANGE_EDGES = np.array([2.0, 5.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0, 50.0, 65.0, 80.0, 120.0])  # m
_DISTANCES = np.sqrt(_RANGE_EDGES[1:] * _RANGE_EDGES[:-1])  # m, one for each range bin
_REFERENCE = 2  # the range bin whose gain is 1
_FEWEST = 100  # returns of a cell
_MOST = 2000  # returns of a cell that count
_LEVELS = np.linspace(0.025, 0.975, 20)  # of the quantiles
_KNOTS = 16
_LOWEST = -1.0  # reading of a curve, with its offset
# Logarithms of gains to try: of a laser, of a range bin, and of one laser's range bin beside the shared gain.
_GAINS = np.linspace(-2.0, 2.0, 81)
_FOCUS = np.linspace(-3.0, 1.5, 91)
_OWN_FOCUS = np.linspace(-1.5, 1.5, 61)
_MOST_OFFSET = 0.4
_PRIOR = 0.005 * _FEWEST * len(_LEVELS)  # weight that draws gains towards 1 and offsets to 0
_SHARED_RETURNS = 150.0  # at each knot, the weight of the shared curve against a laser's own
_ROUNDS, _OWN_ROUNDS, _FOCUS_ROUNDS = 12, 3, 2
_CUTOFF_SHARE = 0.005  # share of a laser's readings over 0 below its cut-off: outliers
_MOST_RAISED = 2.0  # times the recorded cut-off
_NO_ZEROS = 0.002  # a laser that reads 0 less often has no cut-off
_BRIGHTER = math.log(10.0)  # than all but 3 of 1000 returns: retroreflectors, which have no cells
_BRIGHTEST_SHARE = 0.9999  # share of the readings below those of retroreflectors


@dataclass(frozen=True)
class Cells:
    """Quantiles of C cells with recorded and simulated returns."""

    laser: np.ndarray  # i64 [C]
    range_bin: np.ndarray  # i64 [C], index of _DISTANCES
    response: np.ndarray  # logarithms of simulated responses [C, Q]
    reading: np.ndarray  # recorded [C, Q]
    weight: np.ndarray  # [C, 1], roots of returns
    cutoff: np.ndarray  # [C, 1], of the laser

    def of_laser(self, laser: int) -> Cells:
        """The cells of one laser."""
        mine = self.laser == laser
        return Cells(*(values[mine] for values in vars(self).values()))

    def imputed(self, shown: np.ndarray) -> np.ndarray:
        """The readings [C, Q]; those of 0, only known to be below the cut-off, become `shown`, up to that."""
        return np.where(self.reading > 0, self.reading, np.minimum(shown, self.cutoff))


@dataclass(frozen=True)
class SharedCurve:
    """Readings by strength, the logarithm of a response with its gains: `reading` at `strength` [K]. Each laser [H] has
    `gains` (logarithms) and `offsets`, each range bin [D] has `focus` (logarithms of gains)."""

    strength: np.ndarray
    reading: np.ndarray
    gains: np.ndarray
    offsets: np.ndarray
    focus: np.ndarray


@dataclass(frozen=True, eq=False)
class Readings:
    """The statistics of recorded sweeps' readings, which are fixed while a sensor is fitted to them.

    `cells` are quantiles and counts by group, range and laser; groups are classes if all sweeps are `labelled`. Each
    laser [H] has `cutoffs`, its least reading over 0, or 0 if it hardly ever reads 0, and `zeros`, its share of zeros.
    `most` is the brightest reading.
    """

    cells: dict[int, tuple[np.ndarray, int]]
    labelled: bool
    cutoffs: np.ndarray
    zeros: np.ndarray
    most: float

    @classmethod
    def from_sweeps(cls, recorded: Sequence[Sweep]) -> Readings:
        """From sweeps of one unit, all with intensities."""
        labelled = all(sweep.label is not None for sweep in recorded)
        by_laser = [_of_laser(recorded, row)[0] for row in range(len(recorded[0].points))]
        zeros = np.array([(read == 0).mean() if len(read) else 0.0 for read in by_laser])
        most = float(np.quantile(np.concatenate(by_laser), _BRIGHTEST_SHARE))
        return cls(_by_cell(recorded, labelled), labelled, np.array([*map(_cutoff, by_laser)]), zeros, most)


def _of_laser(sweeps: Sequence[Sweep], row: int) -> tuple[np.ndarray, np.ndarray]:
    """The intensities and ranges of all returns of a laser."""
    there = [(sweep.valid[row], sweep.intensity, sweep.depth) for sweep in sweeps if sweep.intensity is not None]
    intensity, depth = zip(*((read[row][seen], depth[row][seen]) for seen, read, depth in there), strict=True)
    return np.concatenate(intensity), np.concatenate(depth)


def _cutoff(read: np.ndarray) -> float:
    above = read[read > 0]
    none = len(above) < _FEWEST or len(above) > (1 - _NO_ZEROS) * len(read)
    return 0.0 if none else float(np.quantile(above, _CUTOFF_SHARE))


@dataclass(frozen=True)
class IntensityFit:
    """The fitted curve, and the root mean square residual between quantiles, of 1."""

    curve: IntensityCurve
    residual: float


def fit_intensity(recorded: Readings, simulated: Sequence[Sweep]) -> IntensityFit:
    """The curve with which simulated sweeps, whose intensities are responses, read as the recorded ones.

    Returns are grouped by class if all recorded sweeps have labels, else by place and shape (`surface_groups.py`).
    """
    cells, lasers = _cells(recorded, simulated), len(recorded.cutoffs)
    if not len(cells.laser):
        raise FormatError(f"no laser has {_FEWEST} returns of one kind at one distance; intensities need more scans")
    shared = _fit_shared(cells, lasers)
    strength = cells.response + shared.focus[cells.range_bin][:, None]
    knots = _knots(strength)
    start = np.array([np.interp(knots + gain, shared.strength, shared.reading) for gain in shared.gains])
    start -= shared.offsets[:, None]
    focus = np.tile(shared.focus, (lasers, 1))
    readings, shown = _own_curves(cells, strength, knots, start)
    for _ in range(_FOCUS_ROUNDS):
        focus = shared.focus + _own_focus(cells, strength, cells.imputed(shown), knots, readings)
        own = cells.response + focus[cells.laser, cells.range_bin][:, None]
        readings, shown = _own_curves(cells, own, knots, start)
    cutoffs = _raised_cutoffs(recorded, simulated, focus, knots, readings)
    left = np.where(shown < cutoffs[cells.laser][:, None], 0.0, shown) - cells.reading
    share = np.broadcast_to(cells.weight**2, left.shape)
    curve = _intensity_curve(knots, readings, focus, cutoffs, recorded.most)
    return IntensityFit(curve, math.sqrt(float((share * left**2).sum() / share.sum())))


def _fit_shared(cells: Cells, lasers: int) -> SharedCurve:
    """The shared curve, fitted in turns with its gains and offsets."""
    gains, offsets, focus = np.zeros(lasers), np.zeros(lasers), np.zeros(len(_DISTANCES))
    known = cells.reading
    for _ in range(_ROUNDS):
        gain, offset = gains[cells.laser][:, None], offsets[cells.laser][:, None]
        own = cells.response + focus[cells.range_bin][:, None] + gain
        knots = _knots(own)
        reading = _monotone(own, known + offset, cells.weight, knots)
        curve = knots, reading
        focus, _ = _shifts(
            cells.response + gain, known + offset, cells.weight, cells.range_bin, curve, _FOCUS, len(focus)
        )
        focus -= focus[_REFERENCE]
        strength = cells.response + focus[cells.range_bin][:, None]
        gains, offsets = _shifts(strength, known, cells.weight, cells.laser, curve, _GAINS, lasers, _MOST_OFFSET)
        shown = np.interp(strength + gains[cells.laser][:, None], *curve) - offsets[cells.laser][:, None]
        known = cells.imputed(shown)
    return SharedCurve(knots, reading, gains, offsets, focus)


def _intensity_curve(
    knots: np.ndarray, readings: np.ndarray, focus: np.ndarray, cutoffs: np.ndarray, most: float
) -> IntensityCurve:
    """The curves [H, K] at `knots` [K], continued to the brightest, as an `IntensityCurve`."""
    knots = np.append(knots, knots[-1] + _BRIGHTER)
    readings = np.column_stack([readings, np.full(len(readings), most)])
    return IntensityCurve(
        responses=tuple(np.exp(knots).tolist()),
        readings=tuple(map(tuple, np.clip(np.maximum.accumulate(readings, axis=1), 0.0, 1.0).tolist())),
        distances=tuple(_DISTANCES.tolist()),
        distance_gains=tuple(map(tuple, np.exp(focus).tolist())),
        cutoffs=tuple(cutoffs.tolist()),
    )


def _cells(recorded: Readings, simulated: Sequence[Sweep]) -> Cells:
    readings, responses, lasers = recorded.cells, _by_cell(simulated, recorded.labelled), len(recorded.cutoffs)
    both = sorted(set(readings) & set(responses))
    laser = np.array([key % lasers for key in both], dtype=np.int64)
    return Cells(
        laser=laser,
        range_bin=np.array([key // lasers % len(_DISTANCES) for key in both]),
        response=np.log(np.maximum([responses[key][0] for key in both], 1e-5)),
        reading=np.array([readings[key][0] for key in both]),
        weight=np.sqrt([min(readings[key][1], responses[key][1], _MOST) for key in both]).reshape(-1, 1),
        cutoff=recorded.cutoffs[laser][:, None],
    )


def _by_cell(sweeps: Sequence[Sweep], labelled: bool) -> dict[int, tuple[np.ndarray, int]]:
    """Quantiles of intensities, and their count, for each cell with enough returns."""
    keys, found = [], []
    for sweep in sweeps:
        assert sweep.intensity is not None
        bins = np.digitize(sweep.depth, _RANGE_EDGES) - 1
        inside = sweep.valid & (bins >= 0) & (bins < len(_DISTANCES))
        rows = np.broadcast_to(np.arange(len(bins))[:, None], bins.shape)
        keys.append(((groups_of(sweep, labelled) * len(_DISTANCES) + bins) * len(bins) + rows)[inside])
        found.append(sweep.intensity[inside])
    key, value = np.concatenate(keys), np.concatenate(found)
    order = np.argsort(key, kind="stable")
    names, starts = np.unique(key[order], return_index=True)
    pieces = zip(names.tolist(), np.split(order, starts[1:]), strict=True)
    return {name: (np.quantile(value[p], _LEVELS), len(p)) for name, p in pieces if len(p) >= _FEWEST}


def _raised_cutoffs(
    recorded: Readings, simulated: Sequence[Sweep], focus: np.ndarray, knots: np.ndarray, curves: np.ndarray
) -> np.ndarray:
    """Cut-offs with which as many simulated readings of each laser are 0 as recorded ones, up to twice as high."""
    found = recorded.cutoffs.copy()
    for laser in np.flatnonzero(found).tolist():
        response, distance = _of_laser(simulated, laser)
        if len(response) >= _FEWEST:
            strength = np.log(np.maximum(response, 1e-5)) + np.interp(distance, _DISTANCES, focus[laser])
            shown = np.interp(strength, knots, curves[laser])
            raised = np.quantile(shown, recorded.zeros[laser])
            found[laser] = np.clip(raised, found[laser], _MOST_RAISED * found[laser])
    return found


def _knots(strength: np.ndarray) -> np.ndarray:
    """Strengths [K] of the knots of a curve, over nearly all strengths."""
    low, high = np.quantile(strength, (0.003, 0.997))
    return np.linspace(float(low), float(high), _KNOTS)


def _own_curves(
    cells: Cells, strength: np.ndarray, knots: np.ndarray, shared: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A curve of each laser [H, K] near the `shared` one, and its readings in the cells [C, Q]."""
    curves, shown = shared.copy(), np.empty_like(strength)
    strong = np.full(len(knots), math.sqrt(_SHARED_RETURNS * len(_LEVELS)))
    for laser in np.unique(cells.laser):
        mine, own = cells.of_laser(laser), strength[cells.laser == laser]
        at, weight = np.r_[own.ravel(), knots], np.r_[np.broadcast_to(mine.weight, own.shape).ravel(), strong]
        for _ in range(_OWN_ROUNDS):
            reading = mine.imputed(np.interp(own, knots, curves[laser]))
            curves[laser] = _monotone(at, np.r_[reading.ravel(), shared[laser]], weight, knots)
        shown[cells.laser == laser] = np.interp(own, knots, curves[laser])
    return curves, shown


def _own_focus(
    cells: Cells, strength: np.ndarray, reading: np.ndarray, knots: np.ndarray, curves: np.ndarray
) -> np.ndarray:
    """Logarithms of the gains of each laser in each range bin [H, D], beside the shared ones, which are in `strength`;
    bins without a cell are interpolated."""
    found, bins = np.zeros((len(curves), len(_DISTANCES))), np.arange(len(_DISTANCES))
    for laser in np.unique(cells.laser):
        mine = cells.laser == laser
        at, curve = cells.range_bin[mine], (knots, curves[laser])
        shifts, _ = _shifts(strength[mine], reading[mine], cells.weight[mine], at, curve, _OWN_FOCUS, len(bins))
        known = np.unique(at)
        found[laser] = np.interp(bins, known, shifts[known])
    return found


def _monotone(strength: np.ndarray, reading: np.ndarray, weight: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """The readings at `knots` that never fall and fit best, by least squares of steps of 0 or more."""
    from scipy.optimize import nnls

    rows = np.broadcast_to(weight, strength.shape).ravel()
    steps = [np.interp(strength.ravel(), knots[k : k + 2], [0.0, 1.0]) for k in range(len(knots) - 1)]
    design = np.stack([np.ones_like(rows), *steps], axis=1) * rows[:, None]
    root = np.linalg.cholesky(design.T @ design + 1e-3 * np.mean(rows**2) * np.eye(len(knots)))
    target = np.linalg.solve(root, design.T @ (reading.ravel() * rows))
    found, _ = nnls(root.T, target - _LOWEST * root[0])
    solution: np.ndarray = np.cumsum(found) + _LOWEST
    return solution


def _shifts(
    strength: np.ndarray,
    reading: np.ndarray,
    weight: np.ndarray,
    of: np.ndarray,
    curve: tuple[np.ndarray, np.ndarray],
    tried: np.ndarray,
    count: int,
    most: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """The best of the shifts `tried` of strengths for each of `count` lasers or range bins, and its offset up to
    `most`; `of` [C] is the laser or bin of each cell."""
    shifts, offsets = np.zeros(count), np.zeros(count)
    for number in np.unique(of):
        ours = of == number
        share = np.broadcast_to(weight[ours] ** 2, reading[ours].shape)
        over = np.interp(strength[ours] + tried[:, None, None], *curve) - reading[ours]
        offset = np.clip((share * over).sum(axis=(1, 2)) / (share.sum() + _PRIOR), -most, most)
        left = (share * (over - offset[:, None, None]) ** 2).sum(axis=(1, 2)) + _PRIOR * (0.1 * tried**2 + offset**2)
        best = int(np.argmin(left))
        shifts[number], offsets[number] = tried[best], offset[best]
    return shifts, offsets
