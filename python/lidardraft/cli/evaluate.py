"""`lidardraft evaluate`: scores of generated scans, of unseen streets or beside recordings by a published protocol."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from lidardraft.cli.arguments import add_seed, add_sensor, add_weights, read_sensor, whole_number
from lidardraft.cli.command import progress
from lidardraft.cli.folder_scores import add_folder_options, evaluate_folders
from lidardraft.scene.sensor import Sensor

if TYPE_CHECKING:
    from lidardraft.evaluation import Scores
    from lidardraft.pipeline import Pipeline
    from lidardraft.streets import StreetPair

_SEED = 1_000_000  # of streets that no training used
# Fields of `Scores`, and what they are called.
_COLUMNS = {
    "objects": "objects",
    "other": "other",
    "overall": "all",
    "drop": "drop",
    "range": "range",
    "height": "height",
    "bev": "BEV",
    "classes": "classes",
    "holes": "holes",
    "lone": "lone",
    "own": "own",
}


def evaluate(arguments: argparse.Namespace) -> None:
    """Score generated scans: those of weights on unseen streets, or folders of scans beside recordings by a published
    protocol."""
    if (arguments.table, arguments.protocol, arguments.real, arguments.generated) == (None,) * 4:
        _evaluate_weights(arguments)
    else:
        evaluate_folders(arguments)


def _evaluate_weights(arguments: argparse.Namespace) -> None:
    """Print the scores of weights on unseen streets."""
    from lidardraft.pipeline import Pipeline

    sensor, num = read_sensor(arguments.sensor), arguments.num
    pipeline = Pipeline.from_pretrained(
        arguments.weights, device=arguments.device, steps=arguments.steps, guidance=arguments.guidance
    )
    pairs = unseen_streets(num, sensor, arguments.seed)
    half = ", half of each open" * pipeline.denoiser.config.completes
    print(f"{num} street{'s' * (num > 1)}, {sensor.name}{half}, {arguments.steps} steps")
    print(f"{'':16}{''.join(f'{name:>9}' for name in _COLUMNS.values())}", flush=True)
    for row in scores(pipeline, pairs):
        print(f"{row.name:16}{''.join(f'{getattr(row, field):9.3f}' for field in _COLUMNS)}")
        print(f"    all, by class: {_by_class(row.by_class)}")
        if row.intensity:
            print(f"    intensity (JSD), by class: {_by_class(row.intensity)}")
        sys.stdout.flush()


def _by_class(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in values.items())


def unseen_streets(num: int, sensor: Sensor, seed: int = _SEED) -> list[StreetPair]:
    """Streets to score on, made behind a progress bar."""
    from lidardraft import evaluation

    with progress(num, "street", "making streets", leave=False) as bar:
        return evaluation.unseen_streets(num, sensor=sensor, seed=seed, on_street=bar.update)


def scores(pipeline: Pipeline, pairs: list[StreetPair]) -> Iterator[Scores]:
    """The rows of scores, under a progress bar that is out of the way while one is printed."""
    from lidardraft import evaluation

    with progress(2 * len(pairs), "scan", "generating", leave=False) as bar:
        for row in evaluation.evaluate(pipeline, pairs, on_scan=bar.update):
            bar.clear()
            yield row


def evaluate_options(parser: argparse.ArgumentParser) -> None:
    """The options of `evaluate`."""
    parser.epilog = (
        "objects, all: share of the returns on objects, or on anything, within 0.5 m or 5 % of the layout; other: of "
        "those on objects, with the layout of another street. drop: share of the rays that hit the layout and return "
        "nothing. range, height, BEV, classes: Jensen-Shannon distances of ranges, heights, top views and classes from "
        "those of the detailed scans; 0 is equal. holes: of the places between two returns of a surface within 20 m, "
        "the share that returns nothing. lone: share of the returns that have no neighbour within 0.5 m and 3 %. own: "
        "share of the returns that are not the simulated scan's. intensity (JSD): how far the intensities of a class "
        "are from those of the detailed scans. Weights that complete are given half of each street: objects, other, "
        "all and drop are then of the given halves, and the rest is of the open ones; bare is a lawn there. untrained: "
        "the same network with random weights: what these and the rows before them reach too, training has not earned."
    )
    add_folder_options(parser)
    add_sensor(parser)
    add_weights(parser)
    parser.add_argument(
        "-n", "--num", type=whole_number(1), default=50, metavar="N", help="streets to score (default 50)"
    )
    add_seed(parser, default=_SEED)
