"""`lidardraft draft`: the layout of an input, to look at and to edit."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

from lidardraft.cli.arguments import add_sensor, read_sensor
from lidardraft.cli.inputs import add_inputs, read_layout
from lidardraft.cli.layout_file import check_ending, write_layout
from lidardraft.scene.layout import Layout
from lidardraft.scene.sensor import Sensor


def draft(arguments: argparse.Namespace) -> None:
    """Make a layout, a file of boxes and other shapes that can be edited, from a sentence, a labelled scan, a sketch,
    boxes, a 3D model or a Blender script."""
    check_ending(arguments.output)
    sensor = read_sensor(arguments.sensor)
    layout = read_layout(arguments)
    write_layout(arguments.output, layout)
    objects = len(layout.boxes())
    print(f"{arguments.output}: shapes: {len(layout)}, objects with a box: {objects}")
    if not arguments.no_preview:
        path = Path(arguments.output).with_suffix(".preview.png")
        _write_preview(path, layout, sensor, arguments.seed)
        print(f"{path}: the layout from above, and a simulated scan of it")


def _write_preview(path: Path, layout: Layout, sensor: Sensor, seed: int) -> None:
    from lidardraft.simulation.simulate import Simulator
    from lidardraft.view import render_preview, save_png

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a layout without ground may be meant
        scan = Simulator(layout, sensor, seed=seed).scan(seed=seed)
    save_png(path, render_preview(layout, scan.image, scan.pose))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    inputs = add_inputs(parser)
    add_sensor(inputs, of=" that took --points or --boxes, for its height over the road, and of the preview's scan")
    output = parser.add_argument_group("output")
    text = "where the layout goes; .obj, .glb and .py (a Blender script) are for 3D modelling programs"
    output.add_argument("-o", "--output", required=True, metavar="LAYOUT.json", help=text)
    text = "leave out LAYOUT.preview.png, a picture of the layout from above and of a simulated scan"
    output.add_argument("--no-preview", action="store_true", help=text)
