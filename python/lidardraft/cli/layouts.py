"""`lidardraft draft` and `raycast`: the layout of an input, to view and to edit, and its cast."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from lidardraft.cli.arguments import add_sensor, in_folder, read_sensor
from lidardraft.cli.command import add_json, report, say
from lidardraft.cli.inputs import add_inputs, around_it, ego_of_points, input_of, read_layout
from lidardraft.errors import FormatError
from lidardraft.files import check_other_file, named
from lidardraft.scene.layout import Layout
from lidardraft.scene.raycast import raycast as cast
from lidardraft.scene.sensor import Sensor

_ENDINGS = (".json", ".obj", ".glb", ".py")
_MOST_SHAPES, _MOST_TRIANGLES = 2_000, 100_000  # of a layout with a quick preview


def draft(arguments: argparse.Namespace) -> None:
    """Write the layout of an input, with a preview, and for a bag the trajectory of the ego vehicle."""
    arguments.output = in_folder(arguments.output, "layout.json")
    ending = Path(arguments.output).suffix.lower()
    if ending not in _ENDINGS:
        raise FormatError(f"{arguments.output}: a layout is written as {', '.join(_ENDINGS)}; the ending decides")
    check_other_file(arguments.output, input_of(arguments))
    sensor = read_sensor(arguments.sensor)
    layout, scenario = read_layout(arguments), ego_of_points(arguments)
    # before anything is written: a layout that cannot be simulated replaces no file
    with named(f"{input_of(arguments)}: no preview can be made (--no-preview leaves it out)"):
        picture = None if arguments.no_preview else _preview(layout, sensor, arguments.seed)
    _writer(ending)(arguments.output, layout)
    objects = len(layout.boxes())
    text = f"{arguments.output}: shapes: {len(layout)}, objects with a box: {objects}{around_it(layout)}"
    report(arguments, text, output=arguments.output, shapes=len(layout), objects=objects)
    if scenario is not None:
        replay = Path(arguments.output).with_suffix(".scenario.json")
        scenario.save(replay)
        text = f"{replay}: how the ego vehicle went on, for `simulate --scenario`"
        report(arguments, text, scenario=str(replay))
    path = Path(arguments.output.removesuffix(".json") + ".preview.png")  # x.glb and x.json have different ones
    if picture is not None:
        from lidardraft.view import save_png

        save_png(path, picture)
        report(arguments, f"{path}: the layout from above, and a simulated scan of it", preview=str(path))
    elif not arguments.no_preview:
        limits = f"{_MOST_SHAPES} shapes and {_MOST_TRIANGLES} triangles"
        older = ""
        if path.is_file():  # it shows another layout
            path.unlink()
            older = ", and the older one is removed"
        say(f"{path} is not made: the layout has more than {limits}{older}")


def _writer(ending: str) -> Callable[[str, Layout], None]:
    from lidardraft.formats.blender_script import write_blender_script
    from lidardraft.formats.glb import write_glb
    from lidardraft.formats.obj import write_obj

    if ending == ".json":
        return lambda path, layout: layout.save(path)
    return {".obj": write_obj, ".glb": write_glb, ".py": write_blender_script}[ending]


def _preview(layout: Layout, sensor: Sensor, seed: int) -> np.ndarray | None:
    """The picture of a layout, uint8 [H, W, 3]; None if it would take long."""
    triangles = sum(len(primitive.mesh.faces) for primitive in layout if primitive.mesh is not None)
    if len(layout) > _MOST_SHAPES or triangles > _MOST_TRIANGLES:
        return None
    from lidardraft.simulation.simulate import Simulator
    from lidardraft.view import render_preview

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a layout without ground may be intended
        scan = Simulator(layout, sensor, seed=seed).scan(seed=seed)
        return render_preview(layout, scan.image, scan.pose)


def draft_options(parser: argparse.ArgumentParser) -> None:
    """The options of `draft`."""
    inputs = add_inputs(parser)
    add_sensor(inputs, of=" that took --points or --boxes, for its height over the road, and of the preview's scan")
    output = parser.add_argument_group("output")
    text = "file of the layout, or a folder for layout.json; .obj, .glb and .py (a Blender script) are for 3D "
    text += "modelling programs"
    output.add_argument("-o", "--output", required=True, metavar="LAYOUT.json", help=text)
    text = "leave out LAYOUT.preview.png, a picture of the layout from above and of a simulated scan"
    output.add_argument("--no-preview", action="store_true", help=text)
    add_json(parser)


def raycast(arguments: argparse.Namespace) -> None:
    """Write the range image of a layout, and the layout beside it."""
    arguments.output = in_folder(arguments.output, "cast.npz")
    sensor = read_sensor(arguments.sensor)
    layout, beside = read_layout(arguments), Path(arguments.output).with_suffix(".layout.json")
    if not (given := beside.exists() and Layout.load(beside) == layout):
        check_other_file(beside, input_of(arguments))
    image = cast(layout, sensor)
    image.save(arguments.output)
    if not given:
        layout.save(beside)
    hit = float(image.valid.mean())
    text = f"{arguments.output}: {sensor.name}, {hit:.0%} of the rays hit"
    report(arguments, text, output=arguments.output, sensor=sensor.name, hit=hit)


def raycast_options(parser: argparse.ArgumentParser) -> None:
    """The options of `raycast`."""
    add_inputs(parser)
    output = parser.add_argument_group("output")
    add_sensor(output)
    output.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="IMAGE.npz",
        help="file of the range image, or a folder for cast.npz",
    )
    add_json(parser)
