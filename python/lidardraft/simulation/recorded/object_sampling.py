"""Augmentation of recorded scans with detailed objects and their true shadows, for detectors' pipelines.

Ground-truth sampling pastes the points of objects into other scans: they hide nothing and have the wrong density. Here
each object is cast along the scan's own rays: returns that it hides go, and it returns as the sensor would see it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lidardraft.errors import LayoutError, check_seed, check_type
from lidardraft.scene.box import Box
from lidardraft.scene.check import VEHICLE_LABELS
from lidardraft.scene.pose import point_at
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.recorded.recorded_scan import RECORDED, RecordedScan
from lidardraft.simulation.recorded.scan_edits import check_room, inserted
from lidardraft.simulation.recorded.solid_object import SolidObject

_CLASS_OF_NAME = {"pedestrian": "person", "cyclist": "rider", "van": "car"}  # by names of data sets in lower case
_NAME_OF_KIND = {kind: kind.title() for kind in ("car", "truck", "bus", "cyclist")}
_NAME_OF_KIND |= {"van": "Car", "person": "Pedestrian"}
_TRIES = 16  # places to try for an object
_ROOM = 0.3  # m around it without returns of other things
_CELL, _HALF = 0.4, 200  # m; cells on each side: the grid of other returns
_WOBBLE = 0.1  # rad, standard deviation of headings along others
_ANY_WAY = ("person", "bicycle", "motorcycle")


class ObjectSampling:
    """A callable that adds objects, with their shadows, to the samples of a detector's pipeline.

    `counts` gives the total number of objects of each kind (`solid_object.WORDS`) in a scan, as OpenPCDet's
    SAMPLE_GROUPS does. They stand on free ground that the sensor sees, between `distances` [m]. Each kind has `models`
    different ones, made once. `names` maps each kind to its name in `gt_names`; `intensity_scale` is the number for an
    intensity of 1, such as 255 in nuScenes (default 1). Equal instances give the same samples in the same order of
    calls; each worker needs its own `seed`. Raises `LayoutError` for an unknown kind.
    """

    def __init__(
        self,
        counts: Mapping[str, int],
        sensor: Sensor,
        *,
        distances: tuple[float, float] = (4.0, 50.0),
        models: int = 24,
        names: Mapping[str, str] | None = None,
        intensity_scale: float | None = None,
        seed: int = 0,
    ) -> None:
        check_type("sensor", sensor, Sensor)
        if not 0 <= distances[0] < distances[1]:
            raise LayoutError(f"distances are {distances}; they must ascend from 0 or more")
        for what, number, least in (("models", models, 1), *((kind, count, 0) for kind, count in counts.items())):
            if not isinstance(number, int) or number < least:
                raise LayoutError(f"{what}: {number!r} is not a whole number from {least}")
        self.counts, self.sensor, self.distances = dict(counts), sensor, distances
        self.intensity_scale = intensity_scale
        self.names = dict(_NAME_OF_KIND if names is None else names)
        self._rng = np.random.default_rng(check_seed(seed))
        self._models = {
            kind: [SolidObject.of_kind(kind, name=f"{kind}_{number}", seed=seed) for number in range(models)]
            for kind in counts
        }

    def __call__(self, sample: dict[str, Any]) -> dict[str, Any]:
        """The sample with more objects in `points` [N, 3 + C] (x y z, intensity, other columns), `gt_boxes` [M, 7 or
        more] (centre, length, width, height, heading) and `gt_names` [M]. A boolean `gt_boxes_mask` grows too. The
        other columns of an object's points are those of the points that its rays had."""
        points, boxes, names = sample["points"], np.asarray(sample["gt_boxes"]), np.asarray(sample["gt_names"])
        fields = {"intensity": points[:, 3]} if points.shape[1] > 3 else {}
        given, scale = _boxes(boxes, names), self.intensity_scale
        scan = RecordedScan.from_points(points[:, :3], self.sensor, boxes=given, intensity_scale=scale, **fields)
        free, chosen = _FreeGround(scan), list[tuple[SolidObject, Box]]()
        for kind, count in self.counts.items():
            have = int((names == self.names.get(kind, kind)).sum())
            for _ in range(count - have):
                if one := self._sampled(scan, free, kind, [box for _, box in chosen]):
                    chosen.append(one)
        scan = inserted(scan, chosen, int(self._rng.integers(2**31)))
        added = [box for _, box in chosen]
        rows = np.zeros((len(added), boxes.shape[1] if boxes.size else 7), boxes.dtype if boxes.size else np.float32)
        rows[:, :7] = np.array([(*box.center, *box.size, box.yaw) for box in added]).reshape(-1, 7)
        kinds = [self.names.get(kind, kind) for kind in (box.id.rpartition("_")[0] for box in added)]
        changed = {
            "points": _as_given(scan, points, scale or 1.0),
            "gt_boxes": np.concatenate([boxes.reshape(-1, rows.shape[1]), rows]),
            "gt_names": np.concatenate([names, np.array(kinds, dtype=names.dtype if names.dtype.kind == "O" else str)]),
        }
        if "gt_boxes_mask" in sample:
            changed["gt_boxes_mask"] = np.concatenate([sample["gt_boxes_mask"], np.ones(len(added), bool)])
        return sample | changed

    def _sampled(
        self, scan: RecordedScan, free: _FreeGround, kind: str, taken: list[Box]
    ) -> tuple[SolidObject, Box] | None:
        """An object in a free place, or None if no tried place is free."""
        rng, models = self._rng, self._models[kind]
        solid = models[int(rng.integers(len(models)))]
        for x, y, z in free.places(rng.uniform(*self.distances, _TRIES)):
            center, yaw = (x, y, z + solid.size[2] / 2), self._heading(kind, (x, y), scan.boxes)
            box = Box(f"{kind}_{len(taken) + 1}", solid.label, len(taken) + 1, center, solid.size, yaw)
            if free.has_room(box):
                try:
                    check_room(replace(scan, boxes=(*scan.boxes, *taken)), box)
                except LayoutError:
                    continue
                return solid, box
        return None

    def _heading(self, kind: str, at: tuple[float, float], boxes: Sequence[Box]) -> float:
        """A heading along the nearest vehicle, or else along x, either way; any heading for people and cycles."""
        if kind in _ANY_WAY:
            return float(self._rng.uniform(-math.pi, math.pi))
        vehicles = [box for box in boxes if box.label in VEHICLE_LABELS]
        along = min(vehicles, key=lambda box: math.dist(box.center[:2], at)).yaw if vehicles else 0.0
        return float(along + self._rng.choice([0.0, math.pi]) + self._rng.normal(0.0, _WOBBLE))


