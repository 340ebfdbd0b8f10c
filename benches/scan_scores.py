"""Scores of sets of scans that were made of layouts, beside the scans that the layouts are of."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from goals import ratio
from lidardraft.metrics.lifelike import pooled_divergence
from lidardraft.metrics.returns import hole_lengths, lone_returns, near_holes
from lidardraft.metrics.sweep import Sweep
from markdown_table import Row
from report_simulate import table_of


def scores(found: Sequence[dict[str, Sweep]], kinds: Sequence[str], *, firings: bool) -> dict[str, Row]:
    """The rows of one set of `cases.sweeps_of`: what was recorded, each of `kinds`, and generated / simulated.

    "agreeing" and "objects" are shares of the recorded returns, all and those on objects, that a scan has within 0.5 m
    or 5 %; then come Jensen-Shannon distances of the set from the recorded one, drop masks against the recorded ones,
    and what `metrics/returns.py` counts. "intensity by class" is the mean over the classes that all of `kinds` have.
    """
    shares = table_of(found, firings)
    # A class that one kind of scan lacks compares nothing.
    read = [name for name, cells in shares.items() if name.startswith("intensity") and _all_known(cells, kinds)]
    rows = {"recorded": returns([sweeps["recorded"] for sweeps in found])}
    for kind in kinds:
        mine = [sweeps[kind] for sweeps in found]
        cell = {name: cells.get(kind, np.nan) for name, cells in shares.items()}
        row = {
            "agreeing": cell["near"],
            "objects": cell.get("near, on objects", np.nan),
            "range": cell["range (JSD)"],
            "height": cell["height over the road (JSD)"],
            "BEV": cell["top view (BEV JSD)"],
            "BEV MMD": cell["top view (BEV MMD)"],
            "intensity by class": float(np.mean([cell[name] for name in read])) if read else np.nan,
        }
        if firings:
            runs = ([hole_lengths(sweep) for sweep in of] for of in ([s["recorded"] for s in found], mine))
            precision, recall = cell.get("drop precision", np.nan), cell.get("drop recall", np.nan)
            row["drop runs"] = pooled_divergence(*runs)
            row["drop F1"] = 2 * precision * recall / (precision + recall) if precision + recall else 0.0
        rows[kind] = row | returns(mine)
    simulated, generated = rows["simulated"], rows["generated"]
    rows["generated / simulated"] = {name: ratio(generated[name], simulated[name]) for name in generated}
    return rows


def _all_known(cells: Mapping[str, float], kinds: Sequence[str]) -> bool:
    return all(math.isfinite(cells.get(kind, math.nan)) for kind in kinds)


def returns(sweeps: Sequence[Sweep]) -> Row:
    """Holes of one firing in a thousand places on near surfaces, and lone returns in percent."""
    holes, places = np.sum([near_holes(sweep) for sweep in sweeps], axis=0)
    lone, all_returns = np.sum([lone_returns(sweep) for sweep in sweeps], axis=0)
    return {"holes in 1,000": 1e3 * ratio(holes, places), "lone %": 100 * ratio(lone, all_returns)}
