"""`lidardraft streets` and `pairs`: training pairs on disk, of procedural streets or of your own recordings."""

from __future__ import annotations

import argparse
import itertools
import zlib
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lidardraft.cli.arguments import add_seed, add_sensor, check_empty, read_sensor, whole_number
from lidardraft.cli.command import progress, say
from lidardraft.cli.inputs import sensor_beside
from lidardraft.cli.scan_folder import cores
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.files import named, read_bytes
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig
from lidardraft.streets import streets as pairs_of_streets

if TYPE_CHECKING:
    from lidardraft.formats.pairs import NotedPair, Pair
    from lidardraft.streets import StreetPair
    from lidardraft.training.recorded_pairs import RecordedScan

# A network learns more from another street than from another look at one; building it takes a third of the time then.
_POSES = 4
_SHOWN, _LOOK = 100, 320  # streets that a picture shows at most, and rows of the view of each
_ENDINGS = (".bin", ".pcd", ".ply", ".npz")
_UNRELATED = 0.2  # of the beams' spacing: points that are of other beams are 0.25 off in the median
Labeller = Callable[[np.ndarray, np.ndarray, float], np.ndarray]


def streets(arguments: argparse.Namespace) -> None:
    """Make procedural streets: pairs of a scan and its condition image to train on, or a picture of some."""
    if arguments.look is None:
        _fill(Path(arguments.output), arguments)
    else:
        _look(arguments)