class _FreeGround:
    """The seen ground of a scan, and the cells taken by other returns."""

    def __init__(self, scan: RecordedScan) -> None:
        order = np.argsort(scan.ground_points[:, 0] ** 2 + scan.ground_points[:, 1] ** 2)
        self._ground = scan.ground_points[order]
        self._away = np.hypot(*self._ground[:, :2].T)
        standing = scan.points[scan.returned & ~scan.is_ground]
        cells = np.floor(standing[:, :2] / _CELL).astype(np.intp) + _HALF
        cells = cells[((cells >= 0) & (cells < 2 * _HALF)).all(axis=1)]
        self._taken = np.zeros((2 * _HALF, 2 * _HALF), bool)
        self._taken[cells[:, 0], cells[:, 1]] = True

    def places(self, away: np.ndarray) -> list[list[float]]:
        """Places x, y, z on the ground at distances `away` [m], in any direction."""
        if not len(self._ground):
            return []
        found = np.minimum(np.searchsorted(self._away, away), len(self._ground) - 1)
        places: list[list[float]] = self._ground[found].tolist()
        return places

    def has_room(self, box: Box) -> bool:
        """Whether no return of an object lies in the footprint of a box or around it."""
        length, width = (
            np.arange(-0.5, 0.51, 1.0 / math.ceil((e + 2 * _ROOM) / _CELL)) * (e + 2 * _ROOM) for e in box.size[:2]
        )
        ahead, aside = (axis.ravel() for axis in np.meshgrid(length, width))
        x, y = point_at((*box.center[:2], box.yaw), ahead, aside)
        cells = np.floor(np.stack([x, y]) / _CELL).astype(np.intp) + _HALF
        return bool(((cells >= 0) & (cells < 2 * _HALF)).all()) and not self._taken[cells[0], cells[1]].any()


def _boxes(rows: np.ndarray, names: np.ndarray) -> list[Box]:
    """The boxes of `gt_boxes` [M, 7 or more], with `gt_names` of any data set."""
    boxes = []
    for number, (row, name) in enumerate(zip(rows.tolist(), names.tolist(), strict=True), start=1):
        word = str(name).lower()
        label = _CLASS_OF_NAME.get(word, word if word in BY_NAME else "other")
        boxes.append(Box(f"given_{number}", label, number, tuple(row[:3]), tuple(row[3:6]), row[6]))
    return boxes


def _as_given(scan: RecordedScan, given: np.ndarray, scale: float) -> np.ndarray:
    """The returns with all given columns, unchanged except for those of added objects."""
    there = scan.returned
    points, made = given[scan.source[there]], scan.made_up[there] != RECORDED
    points[made, :3] = scan.points[there][made]
    if given.shape[1] > 3:
        points[made, 3] = scan.intensity[there][made] * scale
    return points
