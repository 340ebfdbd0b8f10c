"""`lidardraft evaluate`: scores of generated scans."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from lidardraft.cli.arguments import add_seed, add_sensor, add_weights, read_sensor, whole_number
from lidardraft.scene.sensor import Sensor

if TYPE_CHECKING:
    from lidardraft.evaluation import Scores
    from lidardraft.pipeline import Pipeline
    from lidardraft.streets import StreetPair

_SEED = 1_000_000  # of streets that no training used


def evaluate(arguments: argparse.Namespace) -> None:
    """Score generated scans of unseen streets: how well they keep to their layouts, and how much they look like
    scans."""
    from lidardraft.pipeline import Pipeline

    sensor, num = read_sensor(arguments.sensor), arguments.num
    pipeline = Pipeline.from_pretrained(
        arguments.weights, device=arguments.device, steps=arguments.steps, start=arguments.start
    )
    pairs = unseen_streets(num, sensor, arguments.seed)
    print(f"{num} street{'s' * (num > 1)}, {sensor.name}, {arguments.steps} steps")
    print(f"{'':16}{'objects':>9}{'all':>9}{'drop':>9}{'BEV JSD':>9}{'holes':>9}{'lone':>9}", flush=True)
    for row in scores(pipeline, pairs):
        numbers = (row.objects, row.overall, row.drop, row.jsd, row.holes, row.lone)
        print(f"{row.name:16}{''.join(f'{number:9.3f}' for number in numbers)}")
        print(f"    all, by class: {_by_class(row.by_class)}")
        if row.intensity:
            print(f"    intensity (JSD), by class: {_by_class(row.intensity)}")
        sys.stdout.flush()


def _by_class(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in values.items())


def unseen_streets(num: int, sensor: Sensor, seed: int = _SEED) -> list[StreetPair]:
    """Streets to score on, made behind a progress bar."""
    from tqdm import tqdm

    from lidardraft import evaluation

    with tqdm(total=num, unit="street", desc="making streets", disable=None, leave=False) as bar:
        return evaluation.unseen_streets(num, sensor=sensor, seed=seed, on_street=bar.update)


def scores(pipeline: Pipeline, pairs: list[StreetPair]) -> Iterator[Scores]:
    """The rows of scores, under a progress bar that is out of the way while one is printed."""
    from tqdm import tqdm

    from lidardraft import evaluation

    with tqdm(total=2 * len(pairs), unit="scan", desc="generating", disable=None, leave=False) as bar:
        for row in evaluation.evaluate(pipeline, pairs, on_scan=bar.update):
            bar.clear()
            yield row


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    parser.epilog = (
        "objects, all: share of the returns on objects, or on anything, within 0.5 m or 5 % of the layout. drop: share "
        "of the rays that hit the layout and return nothing. BEV JSD: how far the top views are from those of the "
        "detailed scans; 0 is equal. holes: of the places between two returns of a surface within 20 m, the share that "
        "returns nothing. lone: share of the returns that have no neighbour within 0.5 m and 3 %. intensity (JSD): how "
        "far the intensities of a class are from those of the detailed scans. These are by the sensor model, as the "
        "simulated ones are: so it says how much the generator changes, not whether it comes nearer to recordings. "
        "untrained: the same network with random weights; where it has a copy gate it keeps the simulated depths, so "
        "that training shows in what differs from this row."
    )
    add_sensor(parser)
    add_weights(parser)
    parser.add_argument(
        "-n", "--num", type=whole_number(1), default=50, metavar="N", help="streets to score (default 50)"
    )
    add_seed(parser, default=_SEED)
