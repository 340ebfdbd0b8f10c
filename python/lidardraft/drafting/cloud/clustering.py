"""Points become shapes: clusters, fitted boxes, and the side of an object that the sensor did not see.

Points are [N, 3] in a frame with z up whose z axis passes through the sensor, so that "away from the sensor" is away
from x = y = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from lidardraft.drafting.cloud.rules import (
    ELLIPSE_SCALE,
    LONGER_THAN_WIDE,
    MIN_CROWN,
    MIN_EXTENT,
    REACH_PER_RANGE,
    SEEN_WHOLE,
)

_NOISE = 0.05  # m; nearer to an edge than this is as good as on it
_SAMPLE = 200  # points at most that say the heading of a box
_SLICE = 0.3  # m of height
_BAND = 1.5  # the highest over the lowest reach of points whose neighbours are searched together
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


def thin(points: np.ndarray, voxel: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One point a cell of `voxel` metres: indices [M] of those kept, cell [N] of each point, points [M] a cell."""
    cells = np.floor((points - points.min(axis=0)) / voxel).astype(np.int64)
    x, y, _ = cells.max(axis=0) + 1
    keys = cells @ np.array([1, x, x * y])
    _, kept, cell, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    return kept, cell.reshape(-1), count


def cluster(points: np.ndarray, *, reach: float, min_points: int) -> list[np.ndarray]:
    """DBSCAN (Ester et al., KDD 1996): the indices of each cluster, largest first; points of none are left out.

    Two points are neighbours within `reach` metres and 1 % of their range, since points are the sparser the further.
    """
    if not len(points):
        return []
    kept, cell, count = thin(points, reach / 4)
    thinned = points[kept]
    reaches = reach + REACH_PER_RANGE * np.linalg.norm(thinned[:, :2], axis=1)
    a, b = _neighbours(thinned, reaches)
    size = len(thinned)
    neighbours = count + np.bincount(a, count[b], size) + np.bincount(b, count[a], size)
    core = neighbours >= min_points
    both = core[a] & core[b]
    links = coo_array((np.ones(np.count_nonzero(both), dtype=bool), (a[both], b[both])), shape=(size, size))
    _, component = connected_components(links, directed=False)
    component = np.where(core, component, size)
    # what is no core itself belongs to the cluster of a core next to it
    for one, other in ((a, b), (b, a)):
        edge = ~core[one] & core[other]
        np.minimum.at(component, one[edge], component[other[edge]])
    found = component[cell]
    order = np.argsort(found, kind="stable")
    numbers, starts = np.unique(found[order], return_index=True)
    members = np.split(order, starts[1:])[: len(numbers) - (numbers[-1] == size)]
    return sorted(members, key=len, reverse=True)


