"""How well detailed layouts obey the coarse ones, by class: Markdown tables.

    python benches/report_detail.py [--streets N] [--data FOLDER]

A cell is the share of the returns of a class in the bare cast of a coarse layout (hdl64e) for which another clean cast
from there returns within 0.5 m or 5 % and of the same class. That is the cast of `detail(layout)` for sentences and for
the coarse layouts of streets in each style; "street" is the detailed scene of the same street itself. For labelled
recordings in FOLDER (PandaSet's, by default in LIDARDRAFT_DATA) it is the share of the recorded returns of a class for
which the bare cast, and that of the detailed layout, of their clustering is as near: "bare" and "detailed".

Two more tables: how many of the returns in the boxes of vehicles lie behind their skin, recorded and in streets; and
how many returns the objects of sentences keep in the street around them.
"""

from __future__ import annotations

import argparse
import itertools
import os
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

from lidardraft import (
    Intent,
    Layout,
    RangeImage,
    Raycaster,
    Sensor,
    detail,
    layout_from_cloud,
    layout_from_text,
    raycast,
    surround,
)
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.labelling import agrees
from lidardraft.scene.layout import object_of
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME, CLASSES, GROUND, NUM_CLASSES
from lidardraft.simulation.sweeps import Sweeper
from lidardraft.streets.coarse.coarse_layout import BoxStyle, ClusterStyle, PictureStyle, TextStyle, coarse_layout
from lidardraft.streets.pairs import StreetScene, scan_street
from lidardraft.streets.scans import street_scan
from lidardraft.streets.street import StreetConfig, make_street
from object_labels import behind_skin, pandaset_frames
from recordings import pandar64

SENSOR = PRESETS["hdl64e"]
SENTENCES = (
    "a car ahead and a van behind, trees on both sides",
    "a busy crossroads with pedestrians crossing and buildings along both sides",
    "a quiet residential street with houses, gardens, trees and parked cars on both sides",
    "a motorway with three lanes, a bus, trucks on the right and a motorcycle behind",
    "a street with street lights and benches on the right, hedges on the left and a tram ahead",
    "a fence on the left, a wall on the right, a few bushes, two traffic signs and a cyclist",
    "a t-junction with traffic lights, three pedestrians on the left sidewalk, a bin and poles on the right",
    "a road curving to the left with houses on the left, fences on the right and two bicycles",
    "a narrow street with parked cars on both sides, buildings on the left and a truck ahead",
    "five oncoming cars, many trees on the left, a house on the right and a motorcycle ahead",
)
SEEDS = 3  # of each sentence
STYLES = (TextStyle(), ClusterStyle(), PictureStyle(), BoxStyle())
POSES = 2  # of each street
SKIN = 0.3  # m behind the sides or the roof of a vehicle
# Classes of vehicles, and what they are in PandaSet.
VEHICLES = {"car": ("Car",), "truck": ("Medium-sized Truck", "Semi-truck"), "bus": ("Bus",)}

Counts = dict[str, np.ndarray]  # by column: agreeing returns and all [2, K]


def add(counts: Counts, column: str, given: RangeImage, other: RangeImage) -> None:
    """Count the returns of `given`, and those with which `other` agrees."""
    same = agrees(other, given) & (other.label == given.label)
    found = counts[column]
    found[0] += np.bincount(given.label[given.valid & same], minlength=NUM_CLASSES)
    found[1] += np.bincount(given.label[given.valid], minlength=NUM_CLASSES)


def report(counts: Counts) -> str:
    """The table: a row a class, and one of all but ground; a column each, with the returns of the first."""
    rows = {row.name: [row.id] for row in CLASSES[1:]}
    rows["all objects"] = [row.id for row in CLASSES[1:] if row.name not in GROUND]
    lines = [f"| | {' | '.join(counts)} | returns |", "|---" * (len(counts) + 2) + "|"]
    for name, ids in rows.items():
        cells = [found[:, ids].sum(axis=1) for found in counts.values()]
        if any(total for _, total in cells):
            shares = [f"{near / total:.2f}" if total else "" for near, total in cells]
            lines.append(f"| {name} | {' | '.join(shares)} | {max(total for _, total in cells):.0f} |")
    return "\n".join(lines)


def new_counts() -> Counts:
    """Without a return."""
    return defaultdict(lambda: np.zeros((2, NUM_CLASSES)))


def of_sentences(counts: Counts, sentences: tuple[str, ...] = SENTENCES, seeds: int = SEEDS) -> list[float]:
    """Add the layouts of sentences; returns milliseconds of `detail` for a hundred objects, of each."""
    times = []
    for sentence in sentences:
        for seed in range(seeds):
            layout = layout_from_text(sentence, seed=seed)
            start = time.process_time()
            detailed = detail(layout, seed=seed)
            taken = time.process_time() - start
            times.append(1e5 * taken / len({object_of(primitive) for primitive in layout}))
            add(counts, "sentences", raycast(layout, SENSOR), raycast(detailed, SENSOR))
    return times


