"""Points become shapes: clusters, fitted boxes, and the side of an object that the sensor did not see.

Points are [N, 3] in a frame with z up whose z axis passes through the sensor, so that "away from the sensor" is away
from x = y = 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from sklearn.cluster import DBSCAN
from sklearn.neighbors import radius_neighbors_graph, sort_graph_by_row_values

from lidardraft.drafting.cloud_rules import LONGER_THAN_WIDE, MIN_EXTENT, REACH_PER_RANGE, SEEN_WHOLE

_NOISE = 0.05  # m; nearer to an edge than this is as good as on it
_OUTLIERS = 1.0  # % of the points at either end of an extent


@dataclass(frozen=True, kw_only=True, slots=True)
class FittedBox:
    """An upright box: center [3], size [3] = (along yaw, across, up) in metres, yaw in (-pi/2, pi/2]."""

    center: np.ndarray
    size: np.ndarray
    yaw: float

    def to_local(self, points: np.ndarray) -> np.ndarray:
        """Points [N, 3] in the frame of the box, its center at the origin."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return (points - self.center) @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])

    def contains(self, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        """bool [N]: above or below the box's footprint and further than `margin` from its edge; heights are ignored."""
        return (np.abs(self.to_local(points)[:, :2]) < self.size[:2] / 2 - margin).all(axis=1)

    def depth_behind_front(self, points: np.ndarray) -> np.ndarray:
        """Horizontal distance [N] from the nearer of the two sides that face the sensor."""
        local = self.to_local(points)[:, :2]
        sensor = self.to_local(np.zeros((1, 3)))[0, :2]
        return (self.size[:2] / 2 - np.sign(sensor) * local).min(axis=1)


def thin(points: np.ndarray, voxel: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One point a cell of `voxel` metres: indices [M] of those kept, cell [N] of each point, points [M] a cell."""
    cells = np.floor((points - points.min(axis=0)) / voxel).astype(np.int64)
    x, y, _ = cells.max(axis=0) + 1
    keys = cells @ np.array([1, x, x * y])
    _, kept, cell, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    return kept, cell.reshape(-1), count


def cluster(points: np.ndarray, *, reach: float, min_points: int) -> list[np.ndarray]:
    """DBSCAN: the indices of each cluster, largest first; points of no cluster are left out.

    Two points are neighbours within `reach` metres and 1 % of their range, since points are the sparser the further.
    """
    if not len(points):
        return []
    kept, cell, count = thin(points, reach / 4)
    thinned = points[kept]
    reaches = reach + REACH_PER_RANGE * np.linalg.norm(thinned[:, :2], axis=1)
    graph = radius_neighbors_graph(thinned, reaches.max(), mode="distance", include_self=True)
    rows = np.repeat(np.arange(len(thinned)), np.diff(graph.indptr))
    graph.data /= (reaches[rows] + reaches[graph.indices]) / 2
    graph = sort_graph_by_row_values(graph, warn_when_not_sorted=False)
    found = DBSCAN(eps=1.0, min_samples=min_points, metric="precomputed").fit_predict(graph, sample_weight=count)[cell]
    members = [np.flatnonzero(found == number) for number in range(found.max() + 1)]
    return sorted(members, key=len, reverse=True)


def fit_box(points: np.ndarray) -> FittedBox:
    """The box around all but stray points of [N, 3] whose sides lie closest to them, by search over its heading.

    Closeness criterion of Zhang et al., "Efficient L-Shape Fitting for Vehicle Detection Using Laser Scanners",
    IV 2017, in steps of one degree. Extents are at least 0.1 m.
    """
    headings = np.deg2rad(np.arange(90.0))
    along = points[:, :2] @ np.stack([np.cos(headings), np.sin(headings)])
    across = points[:, :2] @ np.stack([-np.sin(headings), np.cos(headings)])
    distance = np.minimum(_distance_to_edge(along), _distance_to_edge(across))
    best = int(np.argmax((1.0 / np.maximum(distance, _NOISE)).sum(axis=0)))
    local = np.column_stack([along[:, best], across[:, best], points[:, 2]])
    low, high = np.percentile(local, [_OUTLIERS, 100 - _OUTLIERS], axis=0)
    (u, v, z), yaw = (low + high) / 2, float(headings[best])
    center = np.array([u * math.cos(yaw) - v * math.sin(yaw), u * math.sin(yaw) + v * math.cos(yaw), z])
    return FittedBox(center=center, size=np.maximum(high - low, MIN_EXTENT), yaw=yaw)


def _distance_to_edge(positions: np.ndarray) -> np.ndarray:
    """Distances [N, A] to that end of each column of positions [N, A] to which the points are closer."""
    to_high, to_low = positions.max(axis=0) - positions, positions - positions.min(axis=0)
    return np.where((to_high**2).sum(axis=0) < (to_low**2).sum(axis=0), to_high, to_low)


def completions(box: FittedBox, size: tuple[float, float, float]) -> list[FittedBox]:
    """The boxes that an object may have of which `box` was seen: likeliest first, `box` itself last.

    `size` is the usual (length, width, height) [m] of its class.

    The longer side seen is the length if it is too long for a width of the class, or else the width; the second choice
    is the other way round. Sides grow away from the sensor; one of at least 0.7 of the class's was seen whole and does
    not grow.
    """
    turned = replace(box, size=box.size[[1, 0, 2]], yaw=box.yaw + math.copysign(math.pi / 2, -box.yaw))
    longer, other = (box, turned) if box.size[0] > box.size[1] else (turned, box)
    likely, unlikely = (longer, other) if longer.size[0] > LONGER_THAN_WIDE * size[1] else (other, longer)
    return [_complete(likely, size), _complete(unlikely, size), longer]


def _complete(box: FittedBox, size: tuple[float, float, float]) -> FittedBox:
    seen, whole = box.size[:2], np.array(size[:2])
    grown = np.where(seen < SEEN_WHOLE * whole, whole, seen)
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    axes = np.array([[cos, sin], [-sin, cos]])
    away = np.where(axes @ box.center[:2] < 0, -1.0, 1.0)
    shift = (away * (grown - seen) / 2) @ axes
    return replace(box, center=box.center + np.array([*shift, 0.0]), size=np.array([*grown, box.size[2]]))


def split(points: np.ndarray, fits: Callable[[np.ndarray, FittedBox], bool]) -> list[tuple[np.ndarray, FittedBox]]:
    """Halve the points across the longest extent of their box until each part `fits`: parts with their boxes."""
    parts, done = [points], []
    while parts:
        part = parts.pop()
        box = fit_box(part)
        local = box.to_local(part)
        axis = int(np.argmax(box.size))
        behind = local[:, axis] < 0
        if fits(part, box) or behind.all() or not behind.any():
            done.append((part, box))
        else:
            parts += [part[behind], part[~behind]]
    return done
