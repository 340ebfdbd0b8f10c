"""Upright solids: how far two of them overlap, and which of many one overlaps with."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from lidardraft.scene.layout import Primitive

_CELL = 8.0  # m, the grid by which solids are found
_LAST = 64  # the outermost cell from the origin; it holds everything beyond
_ROUND = tuple((math.cos(k * math.pi / 6), math.sin(k * math.pi / 6)) for k in range(12))


class Solid(NamedTuple):
    """An upright box: x, y of its middle, cosine and sine of its yaw, half its length and width, bottom and top [m].

    One that `is_round` has the twelve corners of the ellipse in it. `id` is that of its primitive.
    """

    x: float
    y: float
    cos: float
    sin: float
    half_length: float
    half_width: float
    bottom: float
    top: float
    is_round: bool = False
    id: str = ""

    @classmethod
    def box(cls, x: float, y: float, yaw: float, size: tuple[float, float], bottom: float, top: float) -> Solid:
        """A box with length and width `size` [m]."""
        return cls(x, y, math.cos(yaw), math.sin(yaw), size[0] / 2, size[1] / 2, bottom, top)

    @classmethod
    def from_primitive(cls, primitive: Primitive) -> Solid:
        """The solid around a primitive; that of a mesh is its bounding box."""
        (x, y, z), (length, width, height), yaw = primitive.center, primitive.size, primitive.yaw
        is_round = primitive.shape in ("ellipsoid", "cylinder")
        low, high = z - height / 2, z + height / 2
        return cls(x, y, math.cos(yaw), math.sin(yaw), length / 2, width / 2, low, high, is_round, primitive.id)

    @property
    def radius(self) -> float:
        """The radius of a circle around it [m]."""
        return math.hypot(self.half_length, self.half_width)

    @property
    def outline(self) -> np.ndarray:
        """The corners f64 [V, 2] seen from above, counter-clockwise."""
        unit = np.array(_ROUND if self.is_round else ((-1, -1), (1, -1), (1, 1), (-1, 1)))
        turn = np.array([[self.cos, self.sin], [-self.sin, self.cos]])
        corners: np.ndarray = unit * (self.half_length, self.half_width) @ turn + (self.x, self.y)
        return corners

    def widened(self, ahead: float, aside: float) -> Solid:
        """The solid made longer by `ahead` [m] at either end and wider by `aside` [m] on either side."""
        return self._replace(half_length=self.half_length + ahead, half_width=self.half_width + aside)


def penetration(one: Solid, two: Solid, margin: float = 0.0) -> float:
    """The distance [m] by which two solids must be moved apart to leave `margin` [m] between them; 0 if they have it.

    Separating axis theorem: two convex outlines are apart exactly when an edge normal of one of them separates them.
    """
    x, y, cos, sin, length, width, bottom, top, is_round, _ = one
    u, v, cos2, sin2, length2, width2, bottom2, top2, is_round2, _ = two
    if bottom2 >= top or top2 <= bottom:
        return 0.0
    if is_round or is_round2:
        shared = _shared_of_outlines(one.outline, two.outline) + margin
        return max(0.0, min(top - bottom2, top2 - bottom, shared))
    dx, dy = u - x, v - y
    # cosine and sine of the angle between the two boxes
    c, s = abs(cos2 * cos + sin2 * sin), abs(sin2 * cos - cos2 * sin)
    if (first := length + c * length2 + s * width2 + margin - abs(cos * dx + sin * dy)) <= 0.0:
        return 0.0
    if (second := width + s * length2 + c * width2 + margin - abs(cos * dy - sin * dx)) <= 0.0:
        return 0.0
    if (third := length2 + c * length + s * width + margin - abs(cos2 * dx + sin2 * dy)) <= 0.0:
        return 0.0
    if (fourth := width2 + s * length + c * width + margin - abs(cos2 * dy - sin2 * dx)) <= 0.0:
        return 0.0
    return min(first, second, third, fourth, top - bottom2, top2 - bottom)


def _shared_of_outlines(one: np.ndarray, two: np.ndarray) -> float:
    """How far one outline [V, 2] must be moved along an edge normal to leave the other [m]; negative if they are
    apart."""
    edges = np.concatenate([np.roll(one, -1, axis=0) - one, np.roll(two, -1, axis=0) - two])
    edges = edges[edges.any(axis=1)]  # flat meshes have edges of length 0
    normals = np.stack([edges[:, 1], -edges[:, 0]]) / np.hypot(*edges.T)
    on_one, on_two = one @ normals, two @ normals
    shared = np.minimum(on_one.max(axis=0) - on_two.min(axis=0), on_two.max(axis=0) - on_one.min(axis=0))
    return float(shared.min())


class Solids:
    """Many solids, in the cells of a grid."""

    def __init__(self, solids: Iterable[Solid] = ()) -> None:
        self._cells: dict[tuple[int, int], list[Solid]] = {}
        for solid in solids:
            self.add(solid)

    def add(self, solid: Solid) -> None:
        """Add a solid."""
        for cell in _cells(solid, 0.0):
            self._cells.setdefault(cell, []).append(solid)

    def touching(self, solid: Solid, margin: float = 0.0) -> Iterator[Solid]:
        """The solids that come within `margin` [m] of a solid, some more than once."""
        for cell in _cells(solid, margin):
            for other in self._cells.get(cell, ()):
                if penetration(solid, other, margin) > 0.0:
                    yield other


def _cells(solid: Solid, margin: float) -> list[tuple[int, int]]:
    x, y, cos, sin, length, width, *_ = solid
    wide = abs(cos) * length + abs(sin) * width + margin
    high = abs(sin) * length + abs(cos) * width + margin
    rows = _between(y - high, y + high)
    return [(column, row) for column in _between(x - wide, x + wide) for row in rows]


def _between(low: float, high: float) -> range:
    first, last = math.floor(low / _CELL), math.floor(high / _CELL)
    return range(min(max(first, -_LAST), _LAST), min(max(last, -_LAST), _LAST) + 1)
