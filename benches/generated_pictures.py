"""What weights make of fixed layouts, side by side: the looks of a training's hours.

    python benches/generated_pictures.py WEIGHTS... -o PICTURE [--steps N] [--rows K ...]

A row each layout. Weights that make whole scans are given unseen streets, between the layout's cast and the detailed
scan. Weights that complete are given what people bring, beside its simulated scan: twelve sentences, the boxes of the
first four and a picture of each of the next four. Colours are classes.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lidardraft import (
    Layout,
    Pipeline,
    RangeImage,
    Sensor,
    layout_from_boxes,
    layout_from_image,
    layout_from_text,
    simulate,
    view,
)
from lidardraft.cli.arguments import whole_number
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.evaluation import unseen_streets
from rendered_pictures import render

WIDE = math.radians(80)  # what the camera sees
SENTENCES = (
    "a car ahead",
    "two parked cars on the left, trees along both sides",
    "a crossroads with a bus, cars and people",
    "a truck behind a cyclist on the right",
    "houses along both sides, a pedestrian 12 m ahead",
    "a motorway with trucks and cars",
    "a fence on the left and parked cars on the right",
    "three pedestrians cross the street, a van waits",
    "a roundabout with two cars",
    "a row of trees on the right and a wall on the left",
    "a bus stop with people, a bus 20 m ahead",
    "an empty road",
)


def main() -> None:
    """Parse, generate, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("weights", nargs="+", help="packaged weights by name, or .safetensors files")
    parser.add_argument("--steps", type=whole_number(1), metavar="N", help="steps of denoising (default: as stored)")
    text = "which layouts, counted from 1 (default 1 2 3 4)"
    parser.add_argument("--rows", type=whole_number(1), nargs="+", default=[1, 2, 3, 4], metavar="K", help=text)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="PICTURE", help="a .png file")
    given = parser.parse_args()
    pipelines = {name: Pipeline.from_pretrained(name, steps=given.steps) for name in given.weights}
    if len({pipeline.denoiser.config.completes for pipeline in pipelines.values()}) > 1:
        parser.error("some of these weights complete, others make whole scans")
    completes = next(iter(pipelines.values())).denoiser.config.completes
    rows = (completed if completes else whole)(pipelines, Sensor.preset("hdl64e"), given.rows)
    view.save_png(given.output, view.stack([view.stack(row, across=True) for row in rows]))


def whole(pipelines: dict[str, Pipeline], sensor: Sensor, numbers: list[int]) -> Iterator[list[np.ndarray]]:
    """A row of pictures each street."""
    streets = unseen_streets(max(numbers), sensor=sensor)
    for pair in (streets[number - 1] for number in numbers):
        assert pair.simulated is not None
        scans = {"layout": pair.condition_image}
        for name, pipeline in pipelines.items():
            scans[Path(name).stem] = pipeline.generate(pair.condition_image, pair.simulated, seed=pair.index)
        yield row(scans | {"detailed scan": pair.scan}, pair.pose)


def completed(pipelines: dict[str, Pipeline], sensor: Sensor, numbers: list[int]) -> Iterator[list[np.ndarray]]:
    """A row of pictures each draft."""
    known = dict(enumerate(itertools.islice(drafts(), max(numbers)), start=1))
    for seed, (name, layout) in ((number, known[number]) for number in numbers):
        simulated = simulate(layout, sensor, seed=seed)
        scans = {name: simulated.image}
        for weights, pipeline in pipelines.items():
            scans[Path(weights).stem] = pipeline(layout, sensor=sensor, seed=seed).image
        yield row(scans, simulated.pose)


def drafts() -> Iterator[tuple[str, Layout]]:
    """Twenty layouts of what people bring, with a name each."""
    layouts = [(sentence, layout_from_text(sentence, seed=seed)) for seed, sentence in enumerate(SENTENCES)]
    yield from layouts
    for name, layout in layouts[:4]:
        yield f"boxes: {name}", layout_from_boxes(layout.boxes())
    for name, layout in layouts[4:8]:
        picture = render(layout, Pinhole.from_hfov(WIDE, 720, 480))
        known = {"depth": picture.depth, "semantics": picture.labels, "masks": picture.instances, "hfov": WIDE}
        yield f"picture: {name}", layout_from_image(picture.pixels, **known)


def row(scans: dict[str, RangeImage], pose: np.ndarray) -> list[np.ndarray]:
    """The pictures of a row, by their captions."""
    return [view.caption(view.render_scan(scan, pose, by_label=True), name) for name, scan in scans.items()]


if __name__ == "__main__":
    main()
