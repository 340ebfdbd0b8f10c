"""`lidardraft streets` and `pairs`: training pairs on disk, from procedural streets or from recordings."""

from __future__ import annotations

import argparse
import itertools
import warnings
import zlib
from collections.abc import Iterator
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lidardraft.cli.arguments import add_reading, add_seed, add_sensor, check_empty, read_sensor, reading, whole_number
from lidardraft.cli.command import add_json, progress, report, say
from lidardraft.cli.inputs import scan_files, sensor_of_file
from lidardraft.cli.scan_folder import add_jobs, cores, jobs_of
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.files import named, read_bytes
from lidardraft.formats.datasets import SENSORS, RecordedFile, dataset_files
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig
from lidardraft.streets import streets as pairs_of_streets

if TYPE_CHECKING:
    from lidardraft.formats.pairs import NotedPair, Pair
    from lidardraft.perception.segmenter import Segmenter
    from lidardraft.streets import StreetPair
    from lidardraft.training.recorded_pairs import LabelledCloud

# A network learns more from another street than from another view of one; with this many views, building the streets
# takes a third of the time.
_POSES = 4
_UNRELATED = 0.2  # of the beams' spacing: points of another sensor are 0.25 off in the median


def streets(arguments: argparse.Namespace) -> None:
    """Write pairs of procedural streets."""
    from lidardraft.formats.pairs import Pair, pairs_on_disk, write_pairs

    folder, num, seed, poses = Path(arguments.output), arguments.num, arguments.seed, arguments.poses
    config = StreetConfig(sensor=read_sensor(arguments.sensor), poses_per_street=poses)
    source = f"streets of seed {seed}, {poses} poses each, {config.sensor.name}"
    _check_begun(folder)
    start = pairs_on_disk(folder, source=source)
    if start >= num:
        report(arguments, f"{folder}: {start} pairs are there already; nothing to do", output=str(folder), pairs=start)
        return
    if start:
        say(f"{folder}: continues after {start} pairs")
    workers = min(arguments.workers, -(-(num - start) // poses))
    pairs = pairs_of_streets(seed=seed, config=config, start=start, workers=workers)
    with progress(num, "pair", "streets", initial=start) as bar:

        def noted(pair: StreetPair) -> NotedPair:
            bar.update()
            style = {"source": pair.style.source} | asdict(pair.style)
            note = {"index": pair.index, "district": pair.district, "style": style}
            return Pair(pair.scan, pair.condition_image), note

        for _ in write_pairs(folder, map(noted, itertools.islice(pairs, num - start)), source=source, start=start):
            pass
    report(arguments, f"{folder}: {num} pairs, {num - start} of them new", output=str(folder), pairs=num)


def _check_begun(folder: Path) -> None:
    """Raises `FormatError` if a folder holds anything but pairs, or the remains of a run that was killed early."""
    if not (folder / "index.json").exists():
        check_empty(folder, "", but=r"\d+\.npz|.*\.partial")


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
    text = "folder for the pairs, for lidardraft-train; a second call continues"
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help=text)
    add_json(parser)


def pairs(arguments: argparse.Namespace) -> None:
    """Write pairs of recorded scans."""
    from lidardraft.formats.pairs import notes_on_disk, write_pairs
    from lidardraft.networks.weight_header import read_metadata
    from lidardraft.streets.worker_processes import in_processes
    from lidardraft.training.recorded_pairs import ReturnShares

    if arguments.segmenter is not None:
        read_metadata(arguments.segmenter)  # a broken file is reported before any work
    folder, files = Path(arguments.output), _recorded_files(arguments)
    sensor = _recorded_by(arguments, files[0].scan)
    source = f"recordings, {sensor.name}"
    _check_begun(folder)
    notes = notes_on_disk(folder, sensor, source=source)
    done = {note.get("checksum") for note in notes}
    if notes:
        say(f"{folder}: continues after {len(notes)} pairs")
    share, skipped = ReturnShares(), 0
    with progress(len(files), "scan", "recordings") as bar:

        def new() -> Iterator[tuple[int, RecordedFile, int | LidarDraftError]]:
            """Scans that are not among the pairs yet, with their checksums."""
            for number, file in enumerate(files):
                checksum = _checksum(file.scan)
                if checksum in done:
                    bar.update()
                    continue
                if isinstance(checksum, int):
                    done.add(checksum)
                yield number, file, checksum

        def made() -> Iterator[NotedPair]:
            nonlocal skipped
            make, jobs = partial(_noted, arguments, sensor), jobs_of(arguments, len(files) - len(notes))
            for found in map(make, new()) if jobs < 2 else in_processes(make, new(), jobs):
                if isinstance(found, LidarDraftError):
                    skipped += 1
                    bar.clear()
                    say(f"skipped: {found}")
                else:
                    share.add(found[0])
                    yield found
                bar.update()

        counts = list(write_pairs(folder, made(), source=source, start=len(notes)))
    total = counts[-1] if counts else len(notes)
    if not total:
        raise FormatError(f"{folder}: none of {len(files)} scans became a pair")
    left = f", {skipped} scan{'s' * (skipped > 1)} skipped" if skipped else ""
    text = f"{folder}: {total} pairs, {total - len(notes)} of them new{left}"
    report(arguments, f"{text}\n{share}" if counts else text, output=str(folder), pairs=total)


def _checksum(path: Path) -> int | LidarDraftError:
    try:
        return zlib.crc32(read_bytes(path))
    except LidarDraftError as error:
        return error


def _noted(
    arguments: argparse.Namespace, sensor: Sensor, item: tuple[int, RecordedFile, int | LidarDraftError]
) -> NotedPair | LidarDraftError:
    """The pair of a scan, with its checksum, or its error."""
    number, file, checksum = item
    if isinstance(checksum, LidarDraftError):
        return checksum
    try:
        with warnings.catch_warnings():  # in a worker process they were not reported
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = lambda message, *_, **__: say(message)
            pair = _pair(arguments, file, sensor, first=not number)
    except LidarDraftError as error:
        return error
    return pair, {"scan": str(file.scan), "checksum": checksum}


def _recorded_files(arguments: argparse.Namespace) -> list[RecordedFile]:
    if arguments.dataset is None:
        return [RecordedFile(file) for file in scan_files(arguments.scans)]
    if len(arguments.scans) > 1:
        raise FormatError(f"--dataset takes one folder, that of {arguments.dataset}; there are {len(arguments.scans)}")
    return dataset_files(arguments.dataset, arguments.scans[0], arguments.split)


def _pair(arguments: argparse.Namespace, file: RecordedFile, sensor: Sensor, *, first: bool) -> Pair:
    from lidardraft.training.recorded_pairs import beside_beams, recorded_pair

    scan = _read(arguments, file, sensor)
    with named(file.scan):
        if first and beside_beams(scan, sensor) > _UNRELATED:
            say(f"{file.scan}: the points are between the beams of {sensor.name} as often as on them; "
                "`lidardraft fit` makes a sensor of the scans")  # fmt: skip
        return recorded_pair(scan, sensor)


def _recorded_by(arguments: argparse.Namespace, scan: Path) -> Sensor:
    if arguments.sensor is not None:
        return read_sensor(arguments.sensor)
    if arguments.dataset is not None:
        return Sensor.preset(SENSORS[arguments.dataset])
    sensor = sensor_of_file(scan)
    if sensor is None:
        raise FormatError("--sensor is needed: a preset, or the file that `lidardraft fit` makes of these scans")
    return sensor


@cache
def _segmenter(weights: str | None) -> Segmenter:
    """The segmenter of --segmenter, or the packaged one; reports once that labels are predicted."""
    from lidardraft.perception.segmenter import Segmenter

    by = "the packaged segmenter" if weights is None else weights
    say(f"scans have no labels: {by} predicts them")
    return Segmenter.from_pretrained(weights or "segmenter")


def _read(arguments: argparse.Namespace, file: RecordedFile, sensor: Sensor) -> LabelledCloud:
    """A scan with its classes: those of --labels, of the file, of one beside it or of the data set, or those of the
    segmenter; points in boxes get those of the boxes."""
    from lidardraft.formats.recording import read_returns, with_fields
    from lidardraft.training.recorded_pairs import LabelledCloud

    scan, labels = file.scan, arguments.labels
    if labels is not None and Path(labels).is_dir():
        labels = Path(labels, f"{scan.stem}.label")
    points, fields = read_returns(scan, labels, **reading(arguments))
    with named(scan):
        if "intensity" not in fields:
            raise FormatError(f"it has no intensities, which the generator learns too{with_fields(scan)}")
        if "label" not in fields:
            from lidardraft.perception.segmenter import SURE

            segmenter = _segmenter(arguments.segmenter)
            fields["label"] = segmenter.label_points(points, fields["intensity"], sensor.mount_height, least=SURE)
    classes = fields["label"].astype(np.uint8)
    instance = fields["instance"].astype(np.uint32) if "instance" in fields else None
    if file.boxes is not None:
        instance = np.zeros(len(points), dtype=np.uint32) if instance is None else instance
        file.mark_boxes(points, classes, instance)
    return LabelledCloud(points=points, intensity=fields["intensity"], label=classes, instance=instance)


def pairs_options(parser: argparse.ArgumentParser) -> None:
    """The options of `pairs`."""
    text = "recorded scans: KITTI .bin, nuScenes .pcd.bin, PandaSet .pkl.gz, .pcd, .npz, or folders; that of --dataset"
    parser.add_argument("scans", nargs="+", metavar="SCAN", help=text)
    text = "a whole data set, with its labels or boxes and its sensor; kitti has boxes alone"
    parser.add_argument("--dataset", choices=SENSORS, help=text)
    text = "of semantickitti and kitti360: train, val or all (default); of kitti360 also lidm-train and the like"
    parser.add_argument("--split", default="all", metavar="NAME", help=text)
    text = "labels of the scan, or the folder of NAME.label of all (default: those beside them, or in ../labels)"
    parser.add_argument("--labels", metavar="FOLDER", help=text)
    text = "weights of `lidardraft-train segmenter` for scans that have no labels (default: the packaged ones)"
    parser.add_argument("--segmenter", metavar="WEIGHTS", help=text)
    add_sensor(parser, default=None, of=" that recorded them (default: the .sensor.json beside the first scan)")
    add_reading(parser)
    add_jobs(parser)
    text = "folder for the pairs; a second call continues"
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help=text)
    add_json(parser)
