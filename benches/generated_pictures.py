"""What weights make of four fixed layouts, side by side: the looks of a training's hours.

    python benches/generated_pictures.py WEIGHTS... -o PICTURE [--steps N]

A row each layout. Weights that make whole scans are given four unseen streets, between the layout's cast and the
detailed scan; weights that complete are given four sentences, beside the simulated scan. Colours are classes.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lidardraft import Pipeline, RangeImage, Sensor, layout_from_text, simulate, view
from lidardraft.cli.arguments import whole_number
from lidardraft.diffusion.sampling_defaults import STEPS
from lidardraft.evaluation import unseen_streets
from lidardraft.scene.pose import Pose

SENTENCES = (
    "a car ahead",
    "two parked cars on the left, trees along both sides",
    "a crossroads with a bus, cars and people",
    "a truck behind a cyclist on the right",
)


def main() -> None:
    """Parse, generate, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("weights", nargs="+", help="packaged weights by name, or .safetensors files")
    parser.add_argument("--steps", type=whole_number(1), default=STEPS, metavar="N", help="steps of denoising")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="PICTURE", help="a .png file")
    given = parser.parse_args()
    pipelines = {name: Pipeline.from_pretrained(name, steps=given.steps) for name in given.weights}
    if len({pipeline.denoiser.config.completes for pipeline in pipelines.values()}) > 1:
        parser.error("some of these weights complete, others make whole scans")
    rows = (completed if pipeline_completes(pipelines) else whole)(pipelines, Sensor.preset("hdl64e"))
    view.save_png(given.output, view.stack([view.stack(row, across=True) for row in rows]))


def pipeline_completes(pipelines: dict[str, Pipeline]) -> bool:
    """Whether these weights complete."""
    return next(iter(pipelines.values())).denoiser.config.completes


def whole(pipelines: dict[str, Pipeline], sensor: Sensor) -> Iterator[list[np.ndarray]]:
    """A row of pictures each street."""
    for pair in unseen_streets(4, sensor=sensor):
        assert pair.simulated is not None
        scans = {"layout": pair.condition_image}
        for name, pipeline in pipelines.items():
            scans[Path(name).stem] = pipeline.generate(pair.condition_image, pair.simulated, seed=pair.index)
        yield row(scans | {"detailed scan": pair.scan}, pair.pose)


def completed(pipelines: dict[str, Pipeline], sensor: Sensor) -> Iterator[list[np.ndarray]]:
    """A row of pictures each sentence."""
    for seed, sentence in enumerate(SENTENCES):
        layout = layout_from_text(sentence, seed=seed)
        simulated = simulate(layout, sensor, seed=seed)
        scans = {sentence: simulated.image}
        for name, pipeline in pipelines.items():
            scans[Path(name).stem] = pipeline(layout, sensor=sensor, seed=seed).image
        yield row(scans, simulated.pose)


def row(scans: dict[str, RangeImage], pose: Pose) -> list[np.ndarray]:
    """The pictures of a row, by their captions."""
    return [view.caption(view.render_scan(scan, pose, by_label=True), name) for name, scan in scans.items()]


if __name__ == "__main__":
    main()
