"""How well vehicles are recovered from pictures: `python benches/report_image.py [--scenes 30] [--data FOLDER]`.

Pictures are rendered of layouts of sentences, with exact depth and classes, or with errors as networks make them. With
FOLDER (by default LIDARDRAFT_DATA) there are KITTI's labelled pictures too, whose depth is that of the LiDAR, and whose
classes are those of the labelled boxes; once as it is, and once off as networks are, which tells how corrections do on
roads that are not flat. Counted are vehicles with `FEWEST` pixels or more that the edge of the picture
does not cut; one is recovered by the nearest box of its class within `NEAREST`. A box knows no front from back.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from lidardraft import Box, Layout, layout_from_image, layout_from_text
from lidardraft.formats.kitti import read_bin
from lidardraft.semantics import BY_NAME
from rendered_pictures import RenderedPicture, as_networks_give_it, depth_errors, render

SENTENCES = (
    "a street with five parked cars on the left, three cars on the right, two people, houses and trees on both sides",
    "a crossroads with two cars turning, a bus 30 m ahead, a truck on the left, buildings on both sides",
    "a parking lot with twelve cars, three people",
    "a motorway with six cars ahead, two trucks on the right",
    "a curve with four cars, two vans parked on the right, hedges on both sides",
)
VEHICLES = ("car", "truck", "bus", "train")
FEWEST = 150  # pixels
WHOLE = 0.7  # of the pixels that an object would have if nothing stood before it; with fewer it is a hidden one
NEAREST = 2.0  # m
SPOILED = 6  # times each KITTI frame, which are few
CLOSE, STRAIGHT = 0.5, 5.0  # m and degrees, what is asked for


@dataclass(frozen=True, slots=True)
class Recovered:
    """How far the centre of an object is off seen from above [m], and its yaw [degrees]; NaN where none was found."""

    centre: float
    yaw: float


def compare(truth: Iterable[Box], layout: Layout) -> list[Recovered]:
    """What became of each object."""
    found = layout.boxes()
    rows = []
    for box in truth:
        same = [other for other in found if other.label == box.label]
        off = [math.dist(other.center[:2], box.center[:2]) for other in same]
        if not off or min(off) > NEAREST:
            rows.append(Recovered(math.nan, math.nan))
            continue
        best = same[int(np.argmin(off))]
        rows.append(Recovered(min(off), abs(math.degrees(math.remainder(best.yaw - box.yaw, math.pi)))))
    return rows


def visible(picture: RenderedPicture, layout: Layout, *, hidden: bool = False) -> list[Box]:
    """The vehicles with enough pixels, none of them on the edge of the picture; those that are (not) `hidden`."""
    edges = np.concatenate([picture.instances[[0, -1]].ravel(), picture.instances[:, [0, -1]].ravel()])
    found = []
    for box in layout.boxes():
        pixels = np.count_nonzero(picture.instances == box.instance)
        if box.label in VEHICLES and pixels >= FEWEST and box.instance not in edges:
            alone = Layout(tuple(primitive for primitive in layout if primitive.instance == box.instance))
            whole = np.count_nonzero(render(alone, picture.camera, **picture.stand).labels)
            if (pixels < WHOLE * whole) == hidden:
                found.append(box)
    return found


def rendered(scenes: int, *, networks: bool = False, hidden: bool = False) -> Iterator[list[Recovered]]:
    """The objects of each scene, with exact depth and classes or as `networks` give them."""
    for seed in range(scenes):
        layout = layout_from_text(SENTENCES[seed % len(SENTENCES)], seed=seed)
        picture = render(layout, pitch=0.03 * math.sin(seed), roll=0.02 * math.cos(seed))
        truth = visible(picture, layout, hidden=hidden)
        if networks:
            picture = as_networks_give_it(picture, seed)
        camera = picture.camera
        made = layout_from_image(
            picture.pixels,
            depth=picture.depth,
            semantics=picture.labels,
            intrinsics=(camera.fx, camera.fy, camera.cx, camera.cy),
        )
        yield compare(truth, made)


def kitti(folder: Path, *, spoiled: int = 0) -> Iterator[list[Recovered]]:
    """The cars of each labelled KITTI frame, with measured depth, or so many times with depth off as of networks."""
    for path in sorted(folder.glob("kitti/object*/**/label_2/*.txt")):
        frame = KittiFrame.read(path)
        known = {"semantics": frame.labels, "intrinsics": frame.projection}
        if not spoiled:
            yield compare(frame.cars, layout_from_image(frame.pixels, depth=frame.depth, camera_height=None, **known))
        for seed in range(spoiled):
            depth = depth_errors(frame.depth.shape, seed) * frame.depth
            yield compare(frame.cars, layout_from_image(frame.pixels, depth=depth, **known))


@dataclass(frozen=True, slots=True, eq=False)
class KittiFrame:
    """A picture with the depth that the LiDAR measured, classes, K, and the cars, from the camera (x ahead, y left)."""

    pixels: np.ndarray
    depth: np.ndarray
    labels: np.ndarray
    projection: np.ndarray
    cars: list[Box]

    @classmethod
    def read(cls, path: Path) -> KittiFrame:
        """The frame of a file in label_2."""
        top, name = path.parents[1], path.stem
        lines = (top / "calib" / f"{name}.txt").read_text().splitlines()
        calibration = {line.split(":")[0]: np.array(line.split(":")[1].split(), float) for line in lines if line}
        projection = calibration["P2"].reshape(3, 4)
        rectified = calibration["R0_rect"].reshape(3, 3) @ calibration["Tr_velo_to_cam"].reshape(3, 4)
        points, _ = read_bin(top / "velodyne" / f"{name}.bin")
        seen = points @ rectified[:, :3].T + rectified[:, 3]
        pixels = np.asarray(Image.open(top / "image_2" / f"{name}.png").convert("RGB"))
        rows = [line.split() for line in path.read_text().splitlines()]
        objects = [(row[0], np.array(row[1:], float)) for row in rows if row[0] != "DontCare"]
        labels = np.where(seen[:, 1] > 1.4, BY_NAME["road"].id, 0)  # the camera looks level, 1.65 m over the road
        for kind, values in objects:
            labels[_inside(seen, values)] = BY_NAME[_CLASSES.get(kind, "other")].id
        depth, label = _projected(seen, labels, projection, pixels.shape[:2])
        shift = projection[0, 3] / projection[0, 0]
        cars = [_box(k, values, shift) for k, (kind, values) in enumerate(objects, 1) if _counts(kind, values)]
        cars = [car for car, values in cars if np.count_nonzero(_inside(seen[labels > 0], values)) >= _FEWEST_POINTS]
        return cls(pixels, depth, label, projection, cars)


_CLASSES = {"Car": "car", "Van": "car", "Truck": "truck", "Cyclist": "rider", "Pedestrian": "person"}
_FEWEST_POINTS = 30  # of the LiDAR


def _counts(kind: str, values: np.ndarray) -> bool:
    return kind in ("Car", "Van") and values[0] == 0  # not cut by the edge of the picture


def _inside(seen: np.ndarray, values: np.ndarray) -> np.ndarray:
    """bool [N]: in a box of KITTI, whose bottom centre is in the frame of the camera; its lowest 0.1 m is ground."""
    height, width, length = values[7:10]
    x, y, z = (seen - values[10:13]).T
    cos, sin = math.cos(values[13]), math.sin(values[13])
    along, across = cos * x - sin * z, sin * x + cos * z
    inside: np.ndarray = (np.abs(along) < length / 2 + 0.1) & (np.abs(across) < width / 2 + 0.1)
    return inside & (y < -0.1) & (y > -height - 0.1)


def _box(number: int, values: np.ndarray, shift: float) -> tuple[Box, np.ndarray]:
    height, width, length = values[7:10].tolist()
    x, y, z = values[10:13].tolist()
    center = (z, -(x + shift), 1.65 - y + height / 2)
    yaw = -values[13].item() - math.pi / 2
    return Box(f"car_{number}", "car", number, center, (length, width, height), yaw), values


def _projected(
    seen: np.ndarray, labels: np.ndarray, projection: np.ndarray, shape: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Depth and class images [H, W] of points in the frame of the camera; the nearest point of a pixel counts."""
    u, v, w = projection[:, :3] @ seen.T + projection[:, 3:]
    ahead = w > 0.5
    column, row = (np.round(values[ahead] / w[ahead]).astype(int) for values in (u, v))
    inside = (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])
    order = np.argsort(-w[ahead][inside], kind="stable")
    at = row[inside][order], column[inside][order]
    depth, label = np.zeros(shape), np.zeros(shape, dtype=np.uint8)
    depth[at], label[at] = w[ahead][inside][order], labels[ahead][inside][order]
    return depth, label


