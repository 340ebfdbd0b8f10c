"""Generated scans of the layouts of recordings, beside simulated ones and the recordings: a part of report_generate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from cases import recorded_sets, sweeps_of
from goals import Goal
from lidardraft import Pipeline
from lidardraft.metrics.crop_features import CROP_COLUMNS
from lidardraft.metrics.sweep import Sweep
from lidardraft.metrics.two_sample import two_sample
from markdown_table import Row, table
from scan_scores import scores

KINDS = ("+ sensor model", "simulated", "generated")
DISTANCES = ("range", "height", "BEV", "intensity by class", "drop runs")
FEWEST = 10  # cases that a classifier learns from: of fewer crops it tells nothing


def compare_with_recordings(folder: Path, pipeline: Pipeline, number: int, only: str) -> Iterator[str | Goal]:
    """Tables of each set of recordings, of `number` cases at most, then the goals."""
    rows: dict[str, dict[str, Row]] = {}
    told: dict[str, Row] = {}
    for name, make in recorded_sets(folder):
        if only not in name:
            continue
        cases = make()
        chosen = np.unique(np.linspace(0, len(cases.cases) - 1, number).astype(int)) if cases.cases else []
        found = list(sweeps_of(replace(cases, cases=[cases.cases[k] for k in chosen]), pipeline))
        if not found:
            continue
        rows[name] = scores(found, KINDS, firings=cases.firings)
        yield f"### {name}, {len(found)} scans\n\n{table(rows[name])}\n"
        told |= {f"{name}, {kind}": auc for kind, auc in told_apart(found).items()}
    if told:
        yield f"### Told from recordings, AUC\n\n{table(told)}\n"
    yield from goals(rows, told)


def told_apart(found: Sequence[dict[str, Sweep]]) -> dict[str, Row]:
    """The AUC by family of simulated and of generated scans; none of a few, or of scans narrower than a crop.

    The first and the second half of the recordings take the place of drives: they are other places or other times.
    """
    half = len(found) // 2
    if len(found) < FEWEST or found[0]["recorded"].depth.shape[1] < CROP_COLUMNS:
        return {}
    halves = found[:half], found[half : 2 * half]
    recorded = {str(number): [sweeps["recorded"] for sweeps in part] for number, part in enumerate(halves)}
    told = {}
    for kind in KINDS[1:]:
        made = [sweeps[kind] for pair in zip(*halves, strict=True) for sweeps in pair]
        told[kind] = dict(two_sample(recorded, made).auc)
    return told


def goals(rows: dict[str, dict[str, Row]], told: dict[str, Row]) -> Iterator[Goal]:
    """What of the goals recordings tell."""
    yield Goal(
        "agreeing of real returns, generated minus cast + sensor model",
        {name: row["generated"]["agreeing"] - row["+ sensor model"]["agreeing"] for name, row in rows.items()},
        least=-0.01,
    )
    for column in DISTANCES:
        ratios = {
            name: row["generated / simulated"][column] for name, row in rows.items() if column in row["simulated"]
        }
        yield Goal(f"JSD of {column} to recordings, generated / simulated", ratios, most=0.9)
    f1 = {name: row["generated"]["drop F1"] for name, row in rows.items() if "drop F1" in row["generated"]}
    yield Goal("drop mask against the recorded one, F1", f1, least=0.25)
    more = {}
    for name in rows:
        simulated, generated = (told.get(f"{name}, {kind}", {}) for kind in KINDS[1:])
        more |= {f"{name}, {family}": generated[family] - simulated[family] for family in generated}
    yield Goal("two-sample AUC by family, generated minus simulated", more, most=0.0)
