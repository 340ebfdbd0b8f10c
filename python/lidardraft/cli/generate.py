"""`lidardraft generate`: labelled scans by the diffusion model, into a folder of their own."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from lidardraft.cli.arguments import add_speed, add_weights, read_sensor, whole_number
from lidardraft.cli.inputs import add_inputs, read_layout
from lidardraft.cli.scan_folder import add_scan_output, check_output, layouts, write_scans
from lidardraft.scene.layout import Layout
from lidardraft.scene.sensor import Sensor

if TYPE_CHECKING:
    from lidardraft.pipeline import Pipeline
    from lidardraft.scan import Scan


def generate(arguments: argparse.Namespace) -> None:
    """Make labelled LiDAR scans with the diffusion model, from a sentence, a layout, a 3D model or a labelled scan."""
    check_output(arguments)
    sensor = read_sensor(arguments.sensor)
    layout = read_layout(arguments)

    from lidardraft.pipeline import Pipeline

    pipeline = Pipeline.from_pretrained(
        arguments.weights,
        device=arguments.device,
        steps=arguments.steps,
        langevin=arguments.langevin,
    )
    write_scans(arguments, _generated(pipeline, arguments, sensor, layout))


def _generated(pipeline: Pipeline, arguments: argparse.Namespace, sensor: Sensor, layout: Layout) -> Iterator[Scan]:
    from tqdm import tqdm

    with tqdm(total=arguments.num * arguments.steps, unit="step", disable=None) as bar:
        for number, (seed, each) in enumerate(layouts(arguments, layout), start=1):
            bar.set_description(f"scan {number} of {arguments.num}")
            yield pipeline(each, sensor=sensor, seed=seed, speed=arguments.speed, on_step=bar.update)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    parser.epilog = (
        "The weights `street` keep the simulated scan of what the layout gives, and make up what it leaves open: what "
        "stands around a sentence's road, a sketch or boxes, and what a picture does not show; another world for each "
        "seed. A recorded scan, a 3D model or a Blender script leaves nothing open: there `generate` adds nothing to "
        "`simulate`, and says so. The weights `paper` make the whole scan from noise, guided by the layout, as the "
        "paper does. Classes of what is made up are the network's. Weather and clutter are `simulate`'s alone: no "
        "weights have seen them."
    )
    add_inputs(parser)
    add_speed(parser.add_argument_group("world"))
    model = parser.add_argument_group("model")
    add_weights(model)
    text = (
        "sample by annealed Langevin dynamics as the paper does, with N updates a step (LiDARGen: --steps 232 "
        "--langevin 5): slow (default: the fast solver)"
    )
    model.add_argument("--langevin", type=whole_number(1), metavar="N", help=text)
    add_scan_output(parser)
