"""Pairs of recorded scans: the scan of a sensor, and the cast and simulated scan of a layout made from it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lidardraft.drafting.cloud.layout import layout_from_cloud
from lidardraft.errors import FormatError
from lidardraft.formats.pairs import Pair
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import CLASSES, NUM_CLASSES
from lidardraft.simulation.simulate import simulate

_MOST_OUTSIDE = 0.25  # of the points; with the right sensor up to 0.05 are out of range or above the highest beam
_FEWEST = 0.05  # of the pixels; a scan has more returns
_NEAR = (0.5, 0.05)  # m, and of the range: the layout explains a return this near
_NAMED = 0.01  # of the returns: rarer classes are counted together


@dataclass(frozen=True, kw_only=True, eq=False)
class LabelledCloud:
    """`points` f32 [N, 3] in the sensor frame [m], `intensity` f32 [N] in 0 to 1, class ids `label` u8 [N], and numbers
    of objects `instance` u32 [N], None if unknown."""

    points: np.ndarray
    intensity: np.ndarray
    label: np.ndarray
    instance: np.ndarray | None = None


@dataclass
class ReturnShares:
    """Shares of all returns of recordings: of each class, of those that their layouts explain, and of those with
    another class in the layouts."""

    classes: np.ndarray = field(default_factory=lambda: np.zeros(NUM_CLASSES, np.int64))
    near: int = 0
    other: int = 0

    def add(self, pair: Pair) -> None:
        """Count the returns of one more scan."""
        scan, cast = pair.scan, pair.condition_image
        off = np.abs(scan.depth - cast.depth)
        near = scan.valid & cast.valid & (off <= np.maximum(_NEAR[0], _NEAR[1] * scan.depth))
        self.classes += np.bincount(scan.label[scan.valid], minlength=NUM_CLASSES)
        self.near += int(near.sum())
        self.other += int((near & (scan.label > 0) & (scan.label != cast.label)).sum())

    def __str__(self) -> str:
        total = max(int(self.classes.sum()), 1)
        often = [number for number in np.argsort(-self.classes, kind="stable") if self.classes[number] > _NAMED * total]
        named = [f"{CLASSES[number].name} {self.classes[number] / total:.0%}" for number in often]
        rest = 1 - self.classes[often].sum() / total
        shares = ", ".join([*named, f"others {rest:.0%}"] if rest >= _NAMED / 2 else named)
        return (
            f"new returns: {shares}; {self.near / total:.0%} explained by the layouts (within {_NEAR[0]:g} m or "
            f"{_NEAR[1]:.0%}), {self.other / max(self.near, 1):.1%} of them as another class"
        )


def recorded_pair(scan: LabelledCloud, sensor: Sensor, *, seed: int = 0) -> Pair:
    """The pair of a recorded scan: on the grid of `sensor`, with the cast and the simulated scan of its layout.

    The layout is that of `layout_from_cloud`, scanned from the place of the sensor, at rest. Raises `FormatError` if
    the points do not fit the sensor, `LayoutError` if they give no layout.
    """
    image = on_grid(scan, sensor)
    if not (scan.label > 0).any():
        raise FormatError("no point has a class; a layout is made of classes")
    layout = layout_from_cloud(scan.points, scan.label, instances=scan.instance, sensor_height=sensor.mount_height)
    return Pair(image, raycast(layout, sensor, sensor.pose()), simulate(layout, sensor, seed=seed, carrier=False).image)


def on_grid(scan: LabelledCloud, sensor: Sensor) -> RangeImage:
    """The recording as an image of `sensor`, in which an empty pixel is, as far as possible, a firing without a return.

    A firing's azimuth is not exactly that of a column: two returns may share a pixel beside one that stays empty, as if
    a firing had been dropped. Then the further return gets the empty pixel. Points that the vehicle hides are left out.
    """
    row, column, depth = sensor.pattern.project(np.ascontiguousarray(scan.points, dtype=np.float64))
    seen = row >= 0
    if seen.mean() < 1 - _MOST_OUTSIDE:
        raise FormatError(f"{1 - seen.mean():.0%} of the points are where no beam of {sensor.name} looks")
    found = RangeImage.empty(sensor)
    intensity = np.zeros(sensor.shape, dtype=np.float32)
    order = np.argsort(depth, kind="stable")
    left = order[seen[order]]  # the nearest first: it keeps its own pixel
    for aside in (0, -1, 1):
        beside = column[left] + aside
        inside = np.ones(len(left), dtype=bool) if sensor.wraps else (beside >= 0) & (beside < sensor.columns)
        beside %= sensor.columns
        pixels = row[left].astype(np.int64) * sensor.columns + beside
        _, first = np.unique(pixels, return_index=True)
        taken = np.zeros(len(left), dtype=bool)
        taken[first] = True
        taken &= inside & (found.depth[row[left], beside] == 0)
        points, where = left[taken], (row[left[taken]], beside[taken])
        found.depth[where], found.label[where], intensity[where] = (
            depth[points],
            scan.label[points],
            scan.intensity[points],
        )
        left = left[~taken]
    image = RangeImage(
        sensor=sensor, depth=found.depth, label=found.label, instance=found.instance, intensity=intensity
    ).keep(~sensor.blocked_pixels)
    if image.valid.mean() < _FEWEST:
        raise FormatError(f"only {image.valid.mean():.1%} of the pixels of {sensor.name} have a return")
    return image


def beside_beams(scan: LabelledCloud, sensor: Sensor) -> float:
    """The median distance of the points from the elevations of the beams, in shares of the beams' spacing: 0 for the
    right sensor, 0.25 for an unrelated one."""
    if len(sensor.elevations) < 2:
        return 0.0
    points = scan.points.astype(np.float64)
    row, _, _ = sensor.pattern.project(points)
    row, points = row[row >= 0], points[row >= 0]
    if not len(row):
        return 0.0
    elevations = np.array(sensor.elevations)
    forward, height = (
        np.array(table or np.zeros_like(elevations)) for table in (sensor.origin_forwards, sensor.origin_heights)
    )
    elevation = np.arctan2(points[:, 2] - height[row], np.hypot(points[:, 0], points[:, 1]) - forward[row])
    spacing = np.abs(np.gradient(elevations))
    return float(np.median(np.abs(elevation - elevations[row]) / spacing[row]))
