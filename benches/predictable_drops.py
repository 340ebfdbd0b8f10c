"""How much of which rays recordings lose can be told from a layout at all.

    python benches/predictable_drops.py [--data FOLDER]

Layouts of PandaSet 001 and 002 are cast, and a classifier (scikit-learn's gradient boosting) learns on one drive which
of the hits have no return in the recording: from row, azimuth, range, class, height, and the steps of range to the
four neighbours. Its F1 on the other drive is the most that can be expected of a scan made of the layout. "best
threshold" loses the likeliest rays, at the threshold that is best in hindsight; "drawn" loses each ray with its chance,
as scans that look real must; "simulated" is the simulated scan's F1.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import numpy as np
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.metrics import f1_score

import recordings
from cases import CaseSet, clustered, sweeps_of
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS
from markdown_table import Row, table

THRESHOLDS = np.linspace(0.02, 0.9, 45)
Hits = tuple[np.ndarray, np.ndarray, np.ndarray]  # features [N, 9]; whether recording and simulated scan lose them


def hits(cases: CaseSet) -> Hits:
    """All hits of the casts of a set."""
    parts = []
    for sweeps in sweeps_of(cases):
        hit = sweeps["cast"].valid
        parts.append((features(sweeps["cast"])[hit], *(~sweeps[name].valid[hit] for name in ("recorded", "simulated"))))
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))  # type: ignore[return-value]


def features(cast: Sweep) -> np.ndarray:
    """What is known of each pixel of a cast [rows, columns, 9]."""
    assert cast.label is not None
    depth = cast.depth
    row, column = np.indices(depth.shape)
    steps = [np.roll(depth, shift, axis) - depth for axis in (0, 1) for shift in (1, -1)]
    return np.stack([row, column, depth, cast.label, cast.points[..., 2], *steps], axis=-1)


def measure(learned: Hits, judged: Hits) -> Row:
    """F1 on the hits of one drive of what was learned from another's."""
    classifier = HistGradientBoostingClassifier(max_iter=200, random_state=0).fit(learned[0], learned[1])
    chance = classifier.predict_proba(judged[0])[:, 1]
    drawn = np.random.default_rng(0).random(len(chance)) < chance
    _, lost, simulated = judged
    return {
        "hits": float(len(lost)),
        "lost": float(lost.mean()),
        "simulated": f1_score(lost, simulated),
        "best threshold": max(f1_score(lost, chance > threshold) for threshold in THRESHOLDS),
        "drawn": f1_score(lost, drawn),
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    given = parser.parse_args()
    if given.data is None:
        parser.error("give the folder of the recordings as --data or LIDARDRAFT_DATA")
    labelled = recordings.pandar64(given.data, 1800).labelled
    found = {name: hits(clustered(sweeps, PRESETS["pandar64"])) for name, sweeps in labelled.items()}
    rows = {f"{one} by {other}": measure(found[other], found[one]) for one in found for other in found if one != other}
    print(table(rows))


if __name__ == "__main__":
    main()
