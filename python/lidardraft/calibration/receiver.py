"""The receiver of a unit: constants with which simulated streets drop, scatter and mix returns like recorded ones.

Each constant has a figure that it alone moves much, and is found by bisection.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from lidardraft.calibration.street_casts import StreetCasts
from lidardraft.calibration.surface_groups import GROUND, LANE, groups_of
from lidardraft.metrics import returns, surfaces
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor_model import SensorModel

_FAR = returns.RANGE_EDGES[:-1] >= 20.0  # m: from there, echoes are weak
_NEAR_GROUND = 12.0  # m: up to there, the ground nearly always returns
_LONGEST_HOLE = 3  # missing firings in a row on the ground
_STEPS = 6
_TEXTURE_STEPS = 4  # each fits an intensity curve
_LEAST_CHANGE = 0.1  # of a figure, between the limits of its constant: with less, the constant is unknown
_ROUNDS = 2
_AT_LIMIT = 1 / 32  # of the way from one limit to the other
_EDGE, _EDGES_WITHIN = 1.0, 20.0  # m between near and far; and the nearer: further off echoes are weak, too
_PATCH = 8  # firings over which texture shows
_FAR_BENDS = (25.0, 60.0)  # m
# The limits of the search for each constant.
_LIMITS = {
    "pulse_duration": (1e-9, 5e-8),  # s
    "detection_threshold": (1e-8, 1e-3),  # 1/m2; 0.10 reaches 3 km and 10 m, less and nothing far returns
    "drop_exponent": (1e-5, 0.3),
    "edge_drop": (1e-3, 5.0),
    "range_sigma": (2e-4, 0.2),  # m
    "jitter": (1e-3, 0.5),  # m
    "texture": (0.02, 1.0),
    "speckle": (0.01, 1.0),
}


def fit_receiver(recorded: Sequence[Sweep], casts: StreetCasts, model: SensorModel) -> tuple[SensorModel, float]:
    """The model with fitted pulse, drop and noise, and its `range_sigma` [m]."""
    sigma = casts.sensor.range_sigma
    # surfaces further apart than a pulse length make two echoes, closer ones a mixed return between them
    model = _fitted("pulse_duration", _mixed, recorded, casts, model, sigma)
    for _ in range(_ROUNDS):  # each moves the other's figure a little
        model = _fitted("detection_threshold", _far_rate, recorded, casts, model, sigma)
        model = _fitted("drop_exponent", _ground_rate, recorded, casts, model, sigma)
    model = _fitted("edge_drop", edge_drops, recorded, casts, model, sigma)
    near = _near_bend(recorded)
    for _ in range(_ROUNDS):
        sigma = _sigma(near, casts, model, sigma)
        model = _fitted("jitter", _far_bend, recorded, casts, model, sigma)
    return model, sigma


def _sigma(near: float, casts: StreetCasts, model: SensorModel, otherwise: float) -> float:
    """The `range_sigma` [m] with which near ground in streets bends as much as `near` [m]."""
    found = bisected(lambda value: _near_bend(casts.observed(model, value)), near, _LIMITS["range_sigma"])
    return otherwise if math.isnan(found) else found


def fit_speckle(recorded: Sequence[Sweep], casts: StreetCasts, model: SensorModel, sigma: float) -> SensorModel:
    """The model with its scatter of readings from firing to firing; its intensity curve must be known."""
    return _fitted("speckle", _reading_step, recorded, casts, model, sigma)


def fit_texture(
    recorded: Sequence[Sweep],
    casts: StreetCasts,
    with_texture: Callable[[float], SensorModel],
    sigma: float,
    *,
    otherwise: float,
) -> SensorModel:
    """The model, made by `with_texture`, whose readings differ over several firings as much as recorded ones; with the
    texture `otherwise` if these do not tell."""
    return _found(
        with_texture,
        lambda one: _reading_step(casts.observed(one, sigma), apart=_PATCH),
        _reading_step(recorded, apart=_PATCH),
        _LIMITS["texture"],
        otherwise,
        steps=_TEXTURE_STEPS,
    )


def at_limits(model: SensorModel, range_sigma: float) -> dict[str, float]:
    """The constants at a limit of their search, and that limit: no value brought streets to the recordings, or the best
    one is further out."""
    found = {}
    for name, limits in _LIMITS.items():
        value = range_sigma if name == "range_sigma" else getattr(model, name)
        low, high = map(math.log, limits)
        for limit in limits:
            if value > 0 and abs(math.log(value / limit)) < _AT_LIMIT * (high - low):
                found[name] = limit
    return found


def _fitted(
    name: str,
    figure: Callable[[Sequence[Sweep]], float],
    recorded: Sequence[Sweep],
    casts: StreetCasts,
    model: SensorModel,
    sigma: float,
) -> SensorModel:
    """The model with the value of one constant that gives streets the recordings' `figure`."""
    return _found(
        lambda value: replace(model, **{name: value}),  # type: ignore[arg-type]
        lambda one: figure(casts.observed(one, sigma)),
        figure(recorded),
        _LIMITS[name],
        getattr(model, name),
    )


