"""Simulated scans in one picture, beside streets and recordings.

    python benches/picture_simulate.py [--data FOLDER] [-o simulated.png]
    python benches/picture_simulate.py --surroundings 5 -o docs/images/surroundings.png

Row by row: ten sentences in streets; clusterings of five recorded sweeps, and three coarse layouts of streets; then, to
hold them against, two of these sweeps as recorded, and three scans of the streets themselves. Colours are classes,
brightness is intensity. The recordings, PandaSet's and ika's in FOLDER (by default LIDARDRAFT_DATA), may be shown by
anyone. With --surroundings there are so many of 25 ordinary sentences, without and with the street around them.
"""

from __future__ import annotations

import argparse
import os
import textwrap
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import recordings
from lidardraft import Layout, Sensor, layout_from_cloud, layout_from_text, simulate, surround, view
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS
from lidardraft.streets import StreetConfig, streets
from report_detail import SENTENCES

SENSOR = PRESETS["hdl64e"]
STREETS = (2, 7, 11)  # pairs of seed 0
ORDINARY = (
    "two pedestrians at a crosswalk",
    "a bus 15 m ahead, three parked cars on the right",
    "a motorway with two trucks ahead",
    "a narrow alley between tall buildings, two people ahead",
    "a busy downtown intersection",
    "a quiet residential street with parked cars on both sides",
    "a crossroads with traffic lights, a bus waits",
    "a child runs onto the street between two parked cars",
    "a roundabout with three cars",
    "a country road with a tractor ahead",
    "a van overtakes a cyclist",
    "people waiting at a bus stop on the right",
    "a village street, an old man crosses the road",
    "a car comes towards us around a bend",
    "roadworks with cones on the right lane",
    "a tram ahead and cars on both sides",
    "a parking lot with many cars and a woman with a pram",
    "a school in the morning with many children",
    "a forest road, a deer 30 m ahead",
    "a fire truck at a T-junction",
    "a delivery van double parked, cars behind us",
    "an empty street at night",
    "an industrial area with a truck turning left",
    "a shopping street with a market stall and cyclists",
    "four cars in a queue at a red light",
)
SPLIT = PRESETS["os1-128"]  # the sensor of pictures without and with a street
VIEW, SPLIT_SIZE = (980, 560), (700, 400)  # pixels of the view of a scan's picture, and of it here
COLUMNS, GAP = 6, 4
COLOURS = 160
TITLE, TITLE_HEIGHT = (210, 210, 210), 15


