"""What generated scans are worth: `make report-generate`.

    python benches/report_generate.py [-n 50] [--weights NAME] [--sensor NAME] [--only PART] [--data FOLDER]

"streets" are scored as by `lidardraft evaluate`, which explains the columns. "recordings" holds scans of the layouts of
labelled recordings in FOLDER (by default LIDARDRAFT_DATA), at most `-n` a sensor, against these (`report_simulate.py`
explains the rows). "speed" is the time and memory of a scan. In each table of scores stand what is passed through and
the same network untrained. The goals come last. `--only` takes the parts whose names hold PART.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from cases import recorded_sets
from generated_speed import measure_speed
from lidardraft import Pipeline, Sensor
from lidardraft.cli.arguments import add_sensor, add_weights, read_pipeline, read_sensor, whole_number
from lidardraft.evaluation import Scores, evaluate, unseen_streets, untrained
from report_simulate import report
from tables import Goal, Row, goal_table, table


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("-n", "--num", type=whole_number(2), default=50, help="streets, and recordings at most")
    add_weights(parser)
    add_sensor(parser, of=" of the streets")
    parser.add_argument("--only", default="", metavar="PART", help="parts whose names hold this")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    given = parser.parse_args()
    pipeline = read_pipeline(given)
    goals = list(printed(parts(pipeline, given)))
    if goals:
        print(f"### Goals\n\n{goal_table(goals)}")


def parts(pipeline: Pipeline, given: argparse.Namespace) -> Iterator[str | Goal]:
    """All that was asked for: texts, and goals."""
    sensor = read_sensor(given.sensor)
    if given.only in "streets":
        yield from compare_on_streets(pipeline, sensor, given.num)
    if given.only in "recordings" and given.data is not None:
        yield from compare_with_recordings(pipeline, given.data, given.num)
    if given.only in "speed":
        yield from measure_speed(given.weights)


def compare_on_streets(pipeline: Pipeline, sensor: Sensor, number: int) -> Iterator[str | Goal]:
    """The table of `lidardraft evaluate`, then the goals."""
    rows = {scores.name: numbers(scores) for scores in evaluate(pipeline, unseen_streets(number, sensor=sensor))}
    yield f"### Streets, {sensor.name}, {number} scans\n\n{table(rows)}\n"
    made = rows["generated"]
    yield Goal("objects that stand as in their own layout", {"objects": made["objects"]}, least=0.66)
    yield Goal("... as in the layout of another street", {"other": made["other"]}, most=0.08)
    yield Goal("JSD to the streets' own scans", {"bev": made["bev"]}, most=0.12)
    lost = {"drop": made["drop"] - rows["detailed scan"]["drop"]}
    yield Goal("rays lost, minus those of the detailed scans", lost, least=-0.01, most=0.01)


def numbers(scores: Scores) -> Row:
    """The scores that are one number."""
    return {name: value for name, value in vars(scores).items() if isinstance(value, float)}


def compare_with_recordings(pipeline: Pipeline, folder: Path, number: int) -> Iterator[str]:
    """A table of each set of recordings, of `number` scans at most."""
    for name, make in recorded_sets(folder):
        cases = make()
        chosen = np.unique(np.linspace(0, len(cases.cases) - 1, number).astype(int)) if cases.cases else []
        if len(chosen):
            both = {"generated": pipeline, "untrained": untrained(pipeline)}
            rows = report(replace(cases, cases=[cases.cases[k] for k in chosen]), both)
            yield f"### {name}, {len(chosen)} scans\n\n{table(rows)}\n"


def printed(found: Iterable[str | Goal]) -> Iterator[Goal]:
    """The goals; texts are printed as they come."""
    for one in found:
        if isinstance(one, Goal):
            yield one
        else:
            print(one, flush=True)


if __name__ == "__main__":
    main()
