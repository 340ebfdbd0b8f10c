"""`lidardraft view`: a picture of a file."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from lidardraft.cli.arguments import DEFAULT_SENSOR, add_sensor, read_sensor
from lidardraft.cli.command import say
from lidardraft.cli.inputs import sensor_beside
from lidardraft.errors import FormatError
from lidardraft.files import check_other_file, named
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
    picture = _pictured(path, arguments.sensor)
    save_png(output, picture)
    print(output)


def view_options(parser: argparse.ArgumentParser) -> None:
    """The options of `view`."""
    parser.add_argument("path", metavar="FILE", help="a .bin, .pcd.bin, .pcd, .npz or .json file")
    add_sensor(
        parser, default=None, of=f" that took a scan or sees a layout (default the scan's own, or {DEFAULT_SENSOR})"
    )
    parser.add_argument("-o", "--output", metavar="PICTURE.png", help="where the picture goes (default FILE.view.png)")


def _pictured(path: Path, name: str | None) -> np.ndarray:
    from lidardraft.formats.pairs import is_shard, read_shard
    from lidardraft.formats.recording import is_points_file
    from lidardraft.view import render_file, render_pair, stack

    if path.suffix in (".bin", ".pcd") or (path.suffix == ".npz" and is_points_file(path)):
        return _pictured_points(path, name)
    if path.suffix != ".npz":
        return render_file(path, _sensor(path, name))
    if name is not None:
        raise FormatError(f"{path} says by which sensor it is; --sensor is for .bin and .json files")
    if not is_shard(path):
        return render_file(path, Sensor.preset(DEFAULT_SENSOR))
    pairs = read_shard(path)
    if len(pairs) > _PAIRS_SHOWN:
        say("lidardraft", f"{path} holds {len(pairs)} pairs; the picture shows the first {_PAIRS_SHOWN}")
    return stack([render_pair(pair.scan, pair.condition_image) for pair, _ in pairs[:_PAIRS_SHOWN]])


def _pictured_points(path: Path, name: str | None) -> np.ndarray:
    """The picture of a scan in any form that --points reads."""
    from lidardraft.formats.recording import read_points, returns
    from lidardraft.scene.range_image import RangeImage
    from lidardraft.view import render_range_image

    points, fields = read_points(path)
    with named(path):
        points, fields = returns(points, fields)
        known = {field: fields[field] for field in ("label", "instance", "intensity") if field in fields}
        return render_range_image(RangeImage.project(points, _sensor(path, name), **known))


def _sensor(path: Path, name: str | None) -> Sensor:
    if name is not None:
        return read_sensor(name)
    if path.suffix in (".bin", ".pcd", ".npz"):
        if sensor := sensor_beside(path):
            return sensor
        say("lidardraft", f"{path} is taken for a scan of {DEFAULT_SENSOR}; if it is not, give its --sensor")
    return Sensor.preset(DEFAULT_SENSOR)
