"""The rays of a scan, cast into what its points become: they say what agrees with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.scene.labelling import ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import Raycaster

_MOST_RAYS = 50_000  # in a sample


class Rays:
    """Rays from the sensor at `origin` [3] to points [N, 3], and how far off a cast may be to agree with them.

    `weights` [N] are the numbers of rays that the points stand for, 1 each where they were not thinned. `sample` are
    the indices of evenly chosen ones, 50,000 at most.
    """

    def __init__(self, points: np.ndarray, origin: np.ndarray, weights: np.ndarray | None = None) -> None:
        self.points, self.origin = points, origin
        self.weights = np.ones(len(points)) if weights is None else weights
        self.ranges = np.linalg.norm(points - origin, axis=1)
        self.tolerance = np.maximum(ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE * self.ranges)
        self.sample = np.arange(0, len(points), max(1, -(-len(points) // _MOST_RAYS)))

    def cast(self, primitives: Sequence[Primitive], chosen: np.ndarray | None = None) -> RayHits:
        """What the rays `chosen` [M], or all of them, meet in a layout."""
        chosen = np.arange(len(self.points)) if chosen is None else chosen
        caster = Raycaster(Layout(primitives=tuple(primitives)))
        hits = caster.cast(self.origin, self.points[chosen] - self.origin, threads=1)
        further, tolerance = hits.distance - self.ranges[chosen], self.tolerance[chosen]
        too_far = ~hits.valid | (further > tolerance)
        return RayHits(chosen, hits.primitive, hits.distance, hits.valid & (further < -tolerance), too_far)

    def ends(self, hits: RayHits) -> np.ndarray:
        """Where rays that were cast end [M, 3]: at their origin if they meet nothing."""
        share = hits.distance / np.maximum(self.ranges[hits.chosen], 1e-6)
        ends: np.ndarray = self.origin + share[:, None] * (self.points[hits.chosen] - self.origin)
        return ends


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """Of M rays: their indices `chosen`, the indices of the primitives that they meet, -1 for none, the distances to
    these [m], and which of them end too near, and which too far or nowhere.
    """

    chosen: np.ndarray
    primitive: np.ndarray
    distance: np.ndarray
    too_near: np.ndarray
    too_far: np.ndarray

    def per_piece(self, chosen: np.ndarray, count: int) -> np.ndarray:
        """How many rays of `chosen` bool [M] meet each of the first `count` primitives [count]."""
        mine = chosen & (self.primitive >= 0) & (self.primitive < count)
        return np.bincount(self.primitive[mine], minlength=count)
