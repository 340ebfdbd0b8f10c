"""A quick imitation of `drafting.cloud`: the shapes that clustering would fit to a scan whose objects are known.

Clustering takes a second to find which points belong together and which way an object is turned. Here both are known,
so only the rules are left: extents of the points, unseen sides completed, boxes halved until they fit. The errors of
the search are sampled at random, as large as `benches/compare_coarse_layouts.py` measured them on streets.

Points are [3, N] in here: a row each for x, y and z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.drafting.cloud.rules import (
    ELLIPSE_SCALE,
    HANGING_CLASSES,
    HANGING_HEIGHT,
    LONGER_THAN_WIDE,
    MIN_CROWN,
    MIN_EXTENT,
    MIN_POINTS,
    OTHER_REACH,
    POST_CLASSES,
    REACH_PER_RANGE,
    SEEN_WHOLE,
)
from lidardraft.scene.layout import SHAPES
from lidardraft.semantics import BY_NAME, CLASSES, NUM_CLASSES
from lidardraft.streets.coarse.visible import VisibleObjects

_APART = 1e4  # m; further than any sensor sees


class PointGroups:
    """Points [3, N] sorted by group; `starts`, `counts`, `keys` and `yaws` [G] of the groups."""

    def __init__(self, points: np.ndarray, starts: np.ndarray, keys: np.ndarray, yaws: np.ndarray) -> None:
        self.points, self.starts, self.keys, self.yaws = points, starts, keys, yaws
        self.counts = np.concatenate([starts[1:], [points.shape[1]]]) - starts if len(starts) else starts

    @property
    def labels(self) -> np.ndarray:
        """The class [G] of each group."""
        return self.keys % NUM_CLASSES

    def each(self, values: np.ndarray) -> np.ndarray:
        """For each point the value [..., G] of its group."""
        return np.repeat(values, self.counts, axis=-1)

    def select(self, chosen: np.ndarray) -> PointGroups:
        """The chosen groups [G] alone."""
        counts = self.counts[chosen]
        points = self.points[:, self.each(chosen)]
        return PointGroups(points, np.cumsum(counts) - counts, self.keys[chosen], self.yaws[chosen])

    def local(self) -> np.ndarray:
        """The points turned into the frames of their groups."""
        return turned(self.points, self.each(np.cos(self.yaws)), self.each(np.sin(self.yaws)))

    def extents(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Middles and sizes [3, G] of points [3, N]."""
        if not len(self.starts):
            return np.zeros((3, 0)), np.zeros((3, 0))
        low = np.minimum.reduceat(points, self.starts, axis=1)
        high = np.maximum.reduceat(points, self.starts, axis=1)
        return (low + high) / 2, high - low

    def means(self, values: np.ndarray) -> np.ndarray:
        """Means [..., G] of values [..., N]."""
        if not len(self.starts):
            return np.zeros((*values.shape[:-1], 0))
        means: np.ndarray = np.add.reduceat(values, self.starts, axis=-1) / self.counts
        return means

    def regrouped(self, numbers: np.ndarray) -> PointGroups:
        """The points in the groups that `numbers` [N] say, each with key and yaw of the group of its first point."""
        if not len(numbers):
            return self
        order, starts = order_of(numbers)
        parent = self.each(np.arange(len(self.keys)))[order[starts]]
        return PointGroups(self.points[:, order], starts, self.keys[parent], self.yaws[parent])

    def headings(self, spread: float) -> np.ndarray:
        """The direction [G, rad] in which each group's points are spread the most, or its yaw if by no more than that.

        `spread` is a standard deviation [m].
        """
        x, y = self.points[:2] - self.each(self.means(self.points[:2]))
        xx, yy, xy = self.means(np.stack([x * x, y * y, x * y]))
        return np.where(xx + yy > spread**2, np.arctan2(2 * xy, xx - yy) / 2, self.yaws)

    def linked(self, reach: np.ndarray, weights: np.ndarray, least: int) -> PointGroups:
        """Each group in pieces along its yaw that have no gap, of points with enough neighbours or next to one: DBSCAN.

        Neighbours are within `reach` [N, m] along it. There must be `least` of them, each counted `weights` [G] times;
        of a group that is higher than they reach, a share of them.
        """
        if not len(self.keys):
            return self
        along = self.local()[0] + self.each(np.arange(len(self.keys)) * _APART)
        order = np.argsort(along)
        along, reach = along[order], reach[order]
        near = np.searchsorted(along, along + reach) - np.searchsorted(along, along - reach)
        height = np.maximum(self.each(self.extents(self.points)[1][2])[order], 1e-6)
        dense = near * np.minimum(2 * reach / height, 1.0) * self.each(weights)[order] >= least
        core = np.concatenate([[-np.inf], along[dense], [np.inf]])
        after = np.searchsorted(core, along)
        kept = np.minimum(along - core[after - 1], core[after] - along) <= reach
        gap = np.diff(along[kept], prepend=-np.inf) > reach[kept]
        numbers = np.zeros(len(order), dtype=np.int64)  # 0 is left out
        numbers[order[kept]] = np.cumsum(gap)
        return self.regrouped(numbers).select(np.unique(numbers) > 0)