def _found(
    with_value: Callable[[float], SensorModel],
    figure: Callable[[SensorModel], float],
    target: float,
    limits: tuple[float, float],
    otherwise: float,
    steps: int = _STEPS,
) -> SensorModel:
    """The model with the value that gives a figure of `target`, or with `otherwise` if the figure is unknown or hardly
    changes."""
    least = _LEAST_CHANGE * abs(target)
    found = bisected(lambda value: figure(with_value(value)), target, limits, steps=steps, least=least)
    return with_value(otherwise if math.isnan(found) else found)


def bisected(
    figure: Callable[[float], float],
    target: float,
    limits: tuple[float, float],
    *,
    steps: int = _STEPS,
    least: float = 0.0,
) -> float:
    """The value between two limits over 0 that gives a monotone figure of `target`; a limit if none does; NaN if the
    figures at the limits differ by no more than `least`."""
    low, high = map(math.log, limits)
    under, over = (figure(limit) - target for limit in limits)
    if not abs(over - under) > least:
        return math.nan
    rising = over > under
    for _ in range(steps):
        middle = (low + high) / 2
        off = figure(math.exp(middle)) - target
        if (off < 0) == rising:
            low, under = middle, off
        else:
            high, over = middle, off
    share = under / (under - over) if abs(over - under) > 0 else 0.5
    return math.exp(low + min(max(share, 0.0), 1.0) * (high - low))


def _far_rate(sweeps: Sequence[Sweep]) -> float:
    """Mean over far ranges of the share of firings into surfaces that return."""
    counts = np.sum([returns.returns_by_range(sweep) for sweep in sweeps], axis=0)[_FAR]
    known = counts[counts[:, 1] >= 500]
    return float((known[:, 0] / known[:, 1]).mean()) if len(known) else math.nan


def _ground_rate(sweeps: Sequence[Sweep]) -> float:
    """Share of firings into the near ground that return; cars, windows and plants lose more for other reasons."""
    found = missing = 0
    for sweep in sweeps:
        group = groups_of(sweep, labelled=False)
        ground = sweep.valid & ((group == LANE) | (group == GROUND)) & (sweep.depth < _NEAR_GROUND)
        rows, starts, ends = returns.runs(~sweep.valid).T
        inner = (ends - starts <= _LONGEST_HOLE) & (starts > 0) & (ends < ground.shape[1])
        rows, starts, ends = rows[inner], starts[inner], ends[inner]
        inside = ground[rows, starts - 1] & ground[rows, ends]
        missing += int((ends - starts)[inside].sum())
        found += int(ground.sum())
    return found / (found + missing) if found >= 500 else math.nan


def edge_drops(sweeps: Sequence[Sweep]) -> float:
    """Share of the firings between two returns of near and far surfaces that are lost."""
    lost = found = 0
    for sweep in sweeps:
        before, here, after = sweep.depth[:, :-2], sweep.depth[:, 1:-1], sweep.depth[:, 2:]
        nearest = np.minimum(before, after)
        edge = (nearest > 0) & (nearest < _EDGES_WITHIN) & (np.abs(before - after) > _EDGE)
        lost += int((edge & (here == 0)).sum())
        found += int(edge.sum())
    return lost / found if found >= 500 else math.nan


def _mixed(sweeps: Sequence[Sweep]) -> float:
    shares = [share for share in map(surfaces.mixed_share, sweeps) if not math.isnan(share)]
    return float(np.mean(shares)) if shares else math.nan


def _near_bend(sweeps: Sequence[Sweep]) -> float:
    """Median distance of near ground returns from the middle of their neighbours in the row [m]."""
    found = []
    for sweep in sweeps:
        bend, inside = surfaces.bends(sweep.depth)
        ground = np.isin(groups_of(sweep, labelled=False), (LANE, GROUND))[:, 1:-1]
        found.append(bend[inside & ground & (sweep.depth[:, 1:-1] < _NEAR_GROUND)])
    return _quantile(np.concatenate(found), 0.5)


def _far_bend(sweeps: Sequence[Sweep]) -> float:
    """Lower quartile of the same distance for all far returns, among which few surfaces are smooth [m]."""
    found = []
    for sweep in sweeps:
        (bend, inside), here = surfaces.bends(sweep.depth), sweep.depth[:, 1:-1]
        found.append(bend[inside & (here > _FAR_BENDS[0]) & (here < _FAR_BENDS[1])])
    return _quantile(np.concatenate(found), 0.25)


def _quantile(bend: np.ndarray, share: float) -> float:
    return float(np.quantile(bend, share)) if len(bend) >= 500 else math.nan


def _reading_step(sweeps: Sequence[Sweep], apart: int = 1) -> float:
    """Mean of the smaller half of the steps of readings over 0 between firings `apart`, at one range; the others are
    edges of objects."""
    found = []
    for sweep in sweeps:
        assert sweep.intensity is not None
        read, depth = sweep.intensity, sweep.depth
        here, there = (slice(None), slice(apart, None)), (slice(None), slice(None, -apart))
        near = (np.abs(depth[here] - depth[there]) < 0.1 * apart) & (read[here] > 0) & (read[there] > 0)
        found.append(np.abs(read[here] - read[there])[near])
    steps = np.concatenate(found)
    # readings are quantised: a mean tells more than a median
    return float(np.sort(steps)[: len(steps) // 2].mean()) if len(steps) >= 500 else math.nan
