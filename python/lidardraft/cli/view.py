"""`lidardraft view`: a picture of a file."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from lidardraft.cli.arguments import DEFAULT_SENSOR, add_sensor, read_sensor
from lidardraft.cli.command import say
from lidardraft.cli.inputs import sensor_beside
from lidardraft.errors import FormatError
from lidardraft.files import check_other_file, named
from lidardraft.scene.box import Box
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor

_PAIRS_SHOWN = 6


def view(arguments: argparse.Namespace) -> None:
    """Render a picture of a scan (.bin, with the .label beside it, .pcd.bin, .pcd or .npz), a range image (.npz), a
    file of training pairs (.npz) or a layout (.json)."""
    from lidardraft.view import save_png

    path = Path(arguments.path)
    if path.is_dir():
        raise FormatError(f"{path} is a folder; give one of its .bin, .npz or .json files")
    output = Path(arguments.output) if arguments.output else path.with_suffix(".view.png")
    check_other_file(output, path)
    save_png(output, _pictured(path, arguments))
    print(output)


def view_options(parser: argparse.ArgumentParser) -> None:
    """The options of `view`."""
    parser.add_argument("path", metavar="FILE", help="a .bin, .pcd.bin, .pcd, .npz or .json file")
    add_sensor(
        parser, default=None, of=f" that took a scan or sees a layout (default the scan's own, or {DEFAULT_SENSOR})"
    )
    text = "colour the points by class, in place of height; objects always have the colours of their classes"
    parser.add_argument("--classes", action="store_true", help=text)
    parser.add_argument("--large", action="store_true", help="one large and smooth view of a scan alone")
    parser.add_argument("-o", "--output", metavar="PICTURE.png", help="where the picture goes (default FILE.view.png)")


def _pictured(path: Path, arguments: argparse.Namespace) -> np.ndarray:
    from lidardraft.formats.pairs import is_shard, read_shard
    from lidardraft.formats.recording import is_points_file
    from lidardraft.view import (
        points_on_road,
        render_large,
        render_layout_and_cast,
        render_pair,
        render_returns,
        sheet,
        title_of,
    )

    name: str | None = arguments.sensor
    if path.suffix == ".json":
        return render_layout_and_cast(Layout.load(path), _sensor(path, name))
    if path.suffix not in (".bin", ".pcd", ".npz"):
        kind = path.suffix or "a file without an ending"
        raise FormatError(f"{path}: there is no picture of {kind}; it must be .bin, .pcd, .npz or .json")
    boxes = list[Box]()
    if path.suffix != ".npz" or is_points_file(path):
        image, boxes = _read_scan(path, name)
    elif name is not None:
        raise FormatError(f"{path} says by which sensor it is; --sensor is for .bin and .json files")
    elif is_shard(path):
        pairs = read_shard(path)
        if len(pairs) > _PAIRS_SHOWN:
            say("lidardraft", f"{path} holds {len(pairs)} pairs; the picture shows the first {_PAIRS_SHOWN}")
        return sheet([render_pair(pair.scan, pair.condition_image) for pair, _ in pairs[:_PAIRS_SHOWN]])
    else:
        image = RangeImage.load(path)
    render = render_large if arguments.large else render_returns
    beside = path.with_suffix(".layout.json")
    title = title_of(Layout.load(beside)) if beside.exists() else ""
    return render(image, points_on_road(image), boxes=boxes, title=title or path.name, by_label=arguments.classes)


def _read_scan(path: Path, name: str | None) -> tuple[RangeImage, list[Box]]:
    """A scan in any form that --points reads, and the boxes of the .boxes.json beside it, over the road."""
    from lidardraft.formats.boxes import read_boxes
    from lidardraft.formats.recording import read_points, returns

    points, fields = read_points(path)
    sensor = _sensor(path, name)
    with named(path):
        points, fields = returns(points, fields)
        known = {field: fields[field] for field in ("label", "instance", "intensity") if field in fields}
        image = RangeImage.project(points, sensor, **known)
    beside = path.with_suffix(".boxes.json")
    boxes = read_boxes(beside)[0] if beside.exists() else []
    x_y_z = (0.0, 0.0, sensor.mount_height)
    return image, [replace(box, center=tuple(np.add(box.center, x_y_z).tolist())) for box in boxes]


def _sensor(path: Path, name: str | None) -> Sensor:
    if name is not None:
        return read_sensor(name)
    if path.suffix in (".bin", ".pcd", ".npz"):
        if sensor := sensor_beside(path):
            return sensor
        say("lidardraft", f"{path} is taken for a scan of {DEFAULT_SENSOR}; if it is not, give its --sensor")
    return Sensor.preset(DEFAULT_SENSOR)