def _neighbours(points: np.ndarray, reaches: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both indices of each pair of points [N, 3] no further apart than the mean of their reaches [N].

    By bands of the lesser reach of the two, since a tree is searched with one radius: one far point would else have it
    wide for all.
    """
    most = 1 + 2 * REACH_PER_RANGE  # no neighbour's reach is so many times the other's, as their ranges are alike
    low, highest, pairs = float(reaches.min()), float(reaches.max()), [np.empty((0, 2), dtype=np.intp)]
    while low <= highest:
        high = low * _BAND
        near = np.flatnonzero((reaches >= low) & (reaches < high * most))
        if len(near):
            found = near[cKDTree(points[near]).query_pairs(reaches[near].max(), output_type="ndarray")]
            pairs.append(found[reaches[found].min(axis=1) < high])
        low = high
    a, b = np.concatenate(pairs).T
    close = np.linalg.norm(points[a] - points[b], axis=1) <= (reaches[a] + reaches[b]) / 2
    return a[close], b[close]


def fit_box(points: np.ndarray, outliers: float = _OUTLIERS) -> FittedBox:
    """The box around points [N, 3] whose sides lie closest to them, by search over its heading.

    `outliers` are the percents of the points at either end of an extent that are strays.

    Closeness criterion of Zhang et al., "Efficient L-Shape Fitting for Vehicle Detection Using Laser Scanners",
    IV 2017, in steps of one degree. Extents are at least 0.1 m.
    """
    headings = np.deg2rad(np.arange(90.0))
    sample = points[:: -(-len(points) // _SAMPLE), :2]
    along = sample @ np.stack([np.cos(headings), np.sin(headings)])
    across = sample @ np.stack([-np.sin(headings), np.cos(headings)])
    distance = np.minimum(_distance_to_edge(along), _distance_to_edge(across))
    yaw = float(headings[np.argmax((1.0 / np.maximum(distance, _NOISE)).sum(axis=0))])
    cos, sin = math.cos(yaw), math.sin(yaw)
    local = np.column_stack([points[:, :2] @ [cos, sin], points[:, :2] @ [-sin, cos], points[:, 2]])
    low, high = percentiles(local, (outliers, 100 - outliers))
    u, v, z = (low + high) / 2
    center = np.array([u * math.cos(yaw) - v * math.sin(yaw), u * math.sin(yaw) + v * math.cos(yaw), z])
    return FittedBox(center=center, size=np.maximum(high - low, MIN_EXTENT), yaw=yaw)


def _distance_to_edge(positions: np.ndarray) -> np.ndarray:
    """Distances [N, A] to that end of each column of positions [N, A] to which the points are closer."""
    to_high, to_low = positions.max(axis=0) - positions, positions - positions.min(axis=0)
    return np.where((to_high**2).sum(axis=0) < (to_low**2).sum(axis=0), to_high, to_low)


def completions(box: FittedBox, size: tuple[float, float, float], heading: float | None = None) -> list[FittedBox]:
    """The seven boxes that an object may have of which `box` was seen, likeliest first.

    `size` is the usual (length, width, height) [m] of its class, `heading` [rad] that of an object next to it.

    The longer side seen is the length if it is too long for a width of the class. Else the side along `heading` is, or
    without one the shorter side; or second the other. A side of at least 0.7 of the class's was seen whole; a shorter
    one grows to the class's, away from the sensor, or that across the line of sight to the other hand, where something
    may hide it. The next are these for a small object, whose sides have 0.7 of the class's; the last has the sides that
    were seen, but none shorter than 0.7 of the class's width.
    """
    turned = replace(box, size=box.size[[1, 0, 2]], yaw=box.yaw + math.copysign(math.pi / 2, -box.yaw))
    longer, other = (box, turned) if box.size[0] > box.size[1] else (turned, box)
    likely, second = other, longer
    if is_length(longer.size[0], size):
        likely = longer
    elif heading is not None and abs(math.cos(longer.yaw - heading)) > abs(math.cos(other.yaw - heading)):
        likely, second = longer, other
    usual = np.array(size[:2])
    small = SEEN_WHOLE * usual
    full = [
        _grown(one, np.where(one.size[:2] < small, usual, 0.0), hand) for one in (likely, second) for hand in (1, -1)
    ]
    return [*full, _grown(likely, small), _grown(second, small), _grown(longer, small[[1, 1]])]


def is_length(side: float, size: tuple[float, float, float]) -> bool:
    """Whether a side seen [m] is too long to be the width of an object of the usual `size`."""
    return side > LONGER_THAN_WIDE * size[1]


def _grown(box: FittedBox, least: np.ndarray, hand: int = 1) -> FittedBox:
    """The box with sides [2] of at least so many metres, grown away from the sensor.

    With -1 for `hand` the side across the line of sight grows to the other hand.
    """
    seen = box.size[:2]
    grown = np.maximum(seen, least)
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    axes = np.array([[cos, sin], [-sin, cos]])
    along = axes @ box.center[:2]
    away = np.where(along < 0, -1.0, 1.0)
    away[np.argmin(np.abs(along))] *= hand
    shift = (away * (grown - seen) / 2) @ axes
    return replace(box, center=box.center + np.array([*shift, 0.0]), size=np.array([*grown, box.size[2]]))


def percentiles(values: np.ndarray, shares: tuple[float, ...]) -> np.ndarray:
    """`numpy.percentile` of columns [N, D], [P, D], in a tenth of its time for small ones."""
    ordered = np.sort(values, axis=0)
    at = (len(values) - 1) * np.array(shares) / 100
    below = at.astype(int)
    above = np.minimum(below + 1, len(values) - 1)
    found: np.ndarray = ordered[below] + (at - below)[:, None] * (ordered[above] - ordered[below])
    return found


def fit_crown(points: np.ndarray) -> FittedBox:
    """The box of the ellipsoid seen as large as the points, around the middle half of them along the line of sight.

    Rays pass through foliage: its points lie scattered behind the side that faces the sensor.
    """
    away, sideways = line_of_sight(points)
    local = np.column_stack([points[:, :2] @ away, points[:, :2] @ sideways, points[:, 2]])
    low, first, third, high = percentiles(local, (2, 25, 75, 98))
    low[0], high[0] = first[0], third[0]
    along, across, up = (low + high) / 2
    size = np.maximum((high - low) * [1.0, ELLIPSE_SCALE, ELLIPSE_SCALE], MIN_CROWN)
    return FittedBox(
        center=np.array([*(along * away + across * sideways), up]), size=size, yaw=math.atan2(away[1], away[0])
    )


def fit_post(points: np.ndarray) -> FittedBox:
    """The upright cylinder whose near side holds the points, as thick as they usually are across the line of sight."""
    away, sideways = line_of_sight(points)
    low, high = points[:, 2].min(), points[:, 2].max()
    slices = np.floor((points[:, 2] - low) / _SLICE).astype(int)
    widths = [np.ptp(points[slices == index, :2] @ sideways) for index in np.unique(slices)]
    width = max(float(np.median(widths)), MIN_EXTENT)
    along, across = np.median(points[:, :2] @ away) + width / 2, np.median(points[:, :2] @ sideways)
    size = np.array([width, width, max(high - low, MIN_EXTENT)])
    return FittedBox(center=np.array([*(along * away + across * sideways), (low + high) / 2]), size=size, yaw=0.0)


def line_of_sight(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal unit vectors from the sensor to the points, and to the left of that."""
    middle = points[:, :2].mean(axis=0)
    x, y = middle / max(float(np.linalg.norm(middle)), 1e-6)
    return np.array([x, y]), np.array([-y, x])
