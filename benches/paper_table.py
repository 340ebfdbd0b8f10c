"""Scans for the paper's Table 1: of each input, by weights or by the same network untrained.

    python benches/paper_table.py [WEIGHTS] [--untrained] -n 16 -o out/table
    python benches/published_tables.py --real RECORDINGS --generated text=out/table/text image=out/table/image ...

Unseen streets are given as a sentence, a picture or a clustered scan would give them (`streets/coarse/`), as semantic
maps of their detailed scans, and not at all; `streets` holds the detailed scans. Weights that see classes alone, as
those of the recipe `small-map`, make scans of the maps.
"""

from __future__ import annotations

import argparse
import itertools
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lidardraft import Pipeline, RangeImage, Sensor
from lidardraft.cli.arguments import whole_number
from lidardraft.evaluation import untrained
from lidardraft.formats.kitti import write_bin
from lidardraft.metrics.adherence import adherence
from lidardraft.streets import StreetConfig, StreetPair, streets

_SEED = 1_000_000  # of streets that no training used, as those of `lidardraft evaluate`
_SOURCES = {"text": "text", "picture": "image", "cloud": "cloud"}  # styles of coarse layouts, as the table calls them


def main() -> None:
    """Parse, generate, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("weights", nargs="?", default="paper", help="packaged ones by name, or a file (default paper)")
    parser.add_argument("-n", "--num", type=whole_number(1), default=16, metavar="N", help="scans of each input")
    parser.add_argument("--steps", type=whole_number(1), metavar="N", help="steps of denoising (default: as stored)")
    parser.add_argument("--untrained", action="store_true", help="by a network that has learned nothing")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER", help="where the scans go")
    arguments = parser.parse_args()
    pipeline = Pipeline.from_pretrained(arguments.weights, steps=arguments.steps)
    if arguments.untrained:
        pipeline = untrained(pipeline)
    agreeing = defaultdict[str, list[float]](list)
    for name, image, street in scans(pipeline, arguments.num, Sensor.preset("hdl64e")):
        folder = arguments.output / name
        folder.mkdir(parents=True, exist_ok=True)
        assert image.intensity is not None
        write_bin(folder / f"{len(agreeing[name]):06d}.bin", image.points(), image.intensity[image.valid])
        agreeing[name].append(adherence(image, street).objects)
        print(folder, len(agreeing[name]), flush=True)
    print("returns on objects that agree with the street, within 0.5 m or 5 %:")
    for name, shares in agreeing.items():
        print(f"{name:8}{np.mean(shares):.3f}")


def scans(pipeline: Pipeline, num: int, sensor: Sensor) -> Iterator[tuple[str, RangeImage, RangeImage]]:
    """The rows of the table, and the streets' own scans: a name, a scan and that of its street each."""
    given: dict[str, list[StreetPair]] = {name: [] for name in _SOURCES.values()}
    for pair in streets(seed=_SEED, config=StreetConfig(sensor=sensor, poses_per_street=1)):
        pairs = given.get(_SOURCES.get(pair.style.source, ""), [])
        if len(pairs) < num:
            pairs.append(pair)
        if all(len(pairs) == num for pairs in given.values()):
            break
    for number, pair in enumerate(itertools.islice(itertools.chain(*zip(*given.values(), strict=True)), num)):
        yield "streets", pair.scan, pair.scan
        yield "map", pipeline.from_map(pair.scan.label, sensor=sensor, seed=number), pair.scan
    if "depth" not in pipeline.denoiser.config.condition:
        return
    bare = Pipeline(pipeline.denoiser.base(), steps=pipeline.steps)
    for name, pairs in given.items():
        for number, pair in enumerate(pairs):
            yield name, pipeline.generate(pair.condition_image, seed=number), pair.scan
            if name == "text":
                yield "none", bare.generate(pair.condition_image, seed=number), pair.scan


if __name__ == "__main__":
    main()
