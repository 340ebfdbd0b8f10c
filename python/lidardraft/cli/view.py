"""`lidardraft view`: a picture of a file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.array_files import names_in
from lidardraft.cli.arguments import DEFAULT_SENSOR, add_log, add_reading, add_sensor, read_sensor, reading
from lidardraft.cli.command import add_json, progress, report, say
from lidardraft.cli.inputs import boxes_of_scan, sensor_of_scan
from lidardraft.errors import FormatError
from lidardraft.files import check_other_file, named, write_text
from lidardraft.scene.box import Box
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor

_PAIRS_SHOWN = 6
_MOVED = 5.0  # m, more than a sensor moves in half a sweep
_SHOWN_FOR = 0.5  # s, of scans that are not a sequence


def view(arguments: argparse.Namespace) -> None:
    """Write a picture, a page or a film."""
    from lidardraft.formats.rosbag import is_bag
    from lidardraft.view import html_page, save_png

    path = Path(arguments.path)
    if path.is_dir() and not is_bag(path):
        _film(path, arguments)
        return
    output = Path(arguments.output) if arguments.output else path.with_suffix(".view.png")
    check_other_file(output, path)
    if output.suffix not in (".png", ".html"):
        raise FormatError(f"{output} would hold a picture or a page; its name must end in .png or .html")
    if output.suffix == ".html":
        shown = _shown(path, arguments)
        write_text(output, html_page(**shown))
    else:
        save_png(output, _pictured(path, arguments))
    report(arguments, str(output), output=str(output))


def _film(folder: Path, arguments: argparse.Namespace) -> None:
    """Write a film of the scans of a folder, from above and from the driver's seat, at their recorded pace."""
    from lidardraft.exports import scans_in
    from lidardraft.scan import Scan
    from lidardraft.view import save_gif, save_mp4

    if arguments.sensor is not None or arguments.classes or arguments.large or arguments.boxes is not None:
        raise FormatError(f"{folder} is a folder; --sensor, --classes, --large and --boxes are for one file")
    names = scans_in(folder)
    output = Path(arguments.output or folder / "view.gif")
    save = {".gif": save_gif, ".mp4": save_mp4}.get(output.suffix)
    if save is None:
        raise FormatError(f"{output} would hold a film; its name must end in .gif or .mp4")
    first, second = (Scan.load(name).time for name in (names[0], names[min(1, len(names) - 1)]))
    seconds = second - first if first is not None and second is not None and second > first else _SHOWN_FOR
    with progress(len(names), "scan") as bar:
        save(output, (_framed(name, bar) for name in names), seconds)
    report(arguments, str(output), output=str(output))


def _framed(name: Path, bar: Any) -> np.ndarray:
    from lidardraft.scan import Scan
    from lidardraft.view import render_frame, title_of

    scan = Scan.load(name)
    up = np.array([0.0, 0.0, scan.image.sensor.mount_height])
    boxes = [box.raised(up[2]) for box in scan.boxes()]
    when = "" if scan.time is None else f"{scan.time:.1f} s, {scan.speed:.0f} m/s: "
    bar.update()
    return render_frame(scan.image, scan.points() + up, boxes=boxes, title=when + title_of(scan.layout))


def view_options(parser: argparse.ArgumentParser) -> None:
    """The options of `view`."""
    text = "a scan of any format, a range image, pairs, a layout, or a folder of scans"
    parser.add_argument("path", metavar="FILE", help=text)
    text = f" that took a scan or sees a layout (default the scan's own, or {DEFAULT_SENSOR})"
    add_sensor(parser, default=None, of=text)
    add_reading(parser)
    add_log(parser)
    text = "colour the points by class, in place of height; objects always have the colours of their classes"
    parser.add_argument("--classes", action="store_true", help=text)
    parser.add_argument("--large", action="store_true", help="one large and smooth view of a scan alone")
    text = "boxes around the objects of a scan: .boxes.json, KITTI's label_2, ... (default: the .boxes.json beside it)"
    parser.add_argument("--boxes", metavar="FILE", help=text)
    text = "file of the picture (default FILE.view.png); .html makes a page of a scan; of a folder, a film: .gif "
    text += "(default view.gif in it) or .mp4"
    parser.add_argument("-o", "--output", metavar="PICTURE", help=text)
    add_json(parser)


