"""How much ranges differ between rays that pass through foliage near each other: recordings beside streets.

    python benches/foliage_steps.py [--num 40] [--data FOLDER]

For firings of one laser 1 to 8 columns apart, both of which return from vegetation within 40 m, a cell is the
difference of their ranges in cm, the median or what a fifth of them exceed; rows of the table are how far apart the
rays are there. Leaves in clumps show as differences that grow with that, independent ones as a constant.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable
from itertools import islice
from pathlib import Path

import numpy as np

import markdown_table
import recordings
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME
from lidardraft.streets import StreetConfig, streets

SEED = 2_000_000  # no training uses it
LAGS = (1, 2, 4, 8)  # columns
EDGES = np.array([0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28])  # m between rays
FURTHEST = 40.0  # m
FEWEST = 200  # pairs of a cell


def steps(sweeps: Iterable[Sweep]) -> list[np.ndarray]:
    """The differences of range [m] between returns of vegetation, by how far their rays are apart."""
    found: list[list[np.ndarray]] = [[] for _ in EDGES[1:]]
    for sweep in sweeps:
        depth = np.linalg.norm(sweep.points.astype(np.float64), axis=-1)
        leaves = (depth > 0) & (depth < FURTHEST) & (sweep.label == BY_NAME["vegetation"].id)
        azimuth = np.arctan2(sweep.points[..., 1], sweep.points[..., 0])
        for lag in LAGS:
            both = leaves[:, lag:] & leaves[:, :-lag]
            near, other = depth[:, lag:][both], depth[:, :-lag][both]
            turn = np.abs((azimuth[:, lag:] - azimuth[:, :-lag])[both])
            cell = np.digitize(turn * np.minimum(near, other), EDGES) - 1
            for number, values in enumerate(found):
                values.append(np.abs(near - other)[cell == number])
    return [np.concatenate(values) for values in found]


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--num", type=int, default=40, help="streets of each sensor, a scan each (default 40)")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), help="folder of recordings")
    arguments = parser.parse_args()
    columns: dict[str, list[np.ndarray]] = {}
    if arguments.data:
        pandaset = recordings.pandar64(arguments.data, 1800).labelled.values()
        columns["PandaSet, Pandar64"] = steps(sweep for group in pandaset for sweep in group)
        columns["KITTI, HDL-64E"] = steps(recordings.kitti_images(arguments.data))
    for name in ("pandar64", "hdl64e"):
        made = islice(streets(seed=SEED, config=StreetConfig(sensor=PRESETS[name], poses_per_street=1)), arguments.num)
        columns[f"streets, {name}"] = steps(Sweep.by_azimuth(pair.scan) for pair in made)
    rows = {
        f"{100 * EDGES[k]:.0f} to {100 * EDGES[k + 1]:.0f} cm, {name}": {
            set_name: 100 * float(np.percentile(values[k], percent))
            for set_name, values in columns.items()
            if len(values[k]) >= FEWEST
        }
        for name, percent in (("median", 50), ("a fifth over", 80))
        for k in range(len(EDGES) - 1)
    }
    print(markdown_table.table(rows))


if __name__ == "__main__":
    main()
