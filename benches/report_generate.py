"""What generated scans are worth beside simulated ones: `make report-generate`.

    python benches/report_generate.py [-n 50] [--weights NAME] [--steps 4] [--start 0.5] [--only NAME] [--data FOLDER]

The layouts are those of labelled recordings in FOLDER (by default LIDARDRAFT_DATA), at most `-n` a sensor, and of `-n`
unseen streets (by each further sensor a quarter of that). Scans by the weights are held against the recordings and the
streets' detailed scans, simulated ones of the same layouts beside them; then other starts and numbers of calls, the
spread over seeds, and the time of one scan. Last comes what was to be reached. The definitions: `scan_scores.py`,
`metrics/`. `--only` takes the parts whose names hold NAME: a set of recordings, "streets, SENSOR", "calls", "spread" or
"speed".
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from generated_recordings import compare_with_recordings
from generated_speed import measure_speed
from generated_streets import compare_on_streets, compare_sampling, compare_spread
from goals import Goal, goal_table
from lidardraft import Pipeline
from lidardraft.cli.arguments import add_weights, whole_number


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("-n", "--num", type=whole_number(2), default=50, help="streets, and recordings at most")
    add_weights(parser)
    parser.add_argument("--only", default="", metavar="NAME", help="parts whose names hold this")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    given = parser.parse_args()
    pipeline = Pipeline.from_pretrained(given.weights, device=given.device, steps=given.steps, start=given.start)
    goals = list(printed(parts(pipeline, given)))
    print(f"### Goals\n\n{goal_table([goal for goal in goals if goal.values])}")


def parts(pipeline: Pipeline, given: argparse.Namespace) -> Iterator[str | Goal]:
    """All that was asked for: texts, and goals."""
    if given.data is not None:
        yield from compare_with_recordings(given.data, pipeline, given.num, given.only)
    yield from compare_on_streets(pipeline, given.num, given.only)
    if given.only in "calls":
        yield from compare_sampling(pipeline, given.num)
    if given.only in "spread":
        yield from compare_spread(pipeline, given.num)
    if given.only in "speed":
        yield from measure_speed(given.weights, given.steps, given.start)


def printed(found: Iterable[str | Goal]) -> Iterator[Goal]:
    """The goals; texts are printed as they come."""
    for one in found:
        if isinstance(one, Goal):
            yield one
        else:
            print(one, flush=True)


if __name__ == "__main__":
    main()
