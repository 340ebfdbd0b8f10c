"""Generated sequences and edits: how far what the network makes up stays where it was.

    python benches/report_generated.py [--frames 6]

- Flicker: of frames 0.1 s apart of each draft, brought into one frame, the returns within 30 m of what the layout
  leaves open: the share with a return of the frame before within 0.5 m, the same of those that are no ground, the share
  whose nearest one has their class, and the median distance from the plane through the eight nearest. Beside it frames
  from one noise, and from a noise of their own each.
- Edits: the first object of each draft is removed, or moved by 3 m ahead. Of the returns outside of the pixels that
  then cast otherwise, the share that is within 5 cm of before; with the same seed alone, and going on from the scan.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import warnings
from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from lidardraft import Pipeline, Scan, Sensor, layout_from_text, raycast
from lidardraft.scene import edit
from lidardraft.scene.visibility import open_pixels
from lidardraft.semantics import BY_NAME, GROUND
from lidardraft.simulation.sequence import SequenceSimulator

DRAFTS = (
    "a straight road, a car 15 m ahead, a bus on the left",
    "a left bend with parked cars on the right and a truck ahead",
    "a crossroads, a van 12 m ahead, two cyclists on the right",
)
SENSOR = dataclasses.replace(Sensor.preset("hdl64e"), columns=512)
FAR, NEAR, AROUND, CLOSE = 30.0, 0.5, 8, 0.05  # m from the sensor; m; neighbours of a plane; m


def made_up(scan: Scan) -> tuple[np.ndarray, np.ndarray]:
    """Points in the world and classes of the near returns of what the layout leaves open."""
    cast = raycast(scan.layout, scan.image.sensor, poses=scan.poses(), primitive=True)
    image = scan.image.keep(open_pixels(scan.layout, cast, scan.pose) & (scan.image.depth < FAR))
    return image.points(scan.poses()), image.label[image.valid]


def flicker(frames: Sequence[Scan]) -> np.ndarray:
    """The four figures of some frames in a row."""
    ground, rows = [BY_NAME[name].id for name in GROUND], []
    for (one, before), (two, label) in itertools.pairwise(map(made_up, frames)):
        off, nearest = cKDTree(one).query(two, AROUND)
        near, stands = off[:, 0] < NEAR, ~np.isin(label, ground)
        around = one[nearest[off[:, -1] < 2 * NEAR]]
        middle = around.mean(axis=1)
        normal = np.linalg.svd(around - middle[:, None], full_matrices=False)[2][:, 2]
        plane = np.abs(np.einsum("nk,nk->n", normal, two[off[:, -1] < 2 * NEAR] - middle))
        same = before[nearest[:, 0]] == label
        rows.append((near.mean(), near[stands].mean(), same.mean(), 1e3 * np.median(plane)))
    return np.mean(rows, axis=0)


def alone(pipeline: Pipeline, scan: Scan, seed: int) -> Scan:
    """A frame that knows of no other one."""
    cast = raycast(scan.layout, scan.image.sensor, poses=scan.poses(), primitive=True)
    image = pipeline.generate(cast, scan.image, open_pixels(scan.layout, cast, scan.pose), seed=seed)
    return dataclasses.replace(scan, image=image)


def kept(pipeline: Pipeline, sentence: str) -> list[tuple[float, float]]:
    """The shares of returns that two edits of a draft leave: with the same seed alone, and going on from the scan."""
    layout = layout_from_text(sentence, seed=0)
    name, scan = next(iter(layout.intent.objects)), pipeline(layout, sensor=SENSOR, seed=1)
    found = []
    for edited in (edit.remove(layout, name), edit.move(layout, name, (3.0, 0.0, 0.0))):
        casts = [raycast(one, SENSOR, scan.pose).depth for one in (layout, edited)]
        outside = (casts[0] == casts[1]) & scan.image.valid
        depths = [pipeline(edited, sensor=SENSOR, seed=1, after=after).image.depth for after in (None, scan)]
        one, two = (float((np.abs(depth - scan.image.depth) < CLOSE)[outside].mean()) for depth in depths)
        found.append((one, two))
    return found


def main() -> None:
    """Print all of it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--frames", type=int, default=6)
    frames = parser.parse_args().frames
    warnings.simplefilter("ignore")
    pipeline = Pipeline.from_pretrained("street")
    rows = {"a sequence": [], "one noise": [], "a noise each": []}  # type: dict[str, list[np.ndarray]]
    for sentence in DRAFTS:
        simulator = SequenceSimulator(layout_from_text(sentence, seed=0), SENSOR, frames=frames, speed=8.0)
        rows["a sequence"].append(flicker(list(pipeline.frames(simulator))))
        for name, step in (("one noise", 0), ("a noise each", 1)):
            rows[name].append(flicker([alone(pipeline, scan, step * n) for n, scan in enumerate(simulator)]))
    for name, figures in rows.items():
        near, stands, same, plane = np.mean(figures, axis=0)
        print(f"{name}: {near:.1%} within {NEAR} m, {stands:.1%} of no ground; class {same:.1%}; {plane:.0f} mm")
    edits = [pair for sentence in DRAFTS for pair in kept(pipeline, sentence)]
    for name, shares in zip(("the same seed alone", "going on from the scan"), zip(*edits, strict=True), strict=True):
        print(f"edits, {name}: {np.mean(shares):.2%} of returns within 5 cm, {min(shares):.2%} at least")


if __name__ == "__main__":
    main()
