"""A segmenter, tested on recorded scans: IoU of SemanticKITTI's 19 classes.

    python benches/segment_streets.py WEIGHTS [--pairs FOLDER] [--data FOLDER] [--json FILE]

IoU = TP / (TP + FP + FN), counted over all scans together (PASCAL VOC, Everingham et al., IJCV 2010); returns whose
truth is unlabelled count for nothing, as in SemanticKITTI's evaluator. The recorded scans lie under LIDARDRAFT_DATA (or
--data): SemanticKITTI's sequence 00 (frames 0 to 20 as range images of 64 x 1024 points, and frame 0 with all its
points), nuScenes', ika's and PandaSet's. KITTI and nuScenes judge; nothing is fitted to them. `--pairs` adds held-out
streets. What the segmenter says is turned into SemanticKITTI's classes so:

- wall is fence ("separators, like fences, small walls"), bus and train are other-vehicle; traffic-light and other are
  unlabelled, which is wrong wherever the truth is a class;
- a rider is a motorcyclist where most returns of two-wheelers within 1 m are of motorcycles, else a bicyclist; what is
  ridden belongs to the rider, as it does in SemanticKITTI;
- streets have no parking and no other-ground: both score 0, and count in the mean over all 19;
- what a data set does not tell apart is merged before it is scored: in nuScenes' and ika's images terrain and trunks
  are vegetation, riders and what they ride bicycles; in PandaSet trunks are vegetation, poles and walls have no class.
"""

from __future__ import annotations

import argparse
import io
import json
import lzma
import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from lidardraft.errors import LidarDraftError
from lidardraft.formats.kitti import read_bin
from lidardraft.metrics.sweep import Sweep
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter
from lidardraft.semantics import CLASSES
from lidardraft.training.sources import PairFolder
from recordings import nuscenes_images, pandar64, vlp32c

# semantic-kitti.yaml (Behley et al., ICCV 2019): the classes of the benchmark, and the raw ids of each.
NAMES = (
    *("unlabelled", "car", "bicycle", "motorcycle", "truck", "other-vehicle", "person", "bicyclist", "motorcyclist"),
    *("road", "parking", "sidewalk", "other-ground", "building", "fence", "vegetation", "trunk", "terrain", "pole"),
    "traffic-sign",
)
RAW = {
    **{10: 1, 252: 1, 11: 2, 15: 3, 18: 4, 258: 4, 13: 5, 16: 5, 20: 5, 256: 5, 257: 5, 259: 5, 30: 6, 254: 6},
    **{31: 7, 253: 7, 32: 8, 255: 8, 40: 9, 60: 9, 44: 10, 48: 11, 49: 12, 50: 13, 51: 14, 70: 15, 71: 16, 72: 17},
    **{80: 18, 81: 19},
}
OURS = {"wall": "fence", "bus": "other-vehicle", "train": "other-vehicle", "rider": "bicyclist"}
NOT_IN_STREETS = ("parking", "other-ground")
_RIDDEN = 1.0  # m from riders to the returns of what they ride
_KITTI_MOUNT = 1.73  # m, Geiger et al., IJRR 2013
_NUSCENES_MOUNT = 1.84  # m, Caesar et al., CVPR 2020
_IKA_MOUNT = 1.8  # m, that of the preset
_PANDASET_MOUNTS = {"001": 2.03, "002": 2.27}  # m, from the median height of near returns of the road
_TWO_WHEELERS = dict.fromkeys(("motorcycle", "bicyclist", "motorcyclist"), "bicycle")
_IN_NUSCENES = {"terrain": "vegetation", "trunk": "vegetation", "other-vehicle": "truck", "fence": "building"}
_IN_PANDASET = {"trunk": "vegetation", "bicyclist": "person", "motorcyclist": "person"}


@dataclass(frozen=True)
class LabelledCloud:
    """Points [N, 3], intensities [N] and the ids [N] of `NAMES` of a recorded scan."""

    points: np.ndarray
    intensity: np.ndarray
    truth: np.ndarray


def range_images(data: Path) -> Iterator[LabelledCloud]:
    """The range images, one point a pixel."""
    for path in sorted((data / "kitti/range_images_00").glob("??????.npy*")):
        raw = path.read_bytes()
        image = np.load(io.BytesIO(lzma.decompress(raw) if path.suffix == ".xz" else raw)).reshape(-1, 6)
        image = image[image[:, 4] > 0].astype(np.float32)
        yield LabelledCloud(image[:, :3], image[:, 3], image[:, 5].astype(np.uint8))


