"""The meshes that Blender's operators make, and those of lists of vertices: what shape of a layout each one is."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Polygon = tuple[int, ...]
Triangles = tuple[np.ndarray, np.ndarray]  # vertices float64 [V, 3] and faces int64 [F, 3]
# From so many corners on, a polyhedron stands for the round body that it comes close to: within 5 % of its radius.
_ROUND_CIRCLE, _ROUND_RINGS, _ROUND_SUBDIVISIONS = 10, 6, 2


@dataclass(frozen=True, slots=True)
class MeshShape:
    """A mesh before it is made: the layout's shape that it is, its full extents [m], and how to make its triangles.

    `shape` is "mesh" where it is none of the others, and "any" where that is found out from the triangles; then `size`
    says nothing.
    """

    shape: str
    size: tuple[float, float, float]
    vertices: int
    triangles: Callable[[], Triangles]


def cube(size: float) -> MeshShape:
    """A cube around the origin."""

    def triangles() -> Triangles:
        half = abs(size) / 2
        corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
        quads: list[Polygon] = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return np.array(corners), fans(quads)

    return MeshShape("box", (abs(size),) * 3, 8, triangles)


def plane(size: float) -> MeshShape:
    """A square in z = 0."""

    def triangles() -> Triangles:
        half = abs(size) / 2
        return np.array([(-half, -half, 0.0), (half, -half, 0.0), (half, half, 0.0), (-half, half, 0.0)]), fans(
            [(0, 1, 2, 3)]
        )

    return MeshShape("plane", (abs(size), abs(size), 0.0), 4, triangles)


def grid(size: float, columns: int, rows: int) -> MeshShape:
    """A square in z = 0, cut into so many columns along x and rows along y."""

    def triangles() -> Triangles:
        half = abs(size) / 2
        x, y = np.meshgrid(np.linspace(-half, half, columns + 1), np.linspace(-half, half, rows + 1))
        first = (np.arange(columns) + (columns + 1) * np.arange(rows)[:, None]).reshape(-1)
        quads = first[:, None] + [0, 1, columns + 2, columns + 1]
        return np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3), np.concatenate(
            [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
        )

    return MeshShape("plane", (abs(size), abs(size), 0.0), (columns + 1) * (rows + 1), triangles)


def disc(radius: float, corners: int) -> MeshShape:
    """A filled circle in z = 0."""
    return MeshShape("mesh", (0, 0, 0), corners, lambda: (_ring(radius, corners, 0.0), fans([tuple(range(corners))])))


def cone(radius: float, top_radius: float, depth: float, corners: int, *, capped: bool = True) -> MeshShape:
    """A cone, a frustum or, of equal radii, a cylinder around the z axis."""

    def triangles() -> Triangles:
        low, high = _ring(radius, corners, -depth / 2), _ring(top_radius, corners, depth / 2)
        after = np.roll(np.arange(corners), -1)
        polygons: list[Polygon] = [(k, int(after[k]), corners + int(after[k]), corners + k) for k in range(corners)]
        if capped:
            polygons += [tuple(range(corners))[::-1], tuple(range(corners, 2 * corners))]
        return np.concatenate([low, high]), fans(polygons)

    is_round = corners >= _ROUND_CIRCLE and radius == top_radius and capped
    across = 2 * abs(radius)
    return MeshShape("cylinder" if is_round else "mesh", (across, across, abs(depth)), 2 * corners, triangles)


def sphere(radius: float, segments: int, rings: int) -> MeshShape:
    """A sphere of rings and segments, its poles on the z axis."""

    def triangles() -> Triangles:
        polar = np.pi * np.arange(1, rings) / rings
        circle = _ring(1.0, segments, 0.0)
        body = [circle * math.sin(angle) + [0.0, 0.0, math.cos(angle)] for angle in polar]
        vertices = radius * np.concatenate([*body, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
        north, south, last = len(vertices) - 2, len(vertices) - 1, (rings - 2) * segments
        polygons: list[Polygon] = []
        for k in range(segments):
            after = (k + 1) % segments
            polygons += [(north, k, after), (south, last + after, last + k)]
            for ring in range(0, last, segments):
                polygons.append((ring + k, ring + segments + k, ring + segments + after, ring + after))
        return vertices, fans(polygons)

    is_round = segments >= _ROUND_CIRCLE and rings >= _ROUND_RINGS
    across = 2 * abs(radius)
    return MeshShape("ellipsoid" if is_round else "mesh", (across,) * 3, segments * (rings - 1) + 2, triangles)


def icosphere(radius: float, subdivisions: int) -> MeshShape:
    """An icosahedron whose triangles are cut in four, `subdivisions` - 1 times, and moved out to the sphere."""

    def triangles() -> Triangles:
        high, wide = 1 / math.sqrt(5), 2 / math.sqrt(5)
        angles = [math.radians(36 + 72 * k) for k in range(5)]
        low = [
            (-wide * math.cos(math.radians(72 * k)), -wide * math.sin(math.radians(72 * k)), -high) for k in range(5)
        ]
        upper = [(-wide * math.cos(a), -wide * math.sin(a), high) for a in angles]
        vertices = np.array([(0.0, 0.0, -1.0), *low, *upper, (0.0, 0.0, 1.0)])
        faces = []
        for k in range(5):
            a, b, c, d = 1 + k, 1 + (k + 1) % 5, 6 + k, 6 + (k + 1) % 5
            faces += [(0, b, a), (a, b, c), (c, b, d), (c, d, 11)]
        mesh = vertices, np.array(faces)
        for _ in range(subdivisions - 1):
            mesh = _subdivided(*mesh)
        return radius * mesh[0], mesh[1]

    across = 2 * abs(radius)
    count = 10 * 4 ** (subdivisions - 1) + 2
    return MeshShape("ellipsoid" if subdivisions >= _ROUND_SUBDIVISIONS else "mesh", (across,) * 3, count, triangles)


def torus(major: float, minor: float, major_segments: int, minor_segments: int) -> MeshShape:
    """A ring around the z axis."""

    def triangles() -> Triangles:
        around = 2 * np.pi * np.arange(major_segments) / major_segments
        across = 2 * np.pi * np.arange(minor_segments) / minor_segments
        out = major + minor * np.cos(across)
        x, y = np.outer(np.cos(around), out), np.outer(np.sin(around), out)
        z = np.broadcast_to(minor * np.sin(across), x.shape)
        polygons = []
        for i in range(major_segments):
            for j in range(minor_segments):
                k, m = (i + 1) % major_segments, (j + 1) % minor_segments
                polygons.append(tuple(a * minor_segments + b for a, b in ((i, j), (k, j), (k, m), (i, m))))
        return np.stack([x, y, z], axis=-1).reshape(-1, 3), fans(polygons)

    return MeshShape("mesh", (0, 0, 0), major_segments * minor_segments, triangles)


def polyhedron(vertices: np.ndarray, faces: np.ndarray) -> MeshShape:
    """Vertices [V, 3] and triangles [F, 3] as they are."""
    return MeshShape("any", (0, 0, 0), len(vertices), lambda: (vertices, faces))


def fans(polygons: Sequence[Polygon]) -> np.ndarray:
    """The triangles int64 [F, 3] of polygons, each a fan around its first corner: exact where they are convex."""
    triangles = [(p[0], p[k], p[k + 1]) for p in polygons for k in range(1, len(p) - 1)]
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _ring(radius: float, corners: int, height: float) -> np.ndarray:
    """Corners on a circle, the first of them on +y as in Blender: float64 [corners, 3]."""
    angle = np.pi / 2 + 2 * np.pi * np.arange(corners) / corners
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(corners, height)], axis=1)


def _subdivided(vertices: np.ndarray, faces: np.ndarray) -> Triangles:
    """Each triangle as four, the new vertices on the unit sphere."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    distinct, place = np.unique(edges, axis=0, return_inverse=True)
    middles = vertices[distinct].mean(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    ab, bc, ca = (len(vertices) + place.reshape(-1)).reshape(3, -1)
    a, b, c = faces.T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.concatenate([np.stack(corner, axis=1) for corner in corners])