def _fill(folder: Path, arguments: argparse.Namespace) -> None:
    """Fill a folder up to `num` pairs, with a progress bar; what is in it already is kept."""
    from lidardraft.formats.pairs import Pair, pairs_on_disk, write_pairs

    num, seed, poses = arguments.num, arguments.seed, arguments.poses
    config = StreetConfig(sensor=read_sensor(arguments.sensor), poses_per_street=poses, simulated=True)
    source = f"streets of seed {seed}, {poses} poses each, {config.sensor.name}"
    _check_begun(folder)
    start = pairs_on_disk(folder, source=source)
    if start >= num:
        print(f"{folder}: {start} pairs are there already; nothing to do")
        return
    if start:
        print(f"{folder}: goes on after the {start} pairs that are there", flush=True)
    pairs = pairs_of_streets(seed, config, start=start, workers=min(arguments.workers, -(-(num - start) // poses)))
    with progress(num, "pair", "streets", initial=start) as bar:

        def noted(pair: StreetPair) -> NotedPair:
            bar.update()
            style = {"source": pair.style.source} | asdict(pair.style)
            note = {"index": pair.index, "district": pair.district, "style": style}
            assert pair.simulated is not None
            return Pair(pair.scan, pair.condition_image, pair.simulated), note

        for _ in write_pairs(folder, map(noted, itertools.islice(pairs, num - start)), source=source, start=start):
            pass
    print(f"{folder}: {num} pairs, {num - start} of them new")


def _check_begun(folder: Path) -> None:
    """Raises `FormatError` where a folder holds anything but pairs, or what a run may leave that was killed early."""
    if not (folder / "index.json").exists():
        check_empty(folder, "", but=r"\d+\.npz|.*\.partial")


def _look(arguments: argparse.Namespace) -> None:
    """A sheet of streets, each with its boxes, from above and as range images."""
    from lidardraft import view

    num = arguments.num
    if num > _SHOWN:
        raise FormatError(f"--num is {num}; a picture shows up to {_SHOWN} streets")
    if not Path(arguments.look).parent.is_dir():
        raise FormatError(f"{arguments.look}: there is no folder {Path(arguments.look).parent}")
    config = StreetConfig(sensor=read_sensor(arguments.sensor), poses_per_street=1)
    pairs = pairs_of_streets(arguments.seed, config, workers=min(arguments.workers, num))
    pictures = []
    with progress(num, "street", leave=False) as bar:
        for pair in itertools.islice(pairs, num):
            boxes, points = pair.things.layout({}).boxes(), pair.scan.points(pair.poses())
            pictures.append(view.render_returns(pair.scan, points, boxes=boxes, title=pair.district, height=_LOOK))
            bar.update()
    view.save_png(arguments.look, view.sheet(pictures))
    print(arguments.look)


def streets_options(parser: argparse.ArgumentParser) -> None:
    """The options of `streets`."""
    positive = whole_number(1)
    parser.add_argument("-n", "--num", type=positive, default=6, metavar="N", help="pairs in all (default 6)")
    text = f"scans of each street, from different places (default {_POSES})"
    parser.add_argument("--poses", type=positive, default=_POSES, metavar="N", help=text)
    add_sensor(parser)
    add_seed(parser)
    text = f"processes that make streets (default {cores()}, one a core)"
    parser.add_argument("--jobs", "--workers", dest="workers", type=positive, default=cores(), metavar="N", help=text)
    to = parser.add_mutually_exclusive_group(required=True)
    text = "fill a folder with pairs for lidardraft-train; a second call goes on"
    to.add_argument("-o", "--output", metavar="FOLDER", help=text)
    text = "make a picture of N streets instead (default streets.png)"
    to.add_argument("--look", metavar="PICTURE.png", nargs="?", const="streets.png", help=text)


def pairs(arguments: argparse.Namespace) -> None:
    """Make training pairs of your recorded scans: each scan, with the cast and the simulated scan of its layout."""
    from lidardraft.formats.pairs import notes_on_disk, write_pairs

    folder, files = Path(arguments.output), _scan_files(arguments.scans)
    sensor = _recorded_by(arguments, files[0])
    source = f"recordings, {sensor.name}"
    _check_begun(folder)
    notes = notes_on_disk(folder, sensor, source=source)
    done = {note.get("checksum") for note in notes}
    label = _labeller(arguments.segmenter)
    if notes:
        print(f"{folder}: goes on after the {len(notes)} pairs that are there", flush=True)
    skipped = list[str]()
    with progress(len(files), "scan", "recordings") as bar:

        def made() -> Iterator[NotedPair]:
            for number, file in enumerate(files):
                try:
                    checksum = zlib.crc32(read_bytes(file))
                    if checksum not in done:
                        done.add(checksum)
                        pair = _pair(arguments, file, sensor, label, arguments.seed + number, first=not number)
                        yield pair, {"scan": str(file), "checksum": checksum}
                except LidarDraftError as error:
                    skipped.append(str(file))
                    bar.clear()
                    say("lidardraft", f"skipped: {error}")
                bar.update()

        counts = list(write_pairs(folder, made(), source=source, start=len(notes)))
    total = counts[-1] if counts else len(notes)
    if not total:
        raise FormatError(f"{folder}: none of {len(files)} scans became a pair")
    left = f", {len(skipped)} scan{'s' * (len(skipped) > 1)} skipped" if skipped else ""
    print(f"{folder}: {total} pairs, {total - len(notes)} of them new{left}")


def _pair(
    arguments: argparse.Namespace, file: Path, sensor: Sensor, label: Labeller | None, seed: int, *, first: bool
) -> Pair:
    from lidardraft.training.recorded_pairs import beside_beams, recorded_pair

    scan = _read(file, arguments.labels, sensor, label)
    with named(file):
        if first and beside_beams(scan, sensor) > _UNRELATED:
            say("lidardraft", f"{file}: the points lie between the beams of {sensor.name} as often as on them; "
                "`lidardraft fit` makes a sensor of the scans")  # fmt: skip
        return recorded_pair(scan, sensor, seed=seed)


def _scan_files(given: list[str]) -> list[Path]:
    """The scans of files and folders; of a SemanticKITTI sequence, those in its velodyne/."""
    files = list[Path]()
    for path in map(Path, given):
        if path.is_dir():
            inside = path / "velodyne" if (path / "velodyne").is_dir() else path
            found = sorted(file for file in inside.iterdir() if file.suffix in _ENDINGS)
            found = [file for file in found if file.suffix != ".npz" or not file.with_suffix(".bin").exists()]
            if not found:
                raise FormatError(f"{inside}: there is no .bin, .pcd, .ply or .npz file in this folder")
            files += found
        else:
            files.append(path)
    return files


def _recorded_by(arguments: argparse.Namespace, scan: Path) -> Sensor:
    if arguments.sensor is not None:
        return read_sensor(arguments.sensor)
    sensor = sensor_beside(scan)
    if sensor is None:
        raise FormatError("--sensor is needed: a preset, or the file that `lidardraft fit` makes of these scans")
    return sensor


def _labeller(weights: str | None) -> Labeller | None:
    if weights is None:
        return None
    from lidardraft.networks import weight_file
    from lidardraft.perception.segmenter import Segmenter

    return weight_file.load(weights, Segmenter).eval().label_points


def _read(file: Path, labels: str | None, sensor: Sensor, label: Labeller | None) -> RecordedScan:
    """A scan with its classes: those of --labels, of the file or of one beside it, or those of the segmenter."""
    from lidardraft.formats.recording import read_points, returns
    from lidardraft.formats.semantickitti import read_label
    from lidardraft.training.recorded_pairs import RecordedScan

    points, fields = read_points(file)
    if labels is not None:
        path = Path(labels) / f"{file.stem}.label" if Path(labels).is_dir() else Path(labels)
        fields |= dict(zip(("label", "instance"), read_label(path, len(points)), strict=True))
    with named(file):
        points, fields = returns(points, fields)
        if "intensity" not in fields:
            raise FormatError("there are no intensities, which the generator learns too")
        if "label" not in fields:
            if label is None:
                raise FormatError(f"there are no labels: no {file.stem}.label beside it, no --labels, no --segmenter")
            fields["label"] = label(points, fields["intensity"], sensor.mount_height)
        instance = fields.get("instance")
        return RecordedScan(
            points=points,
            intensity=fields["intensity"],
            label=fields["label"].astype(np.uint8),
            instance=None if instance is None else instance.astype(np.uint32),
        )


def pairs_options(parser: argparse.ArgumentParser) -> None:
    """The options of `pairs`."""
    text = "recorded scans: KITTI .bin, nuScenes .pcd.bin, .pcd, .npz, or folders of them"
    parser.add_argument("scans", nargs="+", metavar="SCAN", help=text)
    text = (
        "SemanticKITTI labels of the scan, or the folder of NAME.label of all (default: beside them, or in ../labels)"
    )
    parser.add_argument("--labels", metavar="FOLDER", help=text)
    text = "label scans that have no labels by these weights, as `lidardraft-train segmenter` makes them"
    parser.add_argument("--segmenter", metavar="WEIGHTS", help=text)
    add_sensor(parser, default=None, of=" that recorded them (default: the .sensor.json beside the first scan)")
    add_seed(parser)
    text = "where the pairs go; a second call goes on"
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help=text)