def of_streets(counts: Counts, number: int) -> None:
    """Add the coarse layouts of a street in every style, and its own detailed scene beside each."""
    street = make_street(seed=11, config=StreetConfig(sensor=SENSOR), number=number)
    whole = StreetScene.of(street, Sweeper.of(SENSOR, None, None))
    caster = Raycaster(street.scene)
    for index in range(POSES):
        ego, visible, rng = scan_street(whole, index)
        scene = caster.scan(SENSOR, ego.pose @ visible.pose)
        for style in STYLES:
            table = coarse_layout(street.coarse, style, rng, ego.pose, visible)
            layout = table.layout({"source": style.source}, intent=Intent(headed=style.source != "cloud"))
            bare = raycast(layout, SENSOR, visible.pose)
            add(counts, f"{style.source}", bare, raycast(detail(layout, seed=number), SENSOR, visible.pose))
            add(counts, f"{style.source}: street", bare, scene)


def of_recording(counts: Counts, sweep: Sweep, sensor: Sensor) -> Layout:
    """Add a labelled sweep beside the casts of its clustering, which is returned."""
    assert sweep.label is not None
    seen = (sweep.depth > 0) & (sweep.label > 0)
    points, label = sweep.points[seen], sweep.label[seen]
    recorded = RangeImage.project(points, sensor, label=label)
    layout = layout_from_cloud(points, label, sensor_height=sensor.mount_height)
    add(counts, "bare", recorded, raycast(layout, sensor))
    add(counts, "detailed", recorded, raycast(detail(layout), sensor))
    return layout


def of_skins(data: Path | None, number: int) -> str:
    """A row a class of vehicle: of the returns in its boxes the share over `SKIN` behind the nearest side or the roof,
    and their number: those of PandaSet, and those of streets seen by its sensor."""
    found: dict[tuple[str, str], list[np.ndarray]] = defaultdict(list)
    for index in range(number):
        scan = street_scan(index, seed=11, config=StreetConfig(sensor=PRESETS["pandar64"], poses_per_street=2))
        points, instances = scan.points()[:, :3].astype(np.float64), scan.instances()
        for box in scan.boxes():
            if box.label in VEHICLES:
                found[box.label, "streets"].append(behind_skin(box, points[instances == box.instance]))
    for label, classes in VEHICLES.items() if data is not None else ():
        for frame in pandaset_frames(Path(data), classes):
            points = frame.points[frame.labels == BY_NAME[label].id]
            found[label, "recorded"] += [behind_skin(box, points) for box in frame.cars]
    lines = ["| | recorded | streets |", "|---|---:|---:|"]
    for label in VEHICLES:
        depths = [np.concatenate([np.zeros(0), *found[label, origin]]) for origin in ("recorded", "streets")]
        cells = [f"{np.mean(one > SKIN):.2f} ({len(one)})" if len(one) else "" for one in depths]
        lines.append(f"| {label} | {' | '.join(cells)} |")
    return "\n".join(lines)


def of_surroundings(sentences: tuple[str, ...] = SENTENCES, seeds: int = SEEDS) -> str:
    """How many returns the vehicles and people of sentences have in the street around them, of those without it."""
    counts = []
    for sentence, seed in itertools.product(sentences, range(seeds)):
        layout = layout_from_text(sentence, seed=seed)
        asked = np.array([BY_NAME[primitive.label].is_thing for primitive in layout])
        for each in (layout, surround(layout, seed=seed)):
            image = raycast(each, SENSOR, primitive=True)
            seen = np.bincount(image.primitive[image.valid], minlength=len(each))
            counts.append(seen[: len(layout)][asked])
    before, after = np.concatenate(counts[::2]), np.concatenate(counts[1::2])
    lost = np.mean(after[before >= 20] < 0.9 * before[before >= 20])
    return (
        f"{after.sum()} of {before.sum()} returns; of {len(before)} shapes {lost:.1%} lose over a tenth of 20 or more"
    )


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--streets", type=int, default=12, metavar="N", help="how many streets (default 12)")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    arguments = parser.parse_args()
    counts = new_counts()
    times = of_sentences(counts)
    for number in range(arguments.streets):
        of_streets(counts, number)
    print(report(counts))
    print(f"\ndetail takes {np.median(times):.1f} ms for a hundred objects (median of {len(times)} sentences)")
    if arguments.data is not None:
        counts = new_counts()
        for sweeps in pandar64(Path(arguments.data), 1800).labelled.values():
            for sweep in sweeps:
                of_recording(counts, sweep, PRESETS["pandar64"])
        print(f"\n{report(counts)}" if counts else "")
    print(f"\nreturns over {SKIN} m behind the skin of vehicles:\n\n{of_skins(arguments.data, 4 * arguments.streets)}")
    print(f"\nvehicles and people of sentences in their streets: {of_surroundings()}")


if __name__ == "__main__":
    main()
