"""The intensity curve of a unit: readings of streets get the quantiles of the recorded ones.

What a laser reads of an echo is not published, but known from what is common in streets: among the returns of the same
group, laser and range, recorded readings and the responses of simulated streets have the same ranks. One curve for all
lasers, a gain at each range, and a gain and an offset of each laser make of the ones the others, in least squares; then
each laser gets a curve and gains by range of its own, as far as it has returns enough to tell: each has a focus of its
own. What a laser reads least but 0 is its cut-off, or somewhat more, where it reads 0 more often than that explains.
What is ten times as bright as nearly all returns are reads as the brightest recorded ones do.
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

_RANGES = np.array([2.0, 5.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0, 50.0, 65.0, 80.0, 120.0])  # m
_DISTANCES = np.sqrt(_RANGES[1:] * _RANGES[:-1])  # m, where there is a gain each
_REFERENCE = 2  # the range whose gain is 1
_FEWEST = 100  # returns of a cell: of one group, one laser and one range
_MOST = 2000  # that count
_LEVELS = np.linspace(0.025, 0.975, 20)  # of the quantiles
_KNOTS = 16
_LEAST = -1.0  # reading of a curve, with its offset
# Logarithms of gains that are tried of a laser and at a range, and offsets of a laser.
_GAINS = np.linspace(-2.0, 2.0, 81)
_FOCUS = np.linspace(-3.0, 1.5, 91)
_OWN_FOCUS = np.linspace(-1.5, 1.5, 61)  # of one laser, beside that of all
_MOST_OFFSET = 0.4
_DRAWN = 0.005  # of a cell of _FEWEST returns: how much that weighs which draws gains towards 1 and offsets to 0
_SHARED = 150.0  # returns at each knot that stand for the shared curve against a laser's own
_ROUNDS, _OWN_ROUNDS, _FOCUS_ROUNDS = 12, 3, 2
_LEAST_SHARE = 0.005  # of a laser's readings over 0 are below its cut-off: outliers
_MOST_RAISED = 2.0  # times the least reading
_NO_ZEROS = 0.002  # a laser that reads 0 less often has no cut-off
_BRIGHTER = math.log(10.0)  # than all but 3 of 1000 returns: retroreflectors, which have no cells
_MOST_SHARE = 0.9999  # of the readings are below what those read: outliers


@dataclass(frozen=True)
class Cells:
    """Quantiles of what is alike, of C cells of one group, one laser and one range each."""

    row: np.ndarray  # i64 [C]
    range: np.ndarray  # i64 [C], which of _DISTANCES
    response: np.ndarray  # logarithms [C, Q]
    reading: np.ndarray  # [C, Q]
    weight: np.ndarray  # [C, 1], roots of returns


@dataclass(frozen=True, eq=False)
class Readings:
    """What is known of the readings of recorded sweeps, and does not change while a sensor is fitted to them.

    `cells` are quantiles and counts by group, range and laser, of classes where all sweeps are `labelled`; for each
    laser [H], `cutoffs` is its least reading over 0, or 0 where it hardly ever reads 0, and `zeros` how often it does;
    `most` is what the brightest read.
    """

    cells: dict[int, tuple[np.ndarray, int]]
    labelled: bool
    cutoffs: np.ndarray
    zeros: np.ndarray
    most: float

    @classmethod
    def from_sweeps(cls, recorded: Sequence[Sweep]) -> Readings:
        """Of sweeps of one unit, all with intensities."""
        labelled = all(sweep.label is not None for sweep in recorded)
        by_laser = [_of_laser(recorded, row)[0] for row in range(len(recorded[0].points))]
        zeros = np.array([(read == 0).mean() if len(read) else 0.0 for read in by_laser])
        most = float(np.quantile(np.concatenate(by_laser), _MOST_SHARE))
        return cls(_by_cell(recorded, labelled), labelled, np.array([*map(_cutoff, by_laser)]), zeros, most)


def _of_laser(sweeps: Sequence[Sweep], row: int) -> tuple[np.ndarray, np.ndarray]:
    """The intensities and ranges of all returns of a laser."""
    there = [(sweep.valid[row], sweep.intensity, sweep.depth) for sweep in sweeps if sweep.intensity is not None]
    intensity, depth = zip(*((read[row][seen], depth[row][seen]) for seen, read, depth in there), strict=True)
    return np.concatenate(intensity), np.concatenate(depth)


def _cutoff(read: np.ndarray) -> float:
    above = read[read > 0]
    none = len(above) < _FEWEST or len(above) > (1 - _NO_ZEROS) * len(read)
    return 0.0 if none else float(np.quantile(above, _LEAST_SHARE))


@dataclass(frozen=True)
class IntensityFit:
    """The fitted curve, and the root mean square of what is left between quantiles, of 1."""

    curve: IntensityCurve
    residual: float


def fit_intensity(recorded: Readings, simulated: Sequence[Sweep]) -> IntensityFit:
    """The curve with which simulated sweeps, whose intensities are responses, read as the recorded ones do.

    Returns are grouped by class if all recorded sweeps have labels, else by place and shape (`surface_groups.py`).
    """
    cells, cutoffs = _cells(recorded, simulated), recorded.cutoffs
    if not len(cells.row):
        raise FormatError(f"no laser has {_FEWEST} returns of one kind at one distance; intensities need more scans")
    least, beams = cutoffs[cells.row][:, None], len(cutoffs)
    gains, offsets, focus = np.zeros(beams), np.zeros(beams), np.zeros(len(_DISTANCES))
    known = cells.reading
    for _ in range(_ROUNDS):
        strength = cells.response + focus[cells.range][:, None]
        own = strength + gains[cells.row][:, None]
        knots = _knots(own)
        curve = _monotone(own, known + offsets[cells.row][:, None], cells.weight, knots)
        apart = cells.response + gains[cells.row][:, None], known + offsets[cells.row][:, None]
        focus, _ = _shifts(*apart, cells.weight, cells.range, (knots, curve), _FOCUS, len(focus), 0.0)
        focus -= focus[_REFERENCE]
        strength = cells.response + focus[cells.range][:, None]
        gains, offsets = _shifts(strength, known, cells.weight, cells.row, (knots, curve), _GAINS, beams, _MOST_OFFSET)
        shown = np.interp(strength + gains[cells.row][:, None], knots, curve) - offsets[cells.row][:, None]
        known = _imputed(cells.reading, shown, least)
    at = _knots(strength)
    shared = np.array([np.interp(at + gain, knots, curve) for gain in gains]) - offsets[:, None]
    own, focuses = strength, np.tile(focus, (beams, 1))
    readings, shown = _own_curves(cells, own, at, shared, least)
    for _ in range(_FOCUS_ROUNDS):
        focuses = focus + _own_focus(cells, strength, _imputed(cells.reading, shown, least), (at, readings))
        own = cells.response + focuses[cells.row, cells.range][:, None]
        readings, shown = _own_curves(cells, own, at, shared, least)
    cutoffs = _raised(recorded, simulated, focuses, (at, readings))
    at, readings = np.append(at, at[-1] + _BRIGHTER), np.column_stack([readings, np.full(beams, recorded.most)])
    left = np.where(shown < cutoffs[cells.row][:, None], 0.0, shown) - cells.reading
    share = np.broadcast_to(cells.weight**2, left.shape)
    fitted = IntensityCurve(
        responses=tuple(np.exp(at).tolist()),
        readings=tuple(map(tuple, np.clip(np.maximum.accumulate(readings, axis=1), 0.0, 1.0).tolist())),
        distances=tuple(_DISTANCES.tolist()),
        distance_gains=tuple(map(tuple, np.exp(focuses).tolist())),
        cutoffs=tuple(cutoffs.tolist()),
    )
    return IntensityFit(fitted, math.sqrt(float((share * left**2).sum() / share.sum())))


def _cells(recorded: Readings, simulated: Sequence[Sweep]) -> Cells:
    readings, responses, beams = recorded.cells, _by_cell(simulated, recorded.labelled), len(recorded.cutoffs)
    both = sorted(set(readings) & set(responses))
    return Cells(
        row=np.array([key % beams for key in both]),
        range=np.array([key // beams % len(_DISTANCES) for key in both]),
        response=np.log(np.maximum([responses[key][0] for key in both], 1e-5)),
        reading=np.array([readings[key][0] for key in both]),
        weight=np.sqrt([min(readings[key][1], responses[key][1], _MOST) for key in both]).reshape(-1, 1),
    )


def _by_cell(sweeps: Sequence[Sweep], labelled: bool) -> dict[int, tuple[np.ndarray, int]]:
    """Quantiles of intensities, and their count, of each cell that has enough returns."""
    keys, found = [], []
    for sweep in sweeps:
        assert sweep.intensity is not None
        bins = np.digitize(sweep.depth, _RANGES) - 1
        inside = sweep.valid & (bins >= 0) & (bins < len(_DISTANCES))
        rows = np.broadcast_to(np.arange(len(bins))[:, None], bins.shape)
        keys.append(((groups_of(sweep, labelled) * len(_DISTANCES) + bins) * len(bins) + rows)[inside])
        found.append(sweep.intensity[inside])
    key, value = np.concatenate(keys), np.concatenate(found)
    order = np.argsort(key, kind="stable")
    names, starts = np.unique(key[order], return_index=True)
    pieces = zip(names.tolist(), np.split(order, starts[1:]), strict=True)
    return {name: (np.quantile(value[p], _LEVELS), len(p)) for name, p in pieces if len(p) >= _FEWEST}


def _raised(
    recorded: Readings, simulated: Sequence[Sweep], focuses: np.ndarray, curves: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Cut-offs with which as many simulated readings of each laser are 0 as recorded ones, up to twice as high."""
    found = recorded.cutoffs.copy()
    for row in np.flatnonzero(found).tolist():
        response, distance = _of_laser(simulated, row)
        if len(response) >= _FEWEST:
            strength = np.log(np.maximum(response, 1e-5)) + np.interp(distance, _DISTANCES, focuses[row])
            shown = np.interp(strength, curves[0], curves[1][row])
            found[row] = np.clip(np.quantile(shown, recorded.zeros[row]), found[row], _MOST_RAISED * found[row])
    return found


