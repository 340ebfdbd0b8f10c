"""`lidardraft simulate`: labelled scans by physics alone, into a folder of their own."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from lidardraft.cli.arguments import add_speed, add_weather, number, read_sensor, read_weather
from lidardraft.cli.inputs import add_inputs, read_layout
from lidardraft.cli.scan_folder import add_scan_output, check_output, layouts, write_scans
from lidardraft.scene.layout import Layout
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.weather import Weather

if TYPE_CHECKING:
    from lidardraft.scan import Scan


def simulate(arguments: argparse.Namespace) -> None:
    """Make labelled LiDAR scans by physics alone, from a sentence, a layout, a 3D model or a labelled scan."""
    check_output(arguments)
    sensor, weather = read_sensor(arguments.sensor), read_weather(arguments.weather)
    layout = read_layout(arguments)
    write_scans(arguments, _simulated(arguments, sensor, weather, layout))


def _simulated(arguments: argparse.Namespace, sensor: Sensor, weather: Weather, layout: Layout) -> Iterator[Scan]:
    from tqdm import tqdm

    from lidardraft.simulation.simulate import Simulator

    with tqdm(total=arguments.num, unit="scan", disable=None) as bar:
        for seed, each in layouts(arguments, layout):
            simulator = Simulator(each, sensor, seed=seed, weather=weather, clutter=arguments.clutter)
            yield simulator.scan(speed=arguments.speed, seed=seed)
            bar.update()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    parser.epilog = (
        "The layout's shapes become objects with details, the sensor's beams are cast into them, and a model of its "
        "light and receiver makes returns, ranges and intensities of that. No weights are used; every label is that of "
        "the surface that was hit. A sensor without a model of its own gets typical values."
    )
    add_inputs(parser)
    world = parser.add_argument_group("world")
    add_weather(world)
    add_speed(world)
    text = "what stands beside the roads and is not in the layout, from 0 (nothing) to 1 (default 0)"
    world.add_argument("--clutter", type=number, default=0.0, metavar="SHARE", help=text)
    add_scan_output(parser)
