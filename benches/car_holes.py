"""Firings at cars that are lost, by height, range and block of lasers, as recorded and in streets.

Lost is a firing without a return between two of its laser on one car. KITTI, which only judges, has no labels here:
cars are clusters of their size with two sides. `python benches/car_holes.py`, with recordings in LIDARDRAFT_DATA.
"""

import itertools
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy import ndimage

import recordings
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS
from lidardraft.scene.sensor_model import MODELS, SensorModel
from lidardraft.semantics import BY_NAME
from lidardraft.streets import StreetConfig, streets
from result_page import write_page

SEED, STREETS = 5_000_000, 12  # no training uses the seed
CELL, GROUND_CELL, EXTENT, WIDEST, APART = 0.2, 2.0, 45.0, 1.3, 0.6  # m; the last two of a gap and its ends' ranges
BANDS = {"body": (0.2, 0.8), "windows": (0.8, 1.3), "upper windows and roof": (1.3, 2.0)}  # m over the ground
RANGES = ((3, 6), (6, 9), (9, 14), (14, 20), (20, 40))  # m
SAID = "share of firings at cars that are lost [%], and how many were fired; bright is a reading over 0.3."


def over_ground(sweep: Sweep) -> np.ndarray:
    """Height [m] of returns over the low ones around them [H, W]."""
    low = np.full((int(2 * EXTENT / GROUND_CELL),) * 2, np.inf)
    at = tuple(np.clip((np.moveaxis(sweep.points[..., :2], -1, 0) + EXTENT) / GROUND_CELL, 0, len(low) - 1).astype(int))
    np.minimum.at(low, at, np.where(sweep.valid, sweep.points[..., 2], np.inf))
    low[~np.isfinite(low)] = np.median(low[np.isfinite(low)])
    return np.asarray(sweep.points[..., 2] - ndimage.percentile_filter(low, 35, size=5)[at])


def looks_like_car(points: np.ndarray, height: np.ndarray) -> bool:
    """Whether returns lie on two sides of a rectangle of a car's size, at heights of one."""
    fits = []
    for turn in np.exp(1j * np.deg2rad(np.arange(0, 90, 2))):
        along = points[:, :2] @ np.array([[turn.real, -turn.imag], [turn.imag, turn.real]])
        low, high = np.percentile(along, (0.5, 99.5), axis=0)
        fits.append((np.clip(np.minimum(along - low, high - along).min(axis=1), 0, 0.3).mean(), *np.sort(high - low)))
    off, width, length = min(fits)
    upright = 1.25 < np.percentile(height, 99) < 1.75 and np.percentile(height, 5) < 0.75
    return bool(off < 0.16 and 0.9 < width < 2.05 and 3.2 < length < 5.0 and upright)


def cars(sweep: Sweep, height: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Rows and columns of the returns of each car; `height` [H, W] is over the ground."""
    flat = np.hypot(sweep.points[..., 0], sweep.points[..., 1])
    some = sweep.valid & (height > 0.3) & (height < 2.2) & (flat > 2.8) & (flat < RANGES[-1][1])
    if sweep.label is not None:
        some &= sweep.label == BY_NAME["car"].id
    (rows, columns), points = np.nonzero(some), sweep.points[some]
    at = tuple(((points[:, :2].T + EXTENT) / CELL).astype(int))
    cells = np.zeros((int(2 * EXTENT / CELL),) * 2, bool)
    cells[at] = True
    clusters = ndimage.label(ndimage.binary_dilation(cells), np.ones((3, 3)))[0][at]
    for number in np.flatnonzero(np.bincount(clusters) >= 60):
        mine = clusters == number
        if sweep.label is not None or looks_like_car(points[mine], height[some][mine]):
            yield rows[mine], columns[mine]


def gaps(sweep: Sweep) -> np.ndarray:
    """Between neighbouring returns of a laser on a car [N, 6]: firings lost, height, range, laser, both readings."""
    found, depth, inside = [np.zeros((0, 6))], sweep.depth, sweep.valid.cumsum(axis=1)
    readings, height = np.zeros(depth.shape) if sweep.intensity is None else sweep.intensity, over_ground(sweep)
    for rows, columns in cars(sweep, height):
        first, then = (rows[:-1], columns[:-1]), (rows[1:], columns[1:])
        lost = np.diff(columns) - inside[then] + inside[first]  # what returned from elsewhere is not lost
        wide = np.diff(columns) * 2 * np.pi / depth.shape[1] * depth[first]
        one = (np.diff(rows) == 0) & (wide < WIDEST) & (np.abs(depth[first] - depth[then]) < APART)
        ends = (height[first] + height[then]) / 2, depth[first], rows[1:], readings[first], readings[then]
        found.append(np.stack((lost, *ends), axis=1)[one])
    return np.concatenate(found)


def measured(sweeps: list[Sweep]) -> dict[str, str]:
    """Lost firings [%] of those at cars, and how many these are, by the name of the row."""
    lost, height, depth, laser, first, then = np.concatenate([gaps(sweep) for sweep in sweeps]).T
    some = {name: (height >= low) & (height < high) for name, (low, high) in BANDS.items()}
    for name, (low, high) in itertools.product(("body", "windows"), RANGES):
        some[f"{name}, {low} to {high} m"] = some[name] & (depth >= low) & (depth < high)
    some |= {"upper block": laser < 32, "lower block": laser >= 32}
    fired = {name: lost[mask].sum() + mask.sum() for name, mask in some.items()}
    text = {name: f"{100 * lost[mask].sum() / fired[name]:.1f} ({fired[name]:.0f})" for name, mask in some.items()}
    after, before = (f"{100 * (lost[reading > 0.3] > 0).mean():.1f}" for reading in (first, then))
    return text | {"right after a bright one": after, "right before one": before}


def made(sensor: str, firings: int, **changed: float) -> list[Sweep]:
    """Scans of streets, with all `firings` of a turn at 10 Hz."""
    model = SensorModel.from_dict(MODELS[sensor].to_dict() | changed)
    config = StreetConfig(sensor=replace(PRESETS[sensor], columns=firings, model=model), poses_per_street=1)
    return [Sweep.by_azimuth(pair.scan) for pair in itertools.islice(streets(seed=SEED, config=config), STREETS)]


def main(folder: Path) -> None:
    """Measure and write the page."""
    sweeps = {
        "KITTI": list(itertools.chain(*recordings.hdl64e(folder, 2083).plain.values())),
        "streets, HDL-64E": made("hdl64e", 2083),
        "threshold / 4": made("hdl64e", 2083, detection_threshold=MODELS["hdl64e"].detection_threshold / 4),
        "nothing behind glass": made("hdl64e", 2083, glass_transmission=False),
        "PandaSet": list(itertools.chain(*recordings.pandar64(folder, 1800).labelled.values())),
        "streets, Pandar64": made("pandar64", 1800),
    }
    columns = [measured(found) for found in sweeps.values()]
    lines = [f"| | {' | '.join(sweeps)} |", f"|---|{'---:|' * len(columns)}"]
    lines += [f"| {name} | {' | '.join(column[name] for column in columns)} |" for name in columns[0]]
    write_page("car_holes", SAID, "\n".join(lines))


if __name__ == "__main__":
    main(Path(os.environ["LIDARDRAFT_DATA"]))