def whole_scans(data: Path) -> Iterator[LabelledCloud]:
    """The scans with all their points."""
    for path in sorted((data / "kitti/odometry_00/labels").glob("*.label")):
        points, intensity = read_bin(path.parents[1] / "velodyne" / f"{path.stem}.bin")
        table = np.zeros(2**16, dtype=np.uint8)
        table[list(RAW)] = list(RAW.values())
        yield LabelledCloud(points, intensity, table[np.fromfile(path, "<u4") & 0xFFFF])


def sweeps(found: Iterable[Sweep]) -> Iterator[LabelledCloud]:
    """Sweeps whose labels are classes of lidardraft; returns of class "other" have no truth."""
    for sweep in found:
        assert sweep.label is not None
        assert sweep.intensity is not None
        seen = (sweep.points != 0).any(axis=-1)
        points = sweep.points[seen]
        yield LabelledCloud(points, sweep.intensity[seen], benchmark_ids(points, sweep.label[seen]))


def held_out(folder: PairFolder) -> Iterator[LabelledCloud]:
    """The scans of streets as if they were recorded."""
    for i in range(len(folder)):
        scan = folder[i].scan
        assert scan.intensity is not None
        points = scan.points()
        yield LabelledCloud(points, scan.intensity[scan.valid], benchmark_ids(points, scan.label[scan.valid]))


def benchmark_ids(points: np.ndarray, label: np.ndarray) -> np.ndarray:
    """Ids u8 [N] of `NAMES` for the class ids [N] of lidardraft."""
    names = [OURS.get(row.name, row.name) for row in CLASSES]
    table = np.array([NAMES.index(name) if name in NAMES else 0 for name in names], dtype=np.uint8)
    ids = table[label]
    bicyclist, motorcyclist = NAMES.index("bicyclist"), NAMES.index("motorcyclist")
    rider, bicycle, motorcycle = (np.flatnonzero(ids == NAMES.index(n)) for n in ("bicyclist", "bicycle", "motorcycle"))
    ridden = np.concatenate([bicycle, motorcycle])
    if len(rider) and len(ridden):
        riders = cKDTree(points[rider])
        bicycles, motorcycles = (_around(riders, points[of]) for of in (bicycle, motorcycle))
        ids[rider] = np.where(motorcycles > bicycles, motorcyclist, bicyclist)
        distance, nearest = riders.query(points[ridden], distance_upper_bound=_RIDDEN)
        ids[ridden[np.isfinite(distance)]] = ids[rider[nearest[np.isfinite(distance)]]]
    return ids


def _around(riders: cKDTree, points: np.ndarray) -> np.ndarray:
    """How many of the points are within reach of each rider."""
    if len(points) == 0:
        return np.zeros(riders.n, dtype=np.int64)
    return np.array([len(found) for found in riders.query_ball_tree(cKDTree(points), _RIDDEN)])


def confusion_matrix(truth: np.ndarray, found: np.ndarray, classes: int) -> np.ndarray:
    """How often class t was labelled f, i64 [K, K] at [t, f], of class ids [...] from 0 to `classes` - 1.

    Class 0 is "unlabelled". Matrices of several scans are added. Raises `LidarDraftError` where ids or shapes do not
    fit.
    """
    if truth.shape != found.shape:
        raise LidarDraftError(f"truth is {truth.shape} and the labels found are {found.shape}; they must be the same")
    for name, ids in (("truth", truth), ("label found", found)):
        if ids.size and not 0 <= ids.min() <= ids.max() < classes:
            raise LidarDraftError(f"a {name} is {ids.min()} or {ids.max()}; ids are 0 to {classes - 1}")
    pairs = truth.ravel().astype(np.int64) * classes + found.ravel()
    return np.bincount(pairs, minlength=classes * classes).reshape(classes, classes)


@dataclass(frozen=True, slots=True, eq=False)
class ClassScores:
    """Of each class [K]: `iou`, NaN where it is neither there nor found, and `truth`, how many returns are of it."""

    iou: np.ndarray
    truth: np.ndarray

    @classmethod
    def from_confusion(cls, confusion: np.ndarray) -> ClassScores:
        """The scores of a matrix [K, K] of `confusion_matrix`; class 0 of the truth counts for nothing."""
        counted = confusion.copy()
        counted[0] = 0
        both, truth = np.diagonal(counted), counted.sum(axis=1)
        either = truth + counted.sum(axis=0) - both
        return cls(np.where(either > 0, both / np.maximum(either, 1), np.nan), truth)

    def mean(self, classes: Sequence[int]) -> float:
        """mIoU over these classes; one that is neither there nor found counts 0."""
        return float(np.nan_to_num(self.iou[list(classes)]).mean()) if len(classes) else float("nan")


