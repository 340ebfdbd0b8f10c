"""`lidardraft streets`: procedural streets, as training pairs on disk or as a picture to look at."""

from __future__ import annotations

import argparse
import itertools
import os
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from lidardraft.cli.arguments import add_seed, add_sensor, read_sensor, whole_number
from lidardraft.cli.output_folder import check_empty
from lidardraft.errors import FormatError
from lidardraft.streets import StreetConfig
from lidardraft.streets import streets as pairs_of_streets

if TYPE_CHECKING:
    from lidardraft.streets import StreetPair
    from lidardraft.training.pairs import NotedPair

# A network learns more from another street than from another look at one; building it takes a third of the time then.
_POSES = 4
_ROWS = 100  # of a picture: one of all sensors stays below a gigabyte


def streets(arguments: argparse.Namespace) -> None:
    """Make procedural streets: pairs of a scan and its condition image to train on, or a picture of some."""
    if arguments.look is not None:
        _look(arguments)
    else:
        write_pairs_of_streets(arguments.output, arguments)


def write_pairs_of_streets(folder: str | Path, arguments: argparse.Namespace) -> None:
    """Fill a folder up to `num` pairs, with a progress bar; what is in it already is kept."""
    from tqdm import tqdm

    from lidardraft.training.pairs import Pair, pairs_on_disk, write_pairs

    num, seed, poses = arguments.num, arguments.seed, arguments.poses
    config = StreetConfig(sensor=read_sensor(arguments.sensor), poses_per_street=poses, simulated=True)
    source = f"streets of seed {seed}, {poses} poses each, {config.sensor.name}"
    if not (Path(folder) / "index.json").exists():
        check_empty(Path(folder), "", but=r"\d+\.npz|.*\.partial")  # what a run may leave that was killed early
    start = pairs_on_disk(folder, source=source)
    if start >= num:
        print(f"{folder}: {start} pairs are there already; nothing to do")
        return
    if start:
        print(f"{folder}: goes on after the {start} pairs that are there", flush=True)
    pairs = pairs_of_streets(seed, config, start=start, workers=min(arguments.workers, -(-(num - start) // poses)))
    with tqdm(total=num, initial=start, unit="pair", desc="streets", disable=None) as bar:

        def noted(pair: StreetPair) -> NotedPair:
            bar.update()
            style = {"source": pair.style.source} | asdict(pair.style)
            note = {"index": pair.index, "district": pair.district, "style": style}
            assert pair.simulated is not None
            return Pair(pair.scan, pair.condition_image, pair.simulated), note

        for _ in write_pairs(folder, map(noted, itertools.islice(pairs, num - start)), source=source, start=start):
            pass
    print(f"{folder}: {num} pairs, {num - start} of them new")


def _look(arguments: argparse.Namespace) -> None:
    """A sheet of streets: range image, label, intensity, and the top view with the layout over it."""
    from tqdm import tqdm

    from lidardraft import view

    num = arguments.num
    if num > _ROWS:
        raise FormatError(f"--num is {num}; a picture shows up to {_ROWS} streets")
    if not Path(arguments.look).parent.is_dir():
        raise FormatError(f"{arguments.look}: there is no folder {Path(arguments.look).parent}")
    config = StreetConfig(sensor=read_sensor(arguments.sensor), poses_per_street=1)
    pairs = pairs_of_streets(arguments.seed, config, workers=min(arguments.workers, num))
    rows = []
    for pair in tqdm(itertools.islice(pairs, num), total=num, unit="street", disable=None, leave=False):
        images = view.caption(view.render_image(pair.scan), f"{pair.district}, {pair.style.source}")
        top = view.render_top_view(pair.scan, pair.layout, pair.pose, size=len(images))
        rows.append(view.stack([images, top], across=True))
    view.save_png(arguments.look, view.stack(rows))
    print(arguments.look)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    add_pair_arguments(parser, num=6)
    to = parser.add_mutually_exclusive_group(required=True)
    to.add_argument(
        "-o", "--output", metavar="FOLDER", help="fill a folder with pairs for lidardraft-train; a second call goes on"
    )
    to.add_argument(
        "--look",
        metavar="PICTURE.png",
        nargs="?",
        const="streets.png",
        help="make a picture instead, with a row for each of N streets (default streets.png)",
    )


def add_pair_arguments(parser: argparse.ArgumentParser, *, num: int) -> None:
    """What all commands that make streets ask for."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    positive = whole_number(1)
    parser.add_argument("-n", "--num", type=positive, default=num, metavar="N", help=f"pairs in all (default {num})")
    text = f"scans of each street, from different places (default {_POSES})"
    parser.add_argument("--poses", type=positive, default=_POSES, metavar="N", help=text)
    add_sensor(parser)
    add_seed(parser)
    text = f"processes that make streets (default {cores}, one a core)"
    parser.add_argument("--workers", type=positive, default=cores, metavar="N", help=text)
