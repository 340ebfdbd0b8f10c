"""`lidardraft streets`: procedural streets, as training pairs on disk or as a picture to look at."""

from __future__ import annotations

import argparse
import itertools
import os
from dataclasses import asdict
from pathlib import Path

from lidardraft.errors import FormatError
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.streets import StreetConfig, streets

# A network learns more from another street than from another look at one; building it takes a third of the time then.
_POSES = 4


def write(arguments: argparse.Namespace) -> None:
    """Procedural streets become a folder of training pairs, which goes on where it stopped; or a picture of some."""
    if arguments.look is not None:
        look(arguments)
    elif arguments.out is None:
        raise FormatError("say --out FOLDER for pairs, or --look PICTURE.png for a picture of some")
    else:
        write_pairs_of_streets(arguments.out, arguments)


def write_pairs_of_streets(folder: str | Path, arguments: argparse.Namespace) -> None:
    """Fill a folder up to `num` pairs, with a progress bar."""
    from tqdm import tqdm

    from lidardraft.training.pairs import pairs_on_disk, write_pairs

    num, seed, poses = arguments.num, arguments.seed, arguments.poses
    config = StreetConfig(sensor=Sensor.preset(arguments.sensor), poses_per_street=poses)
    source = f"streets of seed {seed}, {poses} poses each, {config.sensor.name}"
    start = pairs_on_disk(folder, source=source)
    if start >= num:
        return
    pairs = streets(seed, config, start=start, workers=arguments.workers)
    noted = (
        (
            pair.scan,
            pair.condition_image,
            {
                "index": pair.index,
                "district": pair.district,
                "style": {"source": pair.style.source} | asdict(pair.style),
            },
        )
        for pair in itertools.islice(pairs, num - start)
    )
    with tqdm(total=num, initial=start, unit="pair", desc="streets") as bar:
        for count in write_pairs(folder, noted, source=source):
            bar.update(count - bar.n)


def look(arguments: argparse.Namespace) -> None:
    """A sheet of streets: range image, label, intensity, and the top view with the layout over it."""
    from lidardraft import view

    config = StreetConfig(sensor=Sensor.preset(arguments.sensor), poses_per_street=1)
    rows = []
    for pair in itertools.islice(streets(arguments.seed, config, workers=arguments.workers), arguments.num):
        images = view.caption(view.render_image(pair.scan), f"{pair.district}, {pair.style.source}")
        top = view.render_top_view(pair.scan, pair.layout, pair.pose, size=len(images))
        rows.append(view.stack([images, top], across=True))
    view.save_png(view.stack(rows), arguments.look)
    print(arguments.look)


def add_arguments(added: argparse.ArgumentParser, *, num: int) -> None:
    """What both commands that make streets ask for."""
    added.add_argument("-n", "--num", type=int, default=num, help=f"how many pairs (default {num})")
    added.add_argument("--seed", type=int, default=0, help="seed of the streets (default 0)")
    added.add_argument("--poses", type=int, default=_POSES, help=f"scans of each street (default {_POSES})")
    added.add_argument("--sensor", default="hdl64e", help=f"{', '.join(PRESETS)} or a .json file (default hdl64e)")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    added.add_argument("--workers", type=int, default=cores, help=f"processes (default {cores})")
