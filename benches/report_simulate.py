"""What becomes of a layout, held against the scan that the layout was made from: `make report-simulate`.

    python benches/report_simulate.py [--streets 50] [--data FOLDER] [--only NAME]

Each labelled recording in FOLDER (by default LIDARDRAFT_DATA) is clustered to a layout, and each street has its coarse
one. From there come three scans: the bare cast; the cast with the sensor model, `simulate(detail=False)`; and that of
`simulate` in detail. A row is a share of pixels (more is better) or a distance between the sets (less is better).
"Near" is within 0.5 m or 5 % of the recorded range. "IoU": of the pixels where either returns from a class, those where
both do, and near.
"""

from __future__ import annotations

import argparse
import os
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np

import tables
from cases import CaseSet, recorded_sets, street_set, sweeps_of
from lidardraft import Pipeline
from lidardraft.metrics import lifelike
from lidardraft.metrics.lifelike import CLASS_SETS
from lidardraft.metrics.profiles import height_histogram, road_level
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.labelling import ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE
from lidardraft.semantics import BY_NAME, CLASSES, GROUND
from result_page import write_page

NO_OBJECT = [BY_NAME[name].id for name in ("none", *GROUND)]
# which of `CLASS_SETS` a class is of, by its id; of the others each is a set of its own
SETS = {name: [BY_NAME[member].id for member in members] for name, members in CLASS_SETS.items()}
SET_OF = np.array([next((100 + k for k, ids in enumerate(SETS.values()) if row.id in ids), row.id) for row in CLASSES])
_HEIGHT = "height over the road (JSD)"
_COMPARED = ("range (JSD)", _HEIGHT, "top view (BEV JSD)", "top view (BEV MMD)")
DISTANCES = (
    *(one for one in lifelike.PROPERTIES if one.name in _COMPARED),
    *(one for one in lifelike.class_properties() if one.name in {f"intensity of {name} (JSD)" for name in CLASS_SETS}),
)
PAGE = (
    'a cell is the value of the cast with the sensor model (`detail=False`) → that of the simulated scan. "Near" is the'
    ' share of recorded returns for which the other scan has one within 0.5 m or 5 %. "IoU" counts the pixels where'
    " both return from a class, and near, among those where either does. JSD and MMD are distances. KITTI and nuScenes"
    " are images of the usual projection, the others rows of lasers; streets are their coarse layouts."
)
FEWEST = 200  # returns of which a class has rows
EQUAL = 0.005  # differences that are none
BOTH = "returns of either that both have"
BETTER_IF_MORE = (BOTH, "drop precision", "drop recall")

Table = dict[str, tables.Row]
Counts = dict[str, np.ndarray]  # by row: part and whole


def shares(recorded: Sweep, made: Sweep, cast: Sweep, firings: bool) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Each row's name, the pixels that count for it, and those of them that are right."""
    assert recorded.label is not None
    assert made.label is not None
    both = recorded.valid & made.valid
    tolerance = np.maximum(ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE * recorded.depth)
    near = both & (np.abs(made.depth - recorded.depth) <= tolerance)
    known = recorded.valid & (recorded.label > 0)
    yield "near", recorded.valid, near
    yield "near, of the same class", known, near & (SET_OF[made.label] == SET_OF[recorded.label])
    yield "near, on objects", known & ~np.isin(recorded.label, NO_OBJECT), near
    for name, ids in SETS.items():
        here, there = (sweep.valid & np.isin(sweep.label, ids) for sweep in (recorded, made))
        yield f"near, on {name}", here, near
        yield f"IoU of {name}", here | there, here & there & near
    yield BOTH, recorded.valid | made.valid, both
    if firings:
        lost, dropped = cast.valid & ~recorded.valid, cast.valid & ~made.valid
        yield "dropped in recording", cast.valid, lost
        yield "dropped", cast.valid, dropped
        yield "drop precision", dropped, lost
        yield "drop recall", lost, dropped


def report(cases: CaseSet, generators: Mapping[str, Pipeline] | None = None) -> Table:
    """The table of a set, with a column for each of the `generators`."""
    return table_of(sweeps_of(cases, generators), cases.firings)


