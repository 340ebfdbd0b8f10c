"""What weights make of unseen streets, between the layout's cast and the detailed scan; colours are classes.

python benches/generated_pictures.py WEIGHTS... -o PICTURE [--steps N] [--rows K ...]
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lidardraft import Pipeline, Sensor, view
from lidardraft.cli.arguments import whole_number
from lidardraft.evaluation import unseen_streets


def main() -> None:
    """Parse, generate, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("weights", nargs="+", help="packaged weights by name, or .safetensors files")
    parser.add_argument("--steps", type=whole_number(1), metavar="N", help="steps of denoising (default: as stored)")
    text = "which streets, counted from 1 (default 1 2 3 4)"
    parser.add_argument("--rows", type=whole_number(1), nargs="+", default=[1, 2, 3, 4], metavar="K", help=text)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="PICTURE", help="a .png file")
    given = parser.parse_args()
    pipelines = {Path(name).stem: Pipeline.from_pretrained(name, steps=given.steps) for name in given.weights}
    rows = [view.stack(row, across=True) for row in pictures(pipelines, given.rows)]
    view.save_png(given.output, view.stack(rows))


def pictures(pipelines: dict[str, Pipeline], numbers: list[int]) -> Iterator[list[np.ndarray]]:
    """A row of pictures each street."""
    streets = unseen_streets(max(numbers), sensor=Sensor.preset("hdl64e"))
    for pair in (streets[number - 1] for number in numbers):
        assert pair.simulated is not None
        scans = {"layout": pair.condition_image}
        for name, pipeline in pipelines.items():
            scans[name] = pipeline.generate(pair.condition_image, pair.simulated, seed=pair.index)
        scans["detailed scan"] = pair.scan
        yield [view.caption(view.render_scan(scan, pair.pose, by_label=True), name) for name, scan in scans.items()]


if __name__ == "__main__":
    main()
