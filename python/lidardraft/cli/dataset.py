"""`lidardraft dataset` and `export`: data sets from recipes, and from folders of scans."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from lidardraft.cli.arguments import number, whole_number
from lidardraft.cli.command import add_json, progress, report, say
from lidardraft.cli.scan_folder import add_jobs, jobs_of
from lidardraft.formats.frame import FORMATS


def dataset(arguments: argparse.Namespace) -> None:
    """Write the data set of a recipe, or one share of it."""
    from lidardraft.dataset.recipe import Recipe
    from lidardraft.dataset.shards import DataSet

    recipe, share = Recipe.load(arguments.recipe, arguments.num), arguments.shard
    made = DataSet(recipe, Path(arguments.output))
    num = made.scans_of(share)
    counts = made.write(share, _workers(arguments, recipe.scans, recipe.shard_size))
    count = next(counts)
    with progress(num, "scan", initial=count) as bar:
        for now in counts:
            bar.update(now - count)
            count = now
    for note in recipe.notes:
        say(note)
    of = f", share {share[0]} of {share[1]}" if share[1] > 1 else ""
    text = f"{arguments.output}: {count} scan{'s' * (count > 1)} as {recipe.format}{of}"
    report(arguments, text, output=arguments.output, scans=count, format=recipe.format)


def _workers(arguments: argparse.Namespace, num: int, run: int) -> Callable[..., Iterator[Any]]:
    """The function that makes shards: in worker processes, or in this one."""
    jobs = jobs_of(arguments, num, run)
    if jobs == 1:
        return map
    from lidardraft.streets.worker_processes import in_processes

    return partial(in_processes, count=jobs, ahead=1)


def dataset_options(parser: argparse.ArgumentParser) -> None:
    """The options of `dataset`."""
    parser.epilog = (
        "Keys of recipes: docs/reference/recipe.md. Scan k depends on the seed of the recipe and on k alone. After an "
        "interrupt or a crash the same call continues; with a larger -n the set grows."
    )
    parser.add_argument("recipe", metavar="RECIPE.toml", help="recipe of the data set")
    parser.add_argument(
        "-o", "--output", required=True, metavar="FOLDER", help="folder for shards: new, empty or begun"
    )
    text = "scans, or drives, to make, in place of the recipe's number"
    parser.add_argument("-n", "--num", type=whole_number(1), metavar="N", help=text)
    add_jobs(parser)
    text = "make every K-th shard from number I (0 to K - 1) on; others make the rest, as in an array of Slurm"
    parser.add_argument("--shard", type=_share, default=(0, 1), metavar="I/K", help=text)
    add_json(parser)


def _share(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if not found or not int(found[1]) < int(found[2]):
        raise argparse.ArgumentTypeError(f"{text!r} is not I/K with I from 0 to K - 1, as in 0/4")
    return int(found[1]), int(found[2])


def export(arguments: argparse.Namespace) -> None:
    """Write folders of scans as one data set."""
    from lidardraft.exports import drives_in
    from lidardraft.exports import export as write

    drives = [drive for folder in arguments.folders for drive in drives_in(Path(folder))]
    count, more = sum(map(len, drives)), {"as_seen": arguments.as_seen, "box_margin": arguments.box_margin}
    with progress(count, "scan") as bar:
        write((_counted(drive, bar) for drive in drives), arguments.format, arguments.output, **more)
    text = f"{arguments.output}: {count} scan{'s' * (count > 1)} as {arguments.format}"
    report(arguments, text, output=arguments.output, scans=count, format=arguments.format)


def export_options(parser: argparse.ArgumentParser) -> None:
    """The options of `export`."""
    parser.epilog = (
        "Each folder is a drive, or holds folders of drives: its scans follow one another, at the times of a sequence "
        "or a sweep time apart. Frames, boxes and class ids of each format: docs/reference/formats.md. The data set is "
        "written whole or not at all."
    )
    parser.add_argument("folders", nargs="+", metavar="FOLDER", help="scans of `simulate`, `generate` or `observe`")
    text = "; ".join(f"{name}: {what}" for name, (_, _, what) in FORMATS.items())
    parser.add_argument("--format", required=True, choices=FORMATS, metavar="NAME", help=text)
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="folder for it: new or empty")
    text = "points with the sensor's motion, and their times if the format has any; always for ros2"
    parser.add_argument("--as-seen", action="store_true", default=None, help=text)
    text = "make boxes larger by M metres on each side, against the noise of points (0.05 holds nearly all; default 0)"
    parser.add_argument("--box-margin", type=number, default=0.0, metavar="M", help=text)
    add_json(parser)


def _counted(scans: list[Path], bar: Any) -> Iterator[Path]:
    for name in scans:
        yield name
        bar.update()
