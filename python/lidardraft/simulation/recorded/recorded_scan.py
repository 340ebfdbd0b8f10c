"""A recorded scan as rays, ready for edits: the points of those that returned, and those that did not return."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from lidardraft.drafting.cloud.layout import layout_from_cloud
from lidardraft.errors import FormatError, UnknownNameError, check_type
from lidardraft.files import written_together
from lidardraft.formats.boxes import write_boxes
from lidardraft.formats.kitti import write_bin
from lidardraft.formats.point_fields import unit_intensity
from lidardraft.formats.recording import returns, rings_of_order
from lidardraft.formats.semantickitti import OUTLIER, write_label
from lidardraft.scene.box import Box
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, GROUND

RECORDED, INSERTED, FILLED = range(3)  # values of `made_up`
GROUND_IDS = [BY_NAME[name].id for name in GROUND]
_CELL, _AROUND, _LOW = 2.0, 5, 20  # m; cells across; percentile of their lowest heights that is ground
_RISE, _THICKNESS = 0.4, 0.25  # m from that height to the lowest point of a cell, and from there to the highest
_FLAT_WITHIN = 120.0  # m
_NEAR_GROUND = (2.0, 4.0, 8.0, 16.0)  # m around a place, in which to look for its height
_FEWEST = 5  # points for a height
_MOST_LOST = 4.0  # rays without a return, per return: with more, none are kept
_LEAST_STEP = 2e-4  # rad between two firings of one laser
_LEAST_AWAY = 1e-3  # m: a point straight below the sensor is as steep as one this far aside
_SECTORS = 72
_KINDS = {"intensity": np.float32, "label": np.uint8, "instance": np.uint32, "made_up": np.uint8}
RAY_FIELDS = ("points", "distance", "intensity", "label", "instance", "made_up", "source")


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordedScan:
    """A scan of `sensor` with `boxes` around objects, in the sensor's frame; R rays start at its origin.

    `points` f32 [R, 3] [m] are those of the returns, `distance` f32 [R] [m] their distances. A ray without a return has
    the distance 0 and its direction as its point. `intensity` f32 [R] is 0 to 1, `label` u8 [R] a class id, 0 if
    unknown, `instance` u32 [R]. `made_up` u8 [R] is `RECORDED`, `INSERTED` for returns of inserted objects, or `FILLED`
    for those that fill the shadow of a removed object. `source` i64 [R] is the index of a ray's recorded point, or of
    the point before it: it finds further columns of a file.
    """

    sensor: Sensor
    boxes: tuple[Box, ...]
    points: np.ndarray
    distance: np.ndarray
    intensity: np.ndarray
    label: np.ndarray
    instance: np.ndarray
    made_up: np.ndarray
    source: np.ndarray

    @classmethod
    def from_points(
        cls,
        points: np.ndarray,
        sensor: Sensor,
        *,
        boxes: Sequence[Box] | None = None,
        intensity: np.ndarray | None = None,
        label: np.ndarray | None = None,
        instance: np.ndarray | None = None,
        made_up: np.ndarray | None = None,
        ring: np.ndarray | None = None,
        intensity_scale: float | None = None,
    ) -> RecordedScan:
        """From points [N, 3] and their known values [N]. An intensity of `intensity_scale` becomes 1; by default the
        scale is that of their type if they are whole numbers, and else 1, which at most 1 % may exceed.

        Rays without a return are found in the gaps of each ring; the points' order gives the rings too (as in KITTI's
        files). Else they are the rays of `sensor` without a point. `boxes` are by default those of the clusters of
        each class. Raises `FormatError` on arrays that do not fit and on a scan without a return.
        each class. Raises `FormatError` on arrays that do not fit and on a scan without a return.
        """
        check_type("sensor", sensor, Sensor)
        given = {"intensity": intensity, "label": label, "instance": instance, "made_up": made_up, "ring": ring}
        known = {name: np.asarray(values) for name, values in given.items() if values is not None}
        if "intensity" in known:
            known["intensity"] = unit_intensity(known["intensity"], intensity_scale, of="the scan")
        points, known = returns(points, known | {"source": np.arange(len(points))})
        rays = {name: known.get(name, np.zeros(len(points))).astype(kind) for name, kind in _KINDS.items()}
        rays |= {"points": points, "distance": np.linalg.norm(points, axis=1), "source": known["source"]}
        if boxes is None:
            boxes = _boxes_of(points, rays["label"], rays["instance"], sensor)
        directions, places = _lost_rays(points, known.get("ring"), sensor)
        if len(places) <= _MOST_LOST * len(points):
            lost = {name: np.zeros(len(places), values.dtype) for name, values in rays.items()}
            lost |= {"points": directions.astype(np.float32), "source": known["source"][places - 1]}
            rays = {name: np.insert(values, places, lost[name], axis=0) for name, values in rays.items()}
        return cls(sensor=sensor, boxes=tuple(boxes), **rays)

    def __repr__(self) -> str:
        returns, made = np.count_nonzero(self.returned), np.count_nonzero(self.made_up)
        return f"RecordedScan({self.sensor!r}, {returns} returns, {made} of them made up, {len(self.boxes)} boxes)"

    @property
    def returned(self) -> np.ndarray:
        """The mask of rays with a return, bool [R]."""
        return self.distance > 0

    @cached_property
    def directions(self) -> np.ndarray:
        """The directions of the rays, f64 [R, 3], of length 1."""
        points = self.points.astype(np.float64)
        return points / np.where(self.returned, self.distance, 1.0)[:, None]

    @cached_property
    def is_ground(self) -> np.ndarray:
        """The mask of ground returns, bool [R]: by class, or by height if no return has a ground class."""
        return (np.isin(self.label, GROUND_IDS) if self.has_classes else ground_of(self.points)) & self.returned

    @cached_property
    def has_classes(self) -> bool:
        """Whether any recorded return has a ground class."""
        return bool(np.isin(self.label[self.made_up == RECORDED], GROUND_IDS).any())

    @cached_property
    def ground_points(self) -> np.ndarray:
        """The ground returns, f32 [G, 3]."""
        return self.points[self.is_ground]

    def ground_height(self, x: float, y: float) -> float:
        """z of the ground at a place [m]; that of flat ground if none was seen within 16 m."""
        ground = self.ground_points
        away = np.hypot(ground[:, 0] - x, ground[:, 1] - y)
        for reach in _NEAR_GROUND:
            near = ground[away < reach, 2]
            if len(near) >= _FEWEST:
                return float(np.median(near))
        return -self.sensor.mount_height

    def box(self, id: str) -> Box:
        """The box of that id; raises `UnknownNameError` if there is none."""
        for box in self.boxes:
            if box.id == id:
                return box
        known = ", ".join(box.id for box in self.boxes[:8]) + (", ..." if len(self.boxes) > 8 else "")
        raise UnknownNameError(f"no object has the id {id!r}; the scan has {known or 'none'}")

    def returns_per_box(self) -> list[int]:
        """The number of returns in each of `boxes`."""
        found = self.points[self.returned]
        return [int(box.contains(found).sum()) for box in self.boxes]

    def layout(self, where: np.ndarray) -> Layout:
        """The layout of the returns in the mask `where` bool [R], in the sensor's frame; empty if no ground is known.

        If no return has a ground class, ground returns are road and the others `other`."""
        some = where & self.returned
        label = self.label[some]
        if not self.has_classes:
            guess = np.where(self.is_ground[some], BY_NAME["road"].id, BY_NAME["other"].id)
            label = np.where(label == 0, guess, label).astype(np.uint8)
        layout = layout_from_cloud(self.points[some], label, instances=self.instance[some], sensor_height=0.0)
        return Layout(tuple(primitive for primitive in layout if primitive.shape != "plane"))

    def save(self, name: str | os.PathLike[str]) -> None:
        """Write the returns as `NAME.bin`, `.label`, `.npz`, `.boxes.json` and `.sensor.json`.

        The `.npz` has `xyz`, `intensity`, `label`, `instance`, `made_up` and `source`; in the `.label`, filled returns
        are SemanticKITTI's outliers. An earlier scan of that name is replaced as a whole. Raises `FormatError` if a
        file cannot be written; then none is.
        """
        from lidardraft.scan import SCAN_ENDINGS  # pictures come with it, which edits do not need

        kept = {field: getattr(self, field)[self.returned] for field in RAY_FIELDS if field != "distance"}
        with written_together(name, SCAN_ENDINGS) as stem:
            write_bin(f"{stem}.bin", kept["points"], kept["intensity"])
            filled = kept["made_up"] == FILLED
            write_label(f"{stem}.label", kept["label"], kept["instance"] * ~filled, raw=OUTLIER * filled)
            write_boxes(f"{stem}.boxes.json", self.boxes, self.returns_per_box())
            np.savez_compressed(f"{stem}.npz", xyz=kept.pop("points"), **kept)
            Path(f"{stem}.sensor.json").write_text(self.sensor.to_json())


def ground_of(points: np.ndarray) -> np.ndarray:
    """The mask of points [N, 3] on the ground, bool [N]: the lowest quarter metre of each cell of 2 m whose lowest
    point is about as low as those around it. Deeper points are mirror images."""
    from scipy.ndimage import percentile_filter  # slow to import

    near = np.flatnonzero(np.abs(points[:, :2]).max(axis=1) < _FLAT_WITHIN)
    side = int(2 * _FLAT_WITHIN / _CELL)
    x, y = np.floor((points[near, :2] + _FLAT_WITHIN) / _CELL).astype(np.intp).T
    lowest = np.full((side, side), np.inf, np.float32)
    np.minimum.at(lowest, (x, y), points[near, 2])
    for _ in range(2):  # again without mirror images
        usual = percentile_filter(lowest, _LOW, _AROUND)
        usual = np.where(np.isfinite(usual), usual, lowest)
        real = points[near, 2] > usual[x, y] - _RISE
        lowest = np.full_like(lowest, np.inf)
        np.minimum.at(lowest, (x[real], y[real]), points[near[real], 2])
    level = np.where(lowest < usual + _RISE, lowest, -np.inf)[x, y]
    found = np.zeros(len(points), bool)
    found[near] = real & (points[near, 2] < level + _THICKNESS)
    return found


def _boxes_of(points: np.ndarray, label: np.ndarray, instance: np.ndarray, sensor: Sensor) -> list[Box]:
    if not label.any():
        return []
    layout = layout_from_cloud(points, label, instances=instance, sensor_height=sensor.mount_height, detail="objects")
    return [box.seen_from(sensor.pose()) for box in layout.boxes()]


def _lost_rays(points: np.ndarray, ring: np.ndarray | None, sensor: Sensor) -> tuple[np.ndarray, np.ndarray]:
    """Directions [M, 3] of rays without a return, and the index of the point [N, 3] that each comes before, 1 to N."""
    try:
        ring = rings_of_order(points) if ring is None else ring
    except FormatError:
        lost = ~RangeImage.project(points, sensor).valid & ~sensor.blocked_pixels
        directions = sensor.pattern.directions()[lost]
        return directions, np.full(len(directions), len(points))
    x, y, z = points.astype(np.float64).T
    azimuth, slope = np.arctan2(y, x), z / np.maximum(np.hypot(x, y), _LEAST_AWAY)
    first = np.lexsort((azimuth, ring))
    starts = np.flatnonzero(np.diff(ring[first], prepend=-1))
    second = np.roll(first, -1)
    second[np.append(starts[1:], len(first)) - 1] = first[starts]  # each ring is closed
    gap = (azimuth[second] - azimuth[first]) % (2 * np.pi)
    steps = gap[gap > _LEAST_STEP]
    step = float(np.median(steps)) if len(steps) else np.pi
    missing = np.maximum(np.rint(gap / step).astype(np.intp) - 1, 0)
    if missing.sum() > _MOST_LOST * len(points):
        return np.zeros((0, 3)), np.zeros(0, np.intp)
    start = np.repeat(np.arange(len(missing)), missing)
    first, second, count = first[start], second[start], missing[start]
    number = np.arange(1, len(start) + 1) - (np.cumsum(missing) - missing)[start]
    share = np.where(first < second, number, count + 1 - number) / (count + 1)  # in the order of the points
    turned = azimuth[first] + share * gap[start]
    seen = np.bincount(_sector(azimuth), minlength=_SECTORS) > 0
    looked = seen[_sector(turned)]
    first, second, share, turned = first[looked], second[looked], share[looked], turned[looked]
    rise = slope[first] + share * (slope[second] - slope[first])
    directions = np.stack([np.cos(turned), np.sin(turned), rise], axis=1) / np.hypot(1.0, rise)[:, None]
    return directions, np.maximum(first, second)


def _sector(azimuth: np.ndarray) -> np.ndarray:
    """The sector of a turn; the scan does not look into sectors without any return."""
    return (azimuth % (2 * np.pi) * (_SECTORS / (2 * np.pi))).astype(np.intp) % _SECTORS
