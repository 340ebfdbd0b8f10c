"""Points in groups: what a clustering asks of each of its clusters, asked of all of them at once.

Points are [3, N] in here: a row each for x, y and z.
"""

from __future__ import annotations

import numpy as np

from lidardraft.semantics import NUM_CLASSES

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
