"""`lidardraft draft`: the layout of an input, to look at and to edit."""

from __future__ import annotations

import argparse

from lidardraft.cli.arguments import add_sensor
from lidardraft.cli.inputs import add_inputs, read_layout
from lidardraft.cli.layout_file import check_ending, write_layout


def draft(arguments: argparse.Namespace) -> None:
    """Make a layout, a file of boxes and other shapes that can be edited, from a sentence, a labelled scan, a 3D model
    or a Blender script."""
    check_ending(arguments.output)
    layout = read_layout(arguments)
    write_layout(arguments.output, layout)
    objects = len(layout.boxes())
    print(f"{arguments.output}: shapes: {len(layout)}, objects with a box: {objects}")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    inputs = add_inputs(parser, layout=False)
    add_sensor(inputs, of=" that took --points, for its height over the road")
    output = parser.add_argument_group("output")
    text = "where the layout goes; .obj, .glb and .py (a Blender script) are for 3D modelling programs"
    output.add_argument("-o", "--output", required=True, metavar="LAYOUT.json", help=text)
