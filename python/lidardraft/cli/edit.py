"""`lidardraft edit`: objects of a recorded scan inserted, removed, moved and replaced."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lidardraft.cli.arguments import DEFAULT_SENSOR, add_log, add_reading, add_seed, add_sensor, in_folder, reading
from lidardraft.cli.command import add_json, report, say
from lidardraft.cli.inputs import boxes_of_scan, sensor_of_scan
from lidardraft.errors import FormatError
from lidardraft.files import check_other_file, named

if TYPE_CHECKING:
    from lidardraft.simulation.recorded.recorded_scan import RecordedScan
    from lidardraft.simulation.recorded.scan_edits import Edit

_NUMBER = r"([-+]?\d+(?:\.\d*)?)"
_INSERTED = re.compile(
    rf"(?:an? )?([a-z]+(?:[- ][a-z]+)*) at {_NUMBER}, *{_NUMBER}(?: yaw {_NUMBER})?"
    rf"(?: size {_NUMBER}, *{_NUMBER}, *{_NUMBER})?"
)
_PLACE = re.compile(rf"{_NUMBER}, *{_NUMBER}(?:, *{_NUMBER})?")


def edit(arguments: argparse.Namespace) -> None:
    """Write the edited scan, or list the objects of the scan."""
    scan = _read(arguments)
    edits = arguments.edits or []
    if not edits:
        if arguments.output is not None:
            raise FormatError(f"{arguments.scan}: no edit; give --insert, --remove, --move or --replace")
        return _list(arguments, scan)
    if arguments.output is None:
        raise FormatError("--output is missing: the file of the edited scan")
    from lidardraft.formats.recording import SCAN_ENDINGS
    from lidardraft.simulation.recorded.recorded_scan import FILLED, INSERTED
    from lidardraft.simulation.recorded.scan_edits import edit_scan

    output = Path(in_folder(arguments.output, Path(arguments.scan).name.partition(".")[0]))
    output = output.with_suffix("") if output.suffix in (".bin", ".npz") else output
    if output.suffix in SCAN_ENDINGS:
        raise FormatError(f"{arguments.output}: an edited scan is a .bin and an .npz; give a name without an ending")
    for given in filter(None, (arguments.scan, arguments.labels, arguments.boxes, arguments.sensor)):
        for ending in (".bin", ".label", ".npz", ".boxes.json", ".sensor.json"):
            check_other_file(f"{output}{ending}", given)
    with named(arguments.scan):
        edited = edit_scan(scan, edits, seed=arguments.seed)
    edited.save(output)
    counts = f"{edited.returned.sum()} returns, {(edited.made_up == INSERTED).sum()} inserted"
    filled = (edited.made_up == FILLED).sum()
    text = f"{output}.bin: {counts} and {filled} filled, with .label, .npz, .boxes.json and .sensor.json"
    report(arguments, text, output=f"{output}.bin", returns=int(edited.returned.sum()))


def _read(arguments: argparse.Namespace) -> RecordedScan:
    from lidardraft.formats.recording import read_labels, read_points, with_fields
    from lidardraft.simulation.recorded.recorded_scan import RecordedScan

    path = arguments.scan
    points, fields = read_points(path, **reading(arguments))
    if arguments.edits and "intensity" not in fields:
        say(f"{path}: it has no intensities{with_fields(path)}: recorded returns read 0")
    if arguments.labels is not None:
        fields |= read_labels(arguments.labels, len(points), of=path)
    sensor, boxes = sensor_of_scan(path, arguments.sensor), boxes_of_scan(path, arguments.boxes)
    with named(path):
        known: dict[str, Any] = {name: values for name, values in fields.items() if name != "column"}
        return RecordedScan.from_points(points, sensor, boxes=boxes, **known)


def _list(arguments: argparse.Namespace, scan: RecordedScan) -> None:
    for box, count in zip(scan.boxes, scan.returns_per_box(), strict=True):
        (x, y, _), size = box.center, ",".join(f"{extent:.2f}" for extent in box.size)
        text = f"{box.id}: {box.label} at {x:.2f},{y:.2f} yaw {math.degrees(box.yaw):.0f} size {size}, {count} returns"
        report(arguments, text, **asdict(box), returns=int(count))
    if not scan.boxes and not arguments.json:
        report(arguments, "no objects: give --boxes or --labels to have some that can be removed")


def _insert(text: str) -> Edit:
    from lidardraft.simulation.recorded.scan_edits import Insert

    found = _INSERTED.fullmatch(text.lower())
    if found is None:
        raise ValueError(f"{text!r} is not KIND at X,Y [yaw DEGREES] [size L,W,H], as in 'car at 12,3 yaw 90'")
    kind, x, y, yaw, *size = found.groups()
    extents = (float(size[0]), float(size[1]), float(size[2])) if size[0] else None
    return Insert(kind.replace(" ", "-"), (float(x), float(y)), math.radians(float(yaw or 0)), extents)


def _move(id: str, place: str) -> Edit:
    from lidardraft.simulation.recorded.scan_edits import Move

    found = _PLACE.fullmatch(place)
    if found is None:
        raise ValueError(f"{place!r} is not X,Y [m] or X,Y,YAW [degrees]")
    x, y, yaw = found.groups()
    return Move(id, (float(x), float(y)), None if yaw is None else math.radians(float(yaw)))


class _InOrder(argparse.Action):
    """Collects the edits of all options in their order on the command line."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        from lidardraft.simulation.recorded.scan_edits import Remove, Replace

        made_by: dict[str, Callable[..., Edit]]
        made_by = {"--insert": _insert, "--remove": Remove, "--move": _move, "--replace": Replace}
        try:
            made = made_by[self.option_strings[0]](*values)
        except ValueError as error:
            parser.error(f"argument {option_string}: {error}")
        namespace.edits = [*(namespace.edits or []), made]