def measure(
    segmenter: Segmenter, scans: Iterator[LabelledCloud], mount: float, merged: Mapping[str, str] | None = None
) -> tuple[np.ndarray, int, float]:
    """The confusion matrix over all scans, their number, and the seconds that one takes.

    `merged` names the classes that become another one before they are counted.
    """
    confusion, count, seconds = np.zeros((len(NAMES), len(NAMES)), dtype=np.int64), 0, 0.0
    becomes = np.array([NAMES.index((merged or {}).get(name, name)) for name in NAMES], dtype=np.uint8)
    for scan in scans:
        start = time.perf_counter()
        label = segmenter.label_points(scan.points, scan.intensity, mount)
        seconds += time.perf_counter() - start
        found = benchmark_ids(scan.points, label)
        confusion += confusion_matrix(becomes[scan.truth], becomes[found], len(NAMES))
        count += 1
    return confusion, count, seconds / max(count, 1)


def table(title: str, confusion: np.ndarray, count: int, seconds: float) -> str:
    """IoU and truth of each class, what it is most often taken for, and the means."""
    scores = ClassScores.from_confusion(confusion)
    lines = [f"## {title}: {count} scans, {scores.truth.sum()} labelled returns, {seconds:.2f} s a scan", ""]
    lines += ["| class | IoU | returns | found | most often taken for |", "|---|---|---|---|---|"]
    for k, name in enumerate(NAMES[1:], 1):
        row = confusion[k].copy()
        found, row[k] = confusion[k, k] / max(row.sum(), 1), 0
        taken = f"{NAMES[int(row.argmax())]} {row.max() / scores.truth[k]:.0%}" if row.any() else ""
        share = f"{found:.0%}" if scores.truth[k] else ""
        lines.append(f"| {name} | {100 * np.nan_to_num(scores.iou[k]):.1f} | {scores.truth[k]} | {share} | {taken} |")
    everything = range(1, len(NAMES))
    for what, classes in (
        ("all 19 classes (neither there nor found counts 0)", everything),
        ("the 17 that streets have", [k for k in everything if NAMES[k] not in NOT_IN_STREETS]),
        ("those with a truth here", [k for k in everything if scores.truth[k]]),
        ("those with a truth of 100 returns or more", [k for k in everything if scores.truth[k] >= 100]),
    ):
        lines.append(f"| **mIoU over {what}** | **{100 * scores.mean(classes):.1f}** | {len(classes)} classes | | |")
    return "\n".join([*lines, ""])


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("weights", help="weights.safetensors of lidardraft-train segmenter")
    parser.add_argument("--pairs", help="a folder of held-out streets")
    parser.add_argument("--data", default=os.environ.get("LIDARDRAFT_DATA", ""), help="folder with kitti/ in it")
    parser.add_argument("--json", help="file for the confusion matrices")
    arguments = parser.parse_args()
    segmenter, sets = weight_file.load(arguments.weights, Segmenter), {}
    if arguments.pairs:
        folder = PairFolder(arguments.pairs)
        sets["Held-out streets"] = measure(segmenter, held_out(folder), folder.sensor.mount_height)
    if (Path(arguments.data) / "kitti").is_dir() and arguments.data:
        data = Path(arguments.data)
        sets["SemanticKITTI 00, range images of frames 0 to 20"] = measure(segmenter, range_images(data), _KITTI_MOUNT)
        sets["SemanticKITTI 00, frame 0, every point"] = measure(segmenter, whole_scans(data), _KITTI_MOUNT)
        images = sweeps(nuscenes_images(data))
        merged = _IN_NUSCENES | _TWO_WHEELERS
        sets["nuScenes, HDL-32E, range images"] = measure(segmenter, images, _NUSCENES_MOUNT, merged)
        ahead = [sweep for half in vlp32c(data, 1800).labelled.values() for sweep in half]
        sets["ika, VLP-32C, 48 degrees ahead"] = measure(segmenter, sweeps(ahead), _IKA_MOUNT, merged)
        for place, found in pandar64(data, 1800).labelled.items():
            mount = _PANDASET_MOUNTS[place.split()[-1]]
            sets[f"{place}, Pandar64"] = measure(segmenter, sweeps(found), mount, _IN_PANDASET)
    else:
        print("no recorded scans: LIDARDRAFT_DATA does not name a folder with kitti/ in it", file=sys.stderr)
    for title, measured in sets.items():
        print(table(title, *measured))
    if arguments.json:
        matrices = {title: confusion.tolist() for title, (confusion, _, _) in sets.items()}
        Path(arguments.json).write_text(json.dumps({"classes": NAMES, "confusion": matrices}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
