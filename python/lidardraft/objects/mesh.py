"""Vertices and triangles of solids, and templates: meshes made once and stretched to all objects of their form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.objects.placed_object import Vector
from lidardraft.scene.mesh import TriangleMesh

Triangles = tuple[np.ndarray, np.ndarray]  # vertices [V, 3] and faces [F, 3]


def quads(corners: np.ndarray) -> Triangles:
    """Quadrilaterals [Q, 4, 3] as vertices [4 Q, 3] and triangles [2 Q, 3]."""
    first = 4 * np.arange(len(corners))[:, None, None]
    return corners.reshape(-1, 3), (first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)


def join(*solids: Triangles) -> Triangles:
    """Several solids as one."""
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in solids])
    faces = [faces + offset for (_, faces), offset in zip(solids, offsets, strict=False)]
    return np.concatenate([vertices for vertices, _ in solids]), np.concatenate(faces)


def frustum_corners(bottom: tuple[float, float, float, float], top: tuple[float, float, float, float]) -> np.ndarray:
    """The corners [8, 3] of a body between two rectangles, each (rear x, front x, width, z): bottom, then top ring."""
    corners = []
    for rear, front, width, z in (bottom, top):
        half = width / 2
        corners += [(front, -half, z), (front, half, z), (rear, half, z), (rear, -half, z)]
    return np.array(corners)


def frustum(corners: np.ndarray) -> Triangles:
    """The six faces of a `frustum_corners`, closed, facing outwards."""
    rings = np.array([(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)])
    return corners, rings[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def box(center: tuple[float, float, float], size: tuple[float, float, float]) -> Triangles:
    """The six faces of an upright box."""
    half = np.array(size) / 2
    signs = np.array([(x, y, z) for z in (-1, 1) for x, y in ((1, -1), (1, 1), (-1, 1), (-1, -1))])
    return frustum(np.array(center) + signs * half)


def tube(start: tuple[float, ...], end: tuple[float, ...], diameters: tuple[float, float], sides: int = 6) -> Triangles:
    """A round bar between two points, with `diameters` at its ends, and caps."""
    a, b = np.array(start), np.array(end)
    axis = (b - a) / np.linalg.norm(b - a)
    across = np.cross(axis, (0.0, 1.0, 0.0) if abs(axis[1]) < 0.9 else (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * np.cross(axis, across)
    return loft(np.stack([a + diameters[0] / 2 * ring, b + diameters[1] / 2 * ring]))


def loft(rings: np.ndarray) -> Triangles:
    """A closed skin over successive rings [n, m, 3] of points, with a fan at each end."""
    n, m, _ = rings.shape
    i, j = np.meshgrid(np.arange(n - 1), np.arange(m), indexing="ij")
    here, after = (i * m + j).ravel(), (i * m + (j + 1) % m).ravel()
    fan = np.stack([np.zeros(m - 2, dtype=np.int64), np.arange(1, m - 1), np.arange(2, m)], axis=1)
    faces = [
        np.stack([here, after, after + m], axis=1),
        np.stack([here, after + m, here + m], axis=1),
        fan[:, ::-1],
        fan + (n - 1) * m,
    ]
    return rings.reshape(-1, 3), np.concatenate(faces)


def lathe(profile: np.ndarray, sides: int, across: float = 1.0) -> Triangles:
    """A side view [n, 2] of (radius, z) rotated about z, `across` times as wide in y as in x."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle), across * np.sin(angle)], axis=1)
    rings = np.concatenate(
        [profile[:, None, :1] * ring, np.broadcast_to(profile[:, None, 1:], (len(profile), sides, 1))], axis=2
    )
    return loft(rings)


def window_frame(
    corners: np.ndarray, side: int, spans: tuple[tuple[float, float], ...], rise: tuple[float, float]
) -> np.ndarray:
    """The rest [Q, 4, 3] of one side of a `frustum_corners` around its windows: 0 front, 1 left, 2 rear, 3 right.

    `spans` are shares of the side's width, in order, `rise` of its height.
    """
    a, b = corners[side], corners[(side + 1) % 4]
    d, c = corners[side + 4], corners[(side + 1) % 4 + 4]
    edges = [0.0, *(edge for span in spans for edge in span), 1.0]
    pillars = [(edges[k], edges[k + 1], *rise) for k in range(0, len(edges), 2)]
    cells = np.array([(0.0, 1.0, 0.0, rise[0]), (0.0, 1.0, rise[1], 1.0), *pillars])
    u, v = cells[:, [0, 1, 1, 0], None], cells[:, [2, 2, 3, 3], None]
    quadrilaterals: np.ndarray = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c)
    return quadrilaterals


def stepped_grid(u: np.ndarray, v: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A grid of cells at different levels, and the risers between neighbours.

    `u` [n + 1] and `v` [m + 1] are the grid's lines, `level` [n, m] the height of the cells. Returns corners (u, v,
    level) [Q, 4, 3] and the flat index [Q] of the cell of each; a riser belongs to the higher of its two cells.
    """
    n, m = level.shape
    cell = np.arange(n * m).reshape(n, m)

    U, V = np.meshgrid(u, v, indexing="ij")
    around = (
        (slice(-1), slice(-1)),
        (slice(1, None), slice(-1)),
        (slice(1, None), slice(1, None)),
        (slice(-1), slice(1, None)),
    )
    tops = np.stack([np.stack([U[i, j], V[i, j], level], axis=-1) for i, j in around], axis=-2)
    pieces, owners = [tops.reshape(-1, 4, 3)], [cell.ravel()]
    for axis in (0, 1):
        low, high = (level[:-1], level[1:]) if axis == 0 else (level[:, :-1], level[:, 1:])
        first, second = (cell[:-1], cell[1:]) if axis == 0 else (cell[:, :-1], cell[:, 1:])
        edge = low != high
        start = (U[1:-1, :-1], V[1:-1, :-1]) if axis == 0 else (U[:-1, 1:-1], V[:-1, 1:-1])
        end = (U[1:-1, 1:], V[1:-1, 1:]) if axis == 0 else (U[1:, 1:-1], V[1:, 1:-1])
        (u0, v0), (u1, v1) = ((p[0][edge], p[1][edge]) for p in (start, end))
        l0, l1 = low[edge], high[edge]
        ring = [(u0, v0, l0), (u1, v1, l0), (u1, v1, l1), (u0, v0, l1)]
        pieces.append(np.stack([np.stack(point, axis=-1) for point in ring], axis=-2))
        owners.append(np.where(l0 > l1, first[edge], second[edge]))
    return np.concatenate(pieces), np.concatenate(owners)


@dataclass(frozen=True, slots=True, eq=False)
class MeshTemplate:
    """A mesh within the unit box [-1/2, 1/2]^3, and the `center` and `size` of that box in shares of an object.

    For an object of extents E, the mesh has the extents `size * E` and its middle at `center * E`. The functions that
    make templates cache them, so that objects share their meshes.
    """

    mesh: TriangleMesh
    center: Vector
    size: Vector

    @classmethod
    def from_triangles(cls, vertices: np.ndarray, faces: np.ndarray) -> MeshTemplate:
        """Triangles [F, 3] over vertices [V, 3] given in shares of an object."""
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        center, size = (low + high) / 2, high - low
        unit = np.clip((vertices - center) / np.where(size > 0, size, 1.0), -0.5, 0.5)
        return cls(TriangleMesh(unit, faces), tuple(center.tolist()), tuple(size.tolist()))
