"""`lidardraft raycast`: what a sensor would measure of a layout of simple shapes."""

from __future__ import annotations

import argparse

from lidardraft.cli.arguments import add_sensor, read_sensor
from lidardraft.cli.inputs import add_inputs, read_layout
from lidardraft.scene.raycast import raycast as cast


def raycast(arguments: argparse.Namespace) -> None:
    """Cast the rays of a sensor into a layout: an .npz file with its depth, class and instance images, the condition
    image of the diffusion model."""
    sensor = read_sensor(arguments.sensor)
    image = cast(read_layout(arguments), sensor)
    image.save(arguments.output)
    print(f"{arguments.output}: {sensor.name}, {image.valid.mean():.0%} of the rays hit")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    add_inputs(parser)
    output = parser.add_argument_group("output")
    add_sensor(output)
    output.add_argument("-o", "--output", required=True, metavar="IMAGE.npz", help="where the range image goes")