def _imputed(reading: np.ndarray, shown: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Readings, and for those of 0, of which only that is known that they are below the cut-off, what is shown."""
    return np.where(reading > 0, reading, np.minimum(shown, least))


def _knots(strength: np.ndarray) -> np.ndarray:
    low, high = np.quantile(strength, (0.003, 0.997))
    return np.linspace(float(low), float(high), _KNOTS)


def _own_curves(
    cells: Cells, strength: np.ndarray, knots: np.ndarray, shared: np.ndarray, least: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A curve of each laser [H, K] near the `shared` one, and what it reads in the cells [C, Q]."""
    curves, shown = shared.copy(), np.empty_like(strength)
    for _ in range(_OWN_ROUNDS):
        for beam in np.unique(cells.row):
            ours = cells.row == beam
            shown[ours] = np.interp(strength[ours], knots, curves[beam])
            reading = _imputed(cells.reading[ours], shown[ours], least[ours])
            weight = np.broadcast_to(cells.weight[ours], reading.shape)
            curves[beam] = _monotone(
                np.r_[strength[ours].ravel(), knots],
                np.r_[reading.ravel(), shared[beam]],
                np.r_[weight.ravel(), np.full(len(knots), math.sqrt(_SHARED * len(_LEVELS)))],
                knots,
            )
    for beam in np.unique(cells.row):
        shown[cells.row == beam] = np.interp(strength[cells.row == beam], knots, curves[beam])
    return curves, shown


def _own_focus(
    cells: Cells, strength: np.ndarray, reading: np.ndarray, curves: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Logarithms of the gains of each laser at each distance [H, D] beside those of all, which `strength` has; where it
    has no cell, as at the next distances that have."""
    found = np.zeros((len(curves[1]), len(_DISTANCES)))
    for beam in np.unique(cells.row):
        ours = cells.row == beam
        at = cells.range[ours]
        curve = curves[0], curves[1][beam]
        shifts, _ = _shifts(
            strength[ours], reading[ours], cells.weight[ours], at, curve, _OWN_FOCUS, len(_DISTANCES), 0.0
        )
        known = np.unique(at)
        found[beam] = np.interp(np.arange(len(_DISTANCES)), known, shifts[known])
    return found


def _monotone(strength: np.ndarray, reading: np.ndarray, weight: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """The readings at `knots` that never fall and fit best, by least squares of steps of 0 or more."""
    from scipy.optimize import nnls

    rows = np.broadcast_to(weight, strength.shape).ravel()
    steps = [np.interp(strength.ravel(), knots[k : k + 2], [0.0, 1.0]) for k in range(len(knots) - 1)]
    design = np.stack([np.ones_like(rows), *steps], axis=1) * rows[:, None]
    root = np.linalg.cholesky(design.T @ design + 1e-3 * np.mean(rows**2) * np.eye(len(knots)))
    target = np.linalg.solve(root, design.T @ (reading.ravel() * rows))
    found, _ = nnls(root.T, target - _LEAST * root[0])
    solution: np.ndarray = np.cumsum(found) + _LEAST
    return solution


def _shifts(
    strength: np.ndarray,
    reading: np.ndarray,
    weight: np.ndarray,
    of: np.ndarray,
    curve: tuple[np.ndarray, np.ndarray],
    tried: np.ndarray,
    count: int,
    most: float,
) -> tuple[np.ndarray, np.ndarray]:
    """For each of `count` lasers or ranges, which cells are `of`, the best of the shifts `tried` of its strengths, and
    the offset up to `most` that goes with it."""
    shifts, offsets = np.zeros(count), np.zeros(count)
    drawn = _DRAWN * _FEWEST * len(_LEVELS)
    for number in np.unique(of):
        ours = of == number
        share = np.broadcast_to(weight[ours] ** 2, reading[ours].shape)
        over = np.interp(strength[ours] + tried[:, None, None], *curve) - reading[ours]
        offset = np.clip((share * over).sum(axis=(1, 2)) / (share.sum() + drawn), -most, most)
        left = (share * (over - offset[:, None, None]) ** 2).sum(axis=(1, 2)) + drawn * (0.1 * tried**2 + offset**2)
        best = int(np.argmin(left))
        shifts[number], offsets[number] = tried[best], offset[best]
    return shifts, offsets
