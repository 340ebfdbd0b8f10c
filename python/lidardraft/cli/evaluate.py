"""`lidardraft evaluate`: scores of generated scans."""

from __future__ import annotations

import argparse

from lidardraft.cli.arguments import add_seed, add_sensor, add_weights, whole_number
from lidardraft.scene.sensor import Sensor


def evaluate(arguments: argparse.Namespace) -> None:
    """Score generated scans of unseen streets: how well they keep to their layouts, and how much they look like
    scans."""
    from tqdm import tqdm

    from lidardraft import evaluation
    from lidardraft.pipeline import Pipeline

    sensor, num = Sensor.preset(arguments.sensor), arguments.num
    pipeline = Pipeline.from_pretrained(arguments.weights, device=arguments.device, steps=arguments.steps)
    with tqdm(total=num, unit="street", desc="making streets", disable=None, leave=False) as bar:
        pairs = evaluation.unseen_streets(num, sensor=sensor, seed=arguments.seed, on_street=bar.update)
    print(f"{num} street{'s' * (num > 1)}, {sensor.name}, {arguments.steps} steps")
    print(f"{'':16}{'objects':>9}{'all':>9}{'drop':>9}{'BEV JSD':>9}", flush=True)
    with tqdm(total=2 * num, unit="scan", desc="generating", disable=None, leave=False) as bar:
        for row in evaluation.evaluate(pipeline, pairs, on_scan=bar.update):
            bar.clear()
            print(f"{row.name:16}{row.objects:9.3f}{row.overall:9.3f}{row.drop:9.3f}{row.jsd:9.3f}")
            print(" " * 4 + ", ".join(f"{name} {share:.2f}" for name, share in row.by_class.items()), flush=True)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    parser.epilog = (
        "objects, all: share of the returns on objects, or on anything, within 0.5 m or 5 % of the layout. drop: share "
        "of the rays that hit the layout and return nothing. BEV JSD: how far the top views are from those of the "
        "detailed scans; 0 is equal."
    )
    add_sensor(parser)
    add_weights(parser)
    parser.add_argument(
        "-n", "--num", type=whole_number(1), default=50, metavar="N", help="streets to score (default 50)"
    )
    add_seed(parser, default=1_000_000)