def edit_options(parser: argparse.ArgumentParser) -> None:
    """The options of `edit`."""
    parser.epilog = (
        "Edits are done in the order in which they are given; without any, the objects are listed. x is ahead and y to "
        "the left of the sensor, in metres. Objects are those of --boxes, or of clusters of the labels. Made-up "
        "returns are marked in the .npz (made_up: 1 for inserted objects, 2 for removed ones), the latter as "
        "outliers in the .label."
    )
    text = "KITTI .bin, nuScenes .pcd.bin, .pcd, .ply, .npz, .npy, .las, PandaSet .pkl.gz, ROS 2 bag, Ouster .pcap/.osf"
    parser.add_argument("scan", metavar="SCAN", help=text)
    text = "labels of the scan: SemanticKITTI's .label, lidarseg or masks (default: those in it or beside it)"
    parser.add_argument("--labels", metavar="FILE", help=text)
    text = "boxes around its objects: .boxes.json, KITTI's label_2, ... (default: the .boxes.json beside it)"
    parser.add_argument("--boxes", metavar="FILE", help=text)
    text = f" that took the scan (default that beside it, hdl32e of nuScenes, or {DEFAULT_SENSOR})"
    add_sensor(parser, default=None, of=text)
    add_reading(parser)
    add_log(parser)
    for option, names, text in (
        ("insert", ("TEXT",), "an object: 'car at 12,3 yaw 90', 'truck at 30,-2 size 8,2.5,3'; repeatable"),
        ("remove", ("ID",), "take an object away; repeatable"),
        ("move", ("ID", "X,Y[,YAW]"), "move an object; repeatable"),
        ("replace", ("ID", "KIND"), "put one of another kind in the place of an object; repeatable"),
    ):
        parser.add_argument(f"--{option}", dest="edits", action=_InOrder, nargs=len(names), metavar=names, help=text)
    add_seed(parser)
    text = "the edited scan: NAME.bin, .label, .npz, .boxes.json and .sensor.json; of a folder, the scan's name in it"
    parser.add_argument("-o", "--output", metavar="NAME", help=text)
    add_json(parser)