def cell(points: np.ndarray, label: np.ndarray, intensity: np.ndarray, title: str) -> np.ndarray:
    """Points [N, 3] of the layout's frame in the colours of their classes, uint8 [240, 360, 3]."""
    bright = 0.4 + 0.6 * np.sqrt(intensity / max(float(np.percentile(intensity, 95)), 0.05)).clip(0.0, 1.0)
    colours = (view.colour_by_label(label) * bright[:, None]).astype(np.uint8)
    large = view.render_points(points, colours)
    height, width, _ = large.shape
    picture = Image.fromarray(large.reshape(height // 2, 2, width // 2, 2, 3).max(axis=(1, 3)))
    pen = ImageDraw.Draw(picture)
    pen.rectangle((0, 0, picture.width, TITLE_HEIGHT), fill=(0, 0, 0))
    pen.text((5, 2), title, fill=TITLE)
    return np.asarray(picture)


def simulated(layout: Layout, sensor: Sensor, seed: int, title: str) -> np.ndarray:
    """The cell of a layout."""
    scan = simulate(layout, sensor, seed=seed)
    points = scan.points() @ scan.pose[:3, :3].T + scan.pose[:3, 3]
    return cell(points, scan.labels(), scan.intensities(), title)


def recorded(sweep: Sweep, sensor: Sensor, title: str) -> np.ndarray:
    """The cell of a sweep."""
    assert sweep.label is not None
    assert sweep.intensity is not None
    points = sweep.points[sweep.valid] + [0.0, 0.0, sensor.mount_height]
    return cell(points, sweep.label[sweep.valid], sweep.intensity[sweep.valid], title)


def sweeps_of(folder: Path) -> Iterator[tuple[Sweep, Sensor, str]]:
    """Five sweeps: three of PandaSet, two of ika."""
    pandaset = recordings.pandar64(folder, 1800).labelled
    for place, number in (("PandaSet 001", 0), ("PandaSet 002", 0), ("PandaSet 002", 5)):
        yield pandaset[place][number], PRESETS["pandar64"], f"{place}, {number}"
    ika = recordings.vlp32c(folder, 1800).labelled
    for half, number in (("first half", 2), ("second half", 8)):
        yield ika[half][number], PRESETS["vlp32c"], f"ika, {half}, {number}"


def cells(folder: Path | None) -> Iterator[np.ndarray]:
    """All of them, in order."""
    for seed, sentence in enumerate(SENTENCES):
        layout = surround(layout_from_text(sentence, seed=seed), seed=seed)
        yield simulated(layout, SENSOR, seed, textwrap.shorten(sentence, 60))
    sweeps = list(sweeps_of(folder)) if folder is not None else []
    for sweep, sensor, name in sweeps:
        assert sweep.label is not None
        seen = sweep.valid & (sweep.label > 0)
        layout = layout_from_cloud(sweep.points[seen], sweep.label[seen], sensor_height=sensor.mount_height)
        yield simulated(layout, sensor, 0, f"clustering of {name}")
    pairs = [
        next(islice(streets(seed=0, config=StreetConfig(poses_per_street=1), start=number), 1)) for number in STREETS
    ]
    for pair in pairs:
        yield simulated(pair.layout, SENSOR, 0, f"layout of a street, {pair.style.source}")
    for sweep, sensor, name in sweeps[1:4:2]:
        yield recorded(sweep, sensor, f"recorded: {name}")
    for pair in pairs:
        scan = pair.scan
        assert scan.intensity is not None
        points = scan.points(pair.poses())
        yield cell(points, scan.label[scan.valid], scan.intensity[scan.valid], f"street itself, {pair.district}")


def sheet(pictures: list[np.ndarray]) -> np.ndarray:
    """The cells in rows."""
    height, width, _ = pictures[0].shape
    rows = -(-len(pictures) // COLUMNS)
    whole = np.zeros((rows * (height + GAP) - GAP, COLUMNS * (width + GAP) - GAP, 3), dtype=np.uint8)
    for number, picture in enumerate(pictures):
        top, left = number // COLUMNS * (height + GAP), number % COLUMNS * (width + GAP)
        whole[top : top + height, left : left + width] = picture
    return whole


def pairs_of_sentences(count: int) -> Iterator[np.ndarray]:
    """Scans of sentences as `Scan.picture` has them, without the street around them and with it."""
    for seed, sentence in enumerate(ORDINARY[:count]):
        bare = layout_from_text(sentence, seed=seed)
        for layout in (bare, surround(bare, seed=seed)):
            scan = simulate(layout, SPLIT, seed=seed)
            points, boxes = view.points_on_road(scan.image), layout.boxes()
            whole = Image.fromarray(view.render_returns(scan.image, points, boxes=boxes, title=sentence))
            yield np.asarray(whole.crop((0, 0, *VIEW)).resize(SPLIT_SIZE, Image.Resampling.LANCZOS))


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    parser.add_argument("--surroundings", type=int, metavar="N", help="N of 25 sentences, without and with a street")
    parser.add_argument("-o", "--output", type=Path, default=Path("simulated.png"), metavar="FILE")
    given = parser.parse_args()
    folder = None if given.data is None else Path(given.data)
    if given.surroundings is not None:
        pairs = Image.fromarray(view.sheet(list(pairs_of_sentences(given.surroundings)))).quantize(256)
        pairs.save(given.output, optimize=True)
        return
    picture = Image.fromarray(sheet(list(cells(folder))))
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(given.output, optimize=True)


if __name__ == "__main__":
    main()
