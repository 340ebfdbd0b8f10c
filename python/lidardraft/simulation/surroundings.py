"""What the rules ask of the layout around an object: its roads as frames along and across, where their shapes tell it
(rectangles, and strips along a bend), and whether fronts and backs are known."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lidardraft.scene.layout import Layout, Primitive, primitive_mesh
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox

LANE_SIDE = 1.75  # m, half a lane: what stands further to the left comes towards the ego vehicle
_ALONG = math.cos(math.radians(40.0))  # what is turned by less against the ego vehicle drives along its road
_WITH_LANE = 0.95  # share of vehicles along a road that stand in its direction: an estimate of ours
_SHORTEST, _LONGEST, _NARROWEST, _WIDEST = 10.0, 2e4, 2.5, 45.0  # m of what is taken for a road
_SLENDER = 1.5  # times as long as wide, at least
_ADJOINING = 0.5  # m between roads that are one surface
_FLAT, _EVEN = 1e-3, 0.02  # m that the surface may rise; m that a strip's width may change


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """`strips` are the roads whose frame can be told; `clustered` is whether boxes know no front from back."""

    strips: tuple[RoadStrip, ...]
    clustered: bool

    @classmethod
    def of(cls, layout: Layout) -> Surroundings:
        """Those of the objects of a layout."""
        return cls(tuple(road_strips(layout)), not layout.intent.headed)

    def headed(self, coarse: CoarseObject, box: UprightBox) -> UprightBox:
        """The box with its likelier heading, where it knows no front from back: that of its lane, or any."""
        if not self.clustered:
            return box
        chance = float(coarse.rng.random())
        ahead = math.cos(box.yaw)
        if abs(ahead) < _ALONG:
            return box.turned(2) if chance < 0.5 else box
        with_ego = (box.y <= LANE_SIDE) == (chance < _WITH_LANE)
        return box if (ahead > 0.0) == with_ego else box.turned(2)

    def road_side(self, box: UprightBox) -> tuple[float, float]:
        """The direction (x, y) from an object to the nearest road, or to the ego vehicle where none is known."""
        nearest, least = (-box.x, -box.y), math.inf
        for strip in self.strips:
            x, y = strip.nearest(box.x, box.y)
            away = math.hypot(x - box.x, y - box.y) - strip.half
            if away < least:
                nearest, least = (x - box.x, y - box.y), away
        return nearest


@dataclass(frozen=True, slots=True, eq=False)
class RoadStrip:
    """A road from its middle line: `id` is that of its primitive, `top` its height and `half` half its width [m].

    `middle` f64 [S, 2] are points of that line [m], `normals` f64 [S, 2] point to its left, `along` f64 [S] are the
    distances [m] of the points from the first. It runs in the ego's direction, if it does so at all.
    """

    id: str
    top: float
    half: float
    middle: np.ndarray
    normals: np.ndarray
    along: np.ndarray

    @property
    def length(self) -> float:
        """Of the middle line [m]."""
        return float(self.along[-1])

    def at(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """x, y [..., 2] of places along and across [m] that have one shape."""
        place = [np.interp(along, self.along, self.middle[:, k]) for k in (0, 1)]
        normal = [np.interp(along, self.along, self.normals[:, k]) for k in (0, 1)]
        return np.stack([p + across * n for p, n in zip(place, normal, strict=True)], axis=-1)

    def along_across(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Along and across [N] of points [N, 2], also before its begin and beyond its end."""
        steps = np.diff(self.middle, axis=0)
        lengths = np.diff(self.along)
        ahead = steps / lengths[:, None]
        off = points[:, None] - self.middle[None, :-1]
        share = (off * ahead).sum(axis=-1)
        clipped = np.clip(share, 0.0, lengths)
        # the first and the last piece go on
        clipped[:, 0] = np.minimum(share[:, 0], lengths[0])
        clipped[:, -1] = np.maximum(share[:, -1], clipped[:, -1])
        across = off[..., 1] * ahead[:, 0] - off[..., 0] * ahead[:, 1]
        best = np.argmin((share - clipped) ** 2 + across**2, axis=1)
        row = np.arange(len(points))
        return self.along[best] + clipped[row, best], across[row, best]

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """The point of the middle line nearest to x, y [m]."""
        if len(self.middle) == 2:
            (a, b), (c, d) = self.middle.tolist()
            length = self.length
            share = min(max(((x - a) * (c - a) + (y - b) * (d - b)) / length**2, 0.0), 1.0)
            return a + share * (c - a), b + share * (d - b)
        nearest = np.argmin(((self.middle - (x, y)) ** 2).sum(axis=1))
        return float(self.middle[nearest, 0]), float(self.middle[nearest, 1])