def turned(points: np.ndarray, cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    """Points [3, N] as seen along axes (cos, sin) [N]."""
    x, y, z = points
    return np.stack([cos * x + sin * y, cos * y - sin * x, z])


def order_of(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The order [N] that sorts numbers [N], and where each new number starts in it [G]."""
    # sixteen bits are sorted by radix, several times as fast
    order = np.argsort(numbers.astype(np.uint16) if numbers.max() < 2**16 else numbers, kind="stable")
    numbers = numbers[order]
    return order, np.flatnonzero(np.concatenate([[True], numbers[1:] != numbers[:-1]]))


_BOX, _ELLIPSOID, _CYLINDER = (SHAPES.index(name) for name in ("box", "ellipsoid", "cylinder"))


def _any_of(*names: str) -> np.ndarray:
    """bool [K]: which classes these are."""
    return np.isin([row.name for row in CLASSES], names)


_POLES = _any_of(*POST_CLASSES)
_RUNS = _any_of("wall", "fence")
_HANGING = _any_of(*HANGING_CLASSES)
_THINGS = np.array([row.size is not None for row in CLASSES])
_SIZES = np.array([row.size or (0.0, 0.0, 0.0) for row in CLASSES])
_VEGETATION, _SIGN, _LIGHT = (BY_NAME[name].id for name in ("vegetation", "traffic-sign", "traffic-light"))
_CUTS = (4, 1, 0)  # a facade is cut in four, each of these in pieces, and these stay as they are
# All below is fitted to what `drafting.cloud` makes of scans of streets: benches/compare_coarse_layouts.py.
_FRONT_DEPTH = 0.3  # m; points no further behind a side of their box lie on it
_MOST_BEHIND_FRONT = 0.08  # share of the points that may lie behind the front
_LARGEST_CROWN = 1.8  # m; there points are halved in tighter boxes than here
_LARGEST_PIECE = 2.5  # m, of facades
_UNSPLIT_LENGTH = 1.5  # m; parts of facades no longer than this are not split
_MERGING_REACH = (0.35, 0.007)  # m between the boxes of neighbours that are merged; plus this share of the range
_TRIMMED = 0.96  # of the length and the width, without the points furthest out
_LONG, _WELL_SEEN = 6.0, 300  # m and returns of objects whose seen length is their length
_SPREAD = 0.45  # m, standard deviation of points along a line of 1.5 m
_QUARTILES = 1.5  # deviations between the quartiles; 1.35 of a normal, 1.73 of an even spread
_HIDDEN_COLUMNS = 0.5  # columns at least between the outermost points and the sides of a pole
_MERGING_STEPS = 4  # each doubles how many neighbours in a row are merged
_MEAN_BEFORE_AXIS = 0.1  # of the diameter, from the mean of the points to the axis of a pole
# Standard deviation of yaw [rad] of an object well seen, and what one point's share adds.
_YAW_ERROR = np.full(NUM_CLASSES, np.deg2rad(1.8))
for _name, _degrees in (
    *(("truck", 0.5), ("bus", 0.5), ("train", 0.5), ("traffic-sign", 0.5)),
    *(("person", 26.0), ("rider", 20.0), ("motorcycle", 8.0), ("bicycle", 4.0)),
):
    _YAW_ERROR[BY_NAME[_name].id] = np.deg2rad(_degrees)
_YAW_ERROR_OF_ONE = np.full(NUM_CLASSES, np.deg2rad(45.0))
_YAW_ERROR_OF_ONE[_SIGN] = np.deg2rad(25.0)


@dataclass(frozen=True, slots=True, eq=False)
class ClusterShapes:
    """G upright shapes with the class and object of each.

    `shapes` i64 [G] indices of `SHAPES`, `centers` and `sizes` f64 [3, G] [m], `yaws` f64 [G] [rad], `keys` i64 [G]:
    object times K plus class.
    """

    shapes: np.ndarray
    centers: np.ndarray
    sizes: np.ndarray
    yaws: np.ndarray
    keys: np.ndarray

    def select(self, chosen: np.ndarray) -> ClusterShapes:
        """The chosen shapes [G] alone."""
        return ClusterShapes(*(getattr(self, name)[..., chosen] for name in self.__dataclass_fields__))


def cluster_shapes(
    visible: VisibleObjects,
    yaws: np.ndarray,
    grounds: np.ndarray,
    diameters: np.ndarray,
    rng: np.random.Generator,
    *,
    numbered: bool,
) -> ClusterShapes:
    """The shapes of what was seen of each object.

    `yaws` [T], in the frame of the ego vehicle, `grounds` [T], the height under each, and `diameters` [T], of its pole,
    are those of the objects. `numbered` says whether the points come with instance numbers: if not,
    neighbours are merged, and of few points is made nothing.
    """
    points, keys = visible.points()
    sensor = visible.scan.sensor
    order, starts = order_of(keys) if len(keys) else (keys, keys)
    parts = keys[order[starts]].astype(np.int64)
    groups = PointGroups(points.T[:, order], starts, parts, yaws[parts // NUM_CLASSES])
    labels = groups.labels
    enough = visible.returns.ravel()[groups.keys] >= MIN_POINTS
    solid, post, crown = _THINGS[labels], _POLES[labels], labels == _VEGETATION
    sign = labels == _SIGN
    if numbered:
        objects = groups.select(solid | (sign & enough))
    else:
        objects = _merged(_linked(groups.select((solid | sign) & enough), visible.returns))
    front = ~(solid | post | crown | sign) & enough
    run = _RUNS[labels]  # of pieces that follow the ground
    found = [
        _boxes(objects, visible.returns, rng),
        _poles(groups.select(post & enough), diameters, sensor.azimuth_span / sensor.columns, rng),
        _crowns(groups.select(crown & enough)),
        *_facades(groups.select(front & ~run)),
        *_facades(_merged(_linked(groups.select(front & run), visible.returns)), bent=True),
    ]
    whole = ClusterShapes(
        *(
            np.concatenate([getattr(part, name) for part in found], axis=-1)
            for name in ClusterShapes.__dataclass_fields__
        )
    )
    return _grounded(whole, grounds)


def _back(points: np.ndarray, yaws: np.ndarray) -> np.ndarray:
    """Points [3, G] of frames turned by `yaws` [G], in the frame around them."""
    return turned(points, np.cos(yaws), -np.sin(yaws))


def _linked(groups: PointGroups, returns: np.ndarray) -> PointGroups:
    """Objects in the pieces that DBSCAN finds; `returns` i64 [T, K] says how many returns the points stand for."""
    weights = returns.ravel()[groups.keys] / groups.counts
    reach = OTHER_REACH + REACH_PER_RANGE * np.hypot(*groups.points[:2])
    return groups.linked(reach, weights, MIN_POINTS)


def _merged(groups: PointGroups) -> PointGroups:
    """Neighbours of one class as one, where their points come near each other."""
    middle, size = groups.extents(groups.points)
    gap = np.abs(middle[:2, :, None] - middle[:2, None]) - (size[:2, :, None] + size[:2, None]) / 2
    distance = np.hypot(*np.maximum(gap, 0.0))
    reach = _MERGING_REACH[0] + _MERGING_REACH[1] * np.hypot(middle[0], middle[1])
    near = (distance < reach) & (groups.labels[:, None] == groups.labels)
    number = np.arange(len(reach))
    for _ in range(_MERGING_STEPS):
        # the lowest number within reach, and that of the neighbour of that number: each step goes twice as far
        number = np.where(near, number, len(reach)).min(axis=1, initial=len(reach))
        number = number[number]
    return groups.regrouped(groups.each(number))


def _boxes(groups: PointGroups, returns: np.ndarray, rng: np.random.Generator) -> ClusterShapes:
    """A box around the points of each group, with the sides that were not seen: `clustering.completions`."""
    middle, seen = groups.extents(groups.local())
    seen = np.maximum(seen * [[_TRIMMED], [_TRIMMED], [1.0]], MIN_EXTENT)
    whole = _SIZES[groups.labels].T
    # the longer side seen is the length where it is too long for a width of the class, else the width
    first = (seen[0] > seen[1]) == (np.maximum(seen[0], seen[1]) > LONGER_THAN_WIDE * whole[1])
    # of a long object that was well seen, what would be added would stand on ground that was seen
    seen_whole = (
        (whole[0] > _LONG) & (returns.ravel()[groups.keys] > _WELL_SEEN) & (seen[:2].max(axis=0) > whole[0] / 4)
    )
    first = np.where(seen_whole, seen[0] > seen[1], first)
    whole = np.where(first, whole[:2], whole[1::-1])
    grown = np.where((seen[:2] < SEEN_WHOLE * whole) & ~seen_whole, whole, seen[:2])
    middle[:2] += np.where(middle[:2] < 0, -0.5, 0.5) * (grown - seen[:2])
    # a sign's box, of no usual size, has the heading between 0 and 90 degrees
    aside = np.remainder(groups.yaws, math.pi) >= math.pi / 2
    turned = np.where(groups.labels == _SIGN, aside, ~first)
    sizes = np.stack([*np.where(turned, grown[::-1], grown), seen[2]])
    shapes = np.full(len(turned), _BOX)
    yaws = groups.yaws + _yaw_errors(groups, rng) + turned * math.pi / 2
    boxes = ClusterShapes(shapes, _back(middle, groups.yaws), sizes, yaws, groups.keys)
    return boxes.select(~_within(boxes, groups))


def _within(boxes: ClusterShapes, groups: PointGroups) -> np.ndarray:
    """Which groups [G] have their middle in the box of a larger one of their class, and are parts of that."""
    seen = groups.extents(groups.points)[0]
    off = seen[:2, :, None] - boxes.centers[:2, None]
    cos, sin = np.cos(boxes.yaws), np.sin(boxes.yaws)
    along, across = np.abs(cos * off[0] + sin * off[1]), np.abs(cos * off[1] - sin * off[0])
    inside = (along < boxes.sizes[0] / 2) & (across < boxes.sizes[1] / 2)
    larger = (groups.counts > groups.counts[:, None]) & (groups.labels == groups.labels[:, None])
    within: np.ndarray = (inside & larger).any(axis=1)
    return within


def _yaw_errors(groups: PointGroups, rng: np.random.Generator) -> np.ndarray:
    """How far off [G, rad] the yaw is that the search over headings finds."""
    turn = rng.normal(0.0, 1.0, len(groups.keys)) * (
        _YAW_ERROR[groups.labels] + _YAW_ERROR_OF_ONE[groups.labels] / groups.counts
    )
    return np.remainder(turn + math.pi / 4, math.pi / 2) - math.pi / 4


def _poles(groups: PointGroups, diameters: np.ndarray, column: float, rng: np.random.Generator) -> ClusterShapes:
    """Cylinders whose near side holds the points, thinner than the poles: columns are `column` [rad] apart."""
    mean = groups.means(groups.points[:2])
    distance = np.maximum(np.hypot(*mean), 1e-6)
    groups.yaws = np.arctan2(mean[1], mean[0])
    middle, size = groups.extents(groups.local())
    narrow = diameters[groups.keys // NUM_CLASSES] - column * distance * (_HIDDEN_COLUMNS + rng.random(len(distance)))
    diameter = np.maximum(np.where(groups.labels == _LIGHT, size[1], narrow), MIN_EXTENT)
    centers = np.stack([*(mean * (1.0 + _MEAN_BEFORE_AXIS * diameter / distance)), middle[2]])
    sizes = np.stack([diameter, diameter, np.maximum(size[2], MIN_EXTENT)])
    return ClusterShapes(np.full(len(diameter), _CYLINDER), centers, sizes, np.zeros(len(diameter)), groups.keys)


def _cut(groups: PointGroups, local: np.ndarray, pieces: np.ndarray) -> PointGroups:
    """Each group's points, `local` [3, N] in its frame, cut into `pieces` [3, G] even parts along each axis."""
    middle, size = groups.extents(local)
    scale = pieces / np.maximum(size, 1e-6)
    cell = ((local - groups.each(middle - size / 2)) * groups.each(scale)).astype(np.int64)
    x, y, z = np.minimum(cell, groups.each(pieces) - 1)
    whole = pieces.prod(axis=0)
    first = np.cumsum(whole) - whole
    return groups.regrouped(groups.each(first) + (x * groups.each(pieces[1]) + y) * groups.each(pieces[2]) + z)


def _halvings(size: np.ndarray, largest: float) -> np.ndarray:
    """How many parts [3, G] halves of halves make of extents until none is longer than `largest` [m]."""
    return 2 ** np.ceil(np.log2(np.maximum(size / largest, 1.0))).astype(np.int64)


def _crowns(groups: PointGroups) -> ClusterShapes:
    """Ellipsoids of the pieces of foliage, as large as their points look, around the middle half of them."""
    groups = _cut(groups, groups.points, _halvings(groups.extents(groups.points)[1], _LARGEST_CROWN))
    mean = groups.means(groups.points[:2])
    groups.yaws = np.arctan2(mean[1], mean[0])
    local = groups.local()
    middle, size = groups.extents(local)
    along = groups.means(local[0])
    spread = np.sqrt(np.maximum(groups.means(local[0] ** 2) - along**2, 0.0))
    middle[0], size[0] = along, _QUARTILES * spread
    size[1:] *= ELLIPSE_SCALE
    shapes = np.full(len(along), _ELLIPSOID)
    sizes = np.maximum(size, MIN_CROWN)
    return ClusterShapes(shapes, _back(middle, groups.yaws), sizes, groups.yaws, groups.keys)


def _facades(groups: PointGroups, *, bent: bool = False) -> list[ClusterShapes]:
    """Boxes of parts that lie on the front of theirs, or are small: `clustering.split`, several halvings at a time.

    `bent` ones turn with the road: each part has a heading of its own.
    """
    done: list[ClusterShapes] = []
    for cut in _CUTS:
        if bent:
            groups.yaws = groups.headings(_SPREAD)
        local = groups.local()
        middle, size = groups.extents(local)
        fits = _on_front(groups, local, middle, size) | (cut == 0)
        centers = _back(middle[:, fits], groups.yaws[fits])
        sizes = np.maximum(size[:, fits], MIN_EXTENT)
        done.append(ClusterShapes(np.full(len(centers[0]), _BOX), centers, sizes, groups.yaws[fits], groups.keys[fits]))
        if fits.all():
            break
        groups, local, size = groups.select(~fits), local[:, groups.each(~fits)], size[:, ~fits]
        pieces = _halvings(size, _LARGEST_PIECE)
        if cut > 1:
            longest = np.arange(3)[:, None] == size.argmax(axis=0)
            pieces = np.where(longest, np.minimum(pieces, cut), 1)
        groups = _cut(groups, local, pieces)
    return done


def _on_front(groups: PointGroups, local: np.ndarray, middle: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Whether each group [G] is small, or lies on the front of its box, with the sensor outside."""
    front = np.sign(-middle[:2])
    depth = groups.each(size[:2] / 2 + front * middle[:2]) - groups.each(front) * local[:2]
    deep = groups.means((depth.min(axis=0) > _FRONT_DEPTH).astype(float))
    outside = (np.abs(middle[:2]) > size[:2] / 2).any(axis=0)
    fits: np.ndarray = (size.max(axis=0) <= _UNSPLIT_LENGTH) | (outside & (deep <= _MOST_BEHIND_FRONT))
    return fits


def _grounded(found: ClusterShapes, grounds: np.ndarray) -> ClusterShapes:
    """What stands, let down to the ground where it begins less than 2.5 m over it."""
    ground = grounds[found.keys // NUM_CLASSES]
    bottom = found.centers[2] - found.sizes[2] / 2
    top = bottom + found.sizes[2]
    stands = ~_HANGING[found.keys % NUM_CLASSES]
    low = np.where(stands & (ground < bottom) & (bottom < ground + HANGING_HEIGHT), ground, bottom)
    found.centers[2], found.sizes[2] = (low + top) / 2, top - low
    return found