def _pictured(path: Path, arguments: argparse.Namespace) -> np.ndarray:
    from lidardraft.formats.pairs import is_shard, read_shard
    from lidardraft.view import points_on_road, render_large, render_layout_and_cast, render_pair, render_returns, sheet

    name: str | None = arguments.sensor
    if path.suffix == ".json":
        return render_layout_and_cast(Layout.load(path), read_sensor(DEFAULT_SENSOR if name is None else name))
    if not _holds_points(path) and is_shard(path):
        _check_no_sensor(path, name)
        pairs = read_shard(path)
        if len(pairs) > _PAIRS_SHOWN:
            say(f"{path} holds {len(pairs)} pairs; the picture shows the first {_PAIRS_SHOWN}")
        return sheet([render_pair(pair.scan, pair.condition_image) for pair, _ in pairs[:_PAIRS_SHOWN]])
    points, fields, sensor, image = _read_scan(path, arguments)
    if image is None:
        with named(path):
            image = RangeImage.project(points, sensor, **fields)
    boxes, render = _boxes(path, arguments, sensor), render_large if arguments.large else render_returns
    return render(image, points_on_road(image), boxes=boxes, title=_title(path), by_label=arguments.classes)


def _shown(path: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    """The arguments of `html_page` for a scan: every return, relative to the road."""
    from lidardraft.formats.pairs import is_shard
    from lidardraft.view import fields_of

    if path.suffix == ".json" or (not _holds_points(path) and is_shard(path)):
        raise FormatError(f"{path} is not a scan; a page of HTML shows scans alone")
    points, fields, sensor, image = _read_scan(path, arguments)
    beside = path.with_suffix(".npz")  # of a scan of lidardraft, whose .bin has the same order
    if image is None and path.suffix == ".bin" and beside.exists() and "depth" in names_in(beside):
        image = RangeImage.load(beside)
    ranges = np.linalg.norm(points, axis=1)
    depth = np.zeros(0) if image is None else image.depth[image.valid]
    known = {"range": ranges, **fields}
    if image is not None and len(depth) == len(ranges) and np.abs(depth - ranges).max(initial=0.0) < _MOVED:
        known = fields_of(image) | fields
    points, boxes = np.add(points, (0.0, 0.0, sensor.mount_height)), _boxes(path, arguments, sensor)
    return {"points": points, "fields": known, "boxes": boxes, "title": _title(path)}


def _holds_points(path: Path) -> bool:
    from lidardraft.formats.recording import SCAN_ENDINGS, is_log

    if not path.name.endswith(SCAN_ENDINGS) and not is_log(path):
        kind = path.suffix or "a file without an ending"
        raise FormatError(f"{path}: there is no picture of {kind}; it must be {', '.join(SCAN_ENDINGS)} or .json")
    return path.suffix != ".npz" or "xyz" in names_in(path)


def _check_no_sensor(path: Path, name: str | None) -> None:
    if name is not None:
        raise FormatError(f"{path} names its own sensor; --sensor is for .bin and .json files")


def _title(path: Path) -> str:
    from lidardraft.view import title_of

    beside = path.with_suffix(".layout.json")
    return (title_of(Layout.load(beside)) if beside.exists() else "") or path.name


def _read_scan(
    path: Path, arguments: argparse.Namespace
) -> tuple[np.ndarray, dict[str, np.ndarray], Sensor, RangeImage | None]:
    """The returns [N, 3] of a scan in any form that --points reads, or of a range image, which is returned too."""
    from lidardraft.formats.recording import read_returns

    if _holds_points(path):
        points, fields = read_returns(path, needs_intensity=False, **reading(arguments))
        known = {field: values for field, values in fields.items() if field in ("label", "instance", "intensity")}
        return points, known, sensor_of_scan(path, arguments.sensor), None
    _check_no_sensor(path, arguments.sensor)
    image = RangeImage.load(path)
    images = {"label": image.label, "intensity": image.intensity}
    known = {field: values[image.valid] for field, values in images.items() if values is not None}
    return image.points(), known, image.sensor, image


def _boxes(path: Path, arguments: argparse.Namespace, sensor: Sensor) -> list[Box]:
    return [box.raised(sensor.mount_height) for box in boxes_of_scan(path, arguments.boxes) or []]