def line(name: str, scenes: Iterable[list[Recovered]]) -> str:
    """A row of the table."""
    start = time.perf_counter()
    rows = [row for scene in scenes for row in scene]
    seconds = time.perf_counter() - start
    centres, yaws = np.array([(row.centre, row.yaw) for row in rows]).reshape(-1, 2).T
    found = np.isfinite(centres)
    if not found.any():
        return f"| {name} | {len(rows)} | 0 | - | - | - | {seconds:.0f} |"
    good = np.count_nonzero((centres < CLOSE) & (yaws < STRAIGHT))
    both = [f"{np.median(v[found]):.2f} / {np.percentile(v[found], 95):.2f}" for v in (centres, yaws)]
    return f"| {name} | {len(rows)} | {found.sum()} | {good} | {both[0]} | {both[1]} | {seconds:.0f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split(":")[0])
    parser.add_argument("--scenes", type=int, default=30, metavar="N", help="rendered scenes (default 30)")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    given = parser.parse_args()
    within = f"within {CLOSE} m and {STRAIGHT:.0f}°"
    print(f"| pictures | vehicles | found | {within} | centre [m] p50 / p95 | yaw [°] p50 / p95 | s |")
    print("|---|---:|---:|---:|---|---|---:|")
    print(line("rendered, exact depth and classes", rendered(given.scenes)))
    print(line("the same, vehicles more than 30 % hidden", rendered(given.scenes, hidden=True)))
    print(line("rendered, errors as of networks", rendered(given.scenes, networks=True)))
    if given.data is not None:
        print(line("KITTI, depth of the LiDAR, classes of the labels", kitti(Path(given.data))))
        print(line(f"the same, depth off as of networks, {SPOILED} times", kitti(Path(given.data), spoiled=SPOILED)))


if __name__ == "__main__":
    main()