def table_of(found: Iterable[dict[str, Sweep]], firings: bool) -> Table:
    """The table of `sweeps_of` cases."""
    counts: dict[str, Counts] = defaultdict(lambda: defaultdict(lambda: np.zeros(2)))
    features: dict[str, dict[str, list[np.ndarray]]] = defaultdict(lambda: defaultdict(list))
    for sweeps in found:
        # the scans of a case are taken from one place: its road is theirs, though each alone would tell another level
        heights = partial(height_histogram, road=road_level(sweeps["recorded"]))
        for name, sweep in sweeps.items():
            if name != "recorded":
                for row, of, right in shares(sweeps["recorded"], sweep, sweeps["cast"], firings):
                    counts[name][row] += np.count_nonzero(of & right), np.count_nonzero(of)
            for one in DISTANCES:
                if sweep.intensity is not None or not one.name.startswith("intensity"):
                    measure = heights if one.name == _HEIGHT else one.measure
                    features[name][one.name].append(measure(sweep))
    table: Table = defaultdict(dict)
    for name, counted in counts.items():
        for row, (part, whole) in counted.items():
            # a class has rows where it was recorded often enough
            returns = counted[row.replace("IoU of", "near, on")][1]
            if whole and (returns >= FEWEST or row.startswith("drop")):
                table[row][name] = float(part / whole)
    for one in DISTANCES:
        truth = features["recorded"][one.name]
        for name in counts:
            mine = features[name][one.name]
            if mine and (one.name.startswith("top view") or np.sum(truth) >= FEWEST):
                table[one.name][name] = one.distance(truth, mine)
    return table


def losses(table: Table) -> dict[str, float]:
    """By how much the simulated scan is worse than the cast with the sensor model, by row; below 0, better."""
    found = {}
    for row, cells in table.items():
        if not row.startswith("dropped") and {"+ sensor model", "simulated"} <= set(cells):
            more = cells["simulated"] - cells["+ sensor model"]
            found[row] = -more if row in BETTER_IF_MORE or row.startswith(("near", "IoU")) else more
    return found


def markdown(table: Table) -> str:
    """The table, and what is worse in it."""
    loss = losses(table)
    worse = [f"{row} by {value:.3f}" for row, value in loss.items() if value > EQUAL]
    better = sum(value < -EQUAL for value in loss.values())
    said = f"Simulated beside cast and sensor model, of {len(loss)} rows: {better} better, {len(worse)} worse"
    text = f"{tables.table(table)}\n\n{said}"
    return f"{text} ({', '.join(worse)})." if worse else f"{text}."


def summary(tables: dict[str, Table]) -> str:
    """All sets in one table: the cast with the sensor model -> the simulated scan."""
    rows = dict.fromkeys(row for table in tables.values() for row in losses(table))
    lines = [f"| | {' | '.join(tables)} |", f"|---|{'---|' * len(tables)}"]
    for row in rows:
        pairs = [
            (table.get(row, {}).get("+ sensor model"), table.get(row, {}).get("simulated")) for table in tables.values()
        ]
        cells = ["" if a is None or b is None else f"{_digits(a)} → {_digits(b)}" for a, b in pairs]
        lines.append(f"| {row} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _digits(value: float) -> str:
    return f"{value:.2f}" if value >= 0.1 else f"{value:.2g}"


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--streets", type=int, default=50, metavar="N", help="how many streets (default 50)")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    parser.add_argument("--page", action="store_true", help="write the summary to its page in benches/results")
    parser.add_argument("--only", default="", metavar="NAME", help="sets whose names hold this")
    given = parser.parse_args()
    sets = list(recorded_sets(given.data)) if given.data is not None else []
    tables, counts = {}, []
    for name, make in [*sets, ("streets, HDL-64E", partial(street_set, given.streets))]:
        if given.only not in name:
            continue
        cases = make()
        if cases.cases:
            tables[name] = report(cases)
            counts.append(f"{len(cases.cases)} of {name}")
            print(f"### {name}, {len(cases.cases)} scans\n\n{markdown(tables[name])}\n", flush=True)
    print(summary(tables))
    if given.page:
        write_page("report_simulate", f"{PAGE} Scans: {'; '.join(counts)}.", summary(tables))


if __name__ == "__main__":
    main()