def road_strips(layout: Layout) -> Iterator[RoadStrip]:
    """The roads of a layout whose frame can be told; what lies along a longer road, as a car park does, is none."""
    found = []
    for primitive in layout:
        if primitive.label == "road" and primitive.material is None:
            edges = _mesh_edges(primitive) if primitive.mesh is not None else _edges(primitive)
            if edges is not None:
                strip = _strip(primitive, *edges)
                width, least = 2 * strip.half, max(_SHORTEST, 2 * _SLENDER * strip.half)
                if _NARROWEST <= width <= _WIDEST and least <= strip.length <= _LONGEST:
                    found.append(strip)
    for strip in found:
        if not any(_lies_along(strip, other) for other in found if other.length > strip.length):
            yield strip


def _lies_along(strip: RoadStrip, road: RoadStrip) -> bool:
    along, across = road.along_across(strip.middle[[0, -1]])
    beside = np.abs(np.abs(across) - road.half - strip.half) < _ADJOINING
    return bool(beside.all() and (along >= 0.0).all() and (along <= road.length).all())


def strip_rows(primitive: Primitive, width: int) -> np.ndarray | None:
    """The vertices [S, width, 3] of a mesh that is a strip of `width` points at each of its stations, else None."""
    assert primitive.mesh is not None
    vertices, faces = primitive.mesh.vertices, primitive.mesh.faces
    rows = len(vertices) // width
    if len(vertices) != rows * width or rows < 2 or len(faces) != 2 * (rows - 1) * (width - 1):
        return None
    if (faces[:, :].max(axis=1).astype(np.int64) - faces.min(axis=1) > width + 1).any():
        return None
    return primitive_mesh(primitive).vertices.reshape(rows, width, 3)


def _strip(primitive: Primitive, right: np.ndarray, left: np.ndarray) -> RoadStrip:
    """From its edges [S, 2]."""
    middle, across = (left + right) / 2, left - right
    width = np.linalg.norm(across, axis=1, keepdims=True)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=1))])
    top = primitive.center[2] + primitive.size[2] / 2
    return RoadStrip(primitive.id, top, float(width.mean()) / 2, middle, across / np.maximum(width, 1e-9), along)


def _edges(primitive: Primitive) -> tuple[np.ndarray, np.ndarray] | None:
    """The right and the left edge [2, 2] of a plane or a box."""
    if primitive.shape not in ("plane", "box"):
        return None
    length, width, _ = primitive.size
    yaw = primitive.yaw
    if width > length:
        length, width, yaw = width, length, yaw + math.pi / 2
    if math.cos(yaw) < -1e-9:
        yaw += math.pi
    x, y, _ = primitive.center
    ahead, aside = np.array([math.cos(yaw), math.sin(yaw)]), np.array([-math.sin(yaw), math.cos(yaw)])
    ends = np.array([x, y]) + np.array([[-length / 2], [length / 2]]) * ahead
    return ends - width / 2 * aside, ends + width / 2 * aside


def _mesh_edges(primitive: Primitive) -> tuple[np.ndarray, np.ndarray] | None:
    """The right and the left edge [S, 2] of a flat strip."""
    rows = strip_rows(primitive, 2) if primitive.size[2] <= _FLAT else None
    if rows is None:
        return None
    right, left = rows[:, 0, :2], rows[:, 1, :2]
    width = np.linalg.norm(left - right, axis=1)
    if np.ptp(width) > _EVEN or np.linalg.norm(np.diff(right + left, axis=0), axis=1).min() < 1e-3:
        return None
    ahead = right[-1] + left[-1] - right[0] - left[0]
    aside = left[0] - right[0]
    if ahead[0] < 0.0:
        right, left = right[::-1], left[::-1]
        ahead = -ahead
    step = right[1] - right[0]
    return (right, left) if step[0] * aside[1] - step[1] * aside[0] > 0.0 else (left, right)
