"""Half of each unseen street is open: what weights that complete make of it, beside a procedural street and a lawn.

    python benches/completed_halves.py WEIGHTS [-n 64] [-o PICTURE]

The rows are those of `lidardraft evaluate`, of the open halves, and the shares of the distances of the lawn. "surround"
knows as much as the weights: the objects of the given half, and no road; it makes a straight one with a lane each way.
The picture shows up to twenty of the streets: the weights, "surround", the lawn, the detailed scan.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

import numpy as np

from goals import ratio
from lidardraft import Layout, Pipeline, RangeImage, Sensor, simulate, surround, view
from lidardraft.cli.arguments import whole_number
from lidardraft.evaluation import half_opened, lawn, score, unseen_streets
from lidardraft.pipeline import merged
from lidardraft.semantics import GROUND
from lidardraft.streets import StreetPair
from markdown_table import table

COMPARED = ("range", "height", "bev", "classes", "holes", "lone")
SEEN = math.radians(84.0)  # either way of the middle of the given half, in which `surround` adds nothing
PICTURED = 20


def main() -> None:
    """Complete, score, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("weights", help="a .safetensors file, of a recipe that completes")
    parser.add_argument("-n", "--num", type=whole_number(2), default=64, help="streets (default 64)")
    parser.add_argument("-o", "--output", type=Path, metavar="PICTURE", help="a .png file")
    given = parser.parse_args()
    pipeline, number = Pipeline.from_pretrained(given.weights), given.num
    pairs = unseen_streets(number, sensor=Sensor.preset("hdl64e"))
    halves = list(zip(pairs, half_opened([pair.scan for pair in pairs]), strict=True))
    times = [time.process_time()]
    scans = {"weights": [pipeline.generate(p.condition_image, whole(p), o, seed=p.index) for p, o in halves]}
    times.append(time.process_time())
    scans["surround"] = [merged(whole(pair), surrounded(pair, is_open), is_open) for pair, is_open in halves]
    times.append(time.process_time())
    scans["bare"] = [merged(whole(pair), lawn(pair), is_open) for pair, is_open in halves]
    scans["detailed scan"] = [pair.scan for pair in pairs]
    scores = {n: vars(score(n, pairs, images, [is_open for _, is_open in halves])) for n, images in scans.items()}
    print(table({name: {each: row[each] for each in COMPARED} for name, row in scores.items()}))
    shares = {n: {each: ratio(row[each], scores["bare"][each]) for each in COMPARED} for n, row in scores.items()}
    print(f"\nshares of bare:\n{table(shares)}")
    made, surrounding = np.diff(times) / number
    print(f"\nprocessor seconds a scan: weights {made:.2f}, surround {surrounding:.2f}")
    if given.output:
        rows = []
        for k, pair in enumerate(pairs[:PICTURED]):
            images = {name: some[k] for name, some in scans.items()}
            row = [view.caption(view.render_scan(one, pair.pose, by_label=True), n) for n, one in images.items()]
            rows.append(view.stack(row, across=True))
        view.save_png(given.output, view.stack(rows))


def whole(pair: StreetPair) -> RangeImage:
    """The simulated scan, half of which is given."""
    assert pair.simulated is not None
    return pair.simulated


def surrounded(pair: StreetPair, is_open: np.ndarray) -> RangeImage:
    """The simulated scan of the objects of the given half, and of a procedural street around them."""
    sensor = pair.scan.sensor
    rays = sensor.pattern.points(np.ones(sensor.shape, np.float32))[0][~is_open.any(axis=0)]
    middle = math.atan2(*rays[:, [1, 0]].mean(axis=0))

    def is_given(x: float, y: float) -> bool:
        return abs(math.remainder(math.atan2(y, x) - middle, math.tau)) < math.pi / 2

    given = tuple(p for p in pair.layout if p.label not in GROUND and is_given(*p.center[:2]))
    layout = surround(Layout(given, coverage=(middle - SEEN, middle + SEEN)), seed=pair.index)
    return simulate(layout, sensor, pose=pair.pose, speed=pair.speed, seed=pair.index).image


if __name__ == "__main__":
    main()
