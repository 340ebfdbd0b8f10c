"""Vertices and triangles of the solids that things are built from."""

from __future__ import annotations

import numpy as np

Solid = tuple[np.ndarray, np.ndarray]


def quads(corners: np.ndarray) -> Solid:
    """Quadrilaterals [Q, 4, 3] as vertices [4 Q, 3] and triangles [2 Q, 3]."""
    first = 4 * np.arange(len(corners))[:, None, None]
    return corners.reshape(-1, 3), (first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)


def join(*solids: Solid) -> Solid:
    """Several solids as one."""
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in solids])
    faces = [faces + offset for (_, faces), offset in zip(solids, offsets, strict=False)]
    return np.concatenate([vertices for vertices, _ in solids]), np.concatenate(faces)


def prism(profile: np.ndarray, width: float) -> Solid:
    """A side view [n, 2] of (x, z), star-shaped about its mean, extruded to `width` across y."""
    count = len(profile)
    side = np.stack([profile[:, 0], np.zeros(count), profile[:, 1]], axis=1)
    outline = np.concatenate([side, [side.mean(axis=0)]])
    offset = np.array([0.0, width / 2, 0.0])
    left, right = outline + offset, outline - offset
    here, after = np.arange(count), (np.arange(count) + 1) % count
    other, hub = here + count + 1, np.full(count, count)
    faces = [
        np.stack([here, after, hub], axis=1),
        np.stack([other, after + count + 1, hub + count + 1], axis=1),
        np.stack([here, after, after + count + 1], axis=1),
        np.stack([here, after + count + 1, other], axis=1),
    ]
    return np.concatenate([left, right]), np.concatenate(faces)


def hull(bottom: tuple[float, float, float, float], top: tuple[float, float, float, float]) -> np.ndarray:
    """The corners [8, 3] of a body between two rectangles, each (rear x, front x, width, z): bottom, then top ring."""
    corners = []
    for rear, front, width, z in (bottom, top):
        half = width / 2
        corners += [(front, -half, z), (front, half, z), (rear, half, z), (rear, -half, z)]
    return np.array(corners)


def hull_solid(corners: np.ndarray) -> Solid:
    """The six faces of a `hull`."""
    rings = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return quads(corners[np.array(rings)])


def hull_panes(
    corners: np.ndarray, side: int, spans: list[tuple[float, float]], rise: tuple[float, float]
) -> np.ndarray:
    """Rectangles [len(spans), 4, 3] just outside one side of a `hull`: 0 front, 1 left, 2 rear, 3 right.

    `spans` are shares of the side's width, `rise` of its height.
    """
    a, b = corners[side], corners[(side + 1) % 4]
    d, c = corners[side + 4], corners[(side + 1) % 4 + 4]
    outward = np.cross(b - a, d - a)
    outward *= 0.01 / np.linalg.norm(outward)

    def at(u: float, v: float) -> np.ndarray:
        point: np.ndarray = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c) + outward
        return point

    return np.array([[at(u, rise[0]), at(w, rise[0]), at(w, rise[1]), at(u, rise[1])] for u, w in spans])


def stepped_grid(u: np.ndarray, v: np.ndarray, level: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A grid of cells at different levels, and the risers between neighbours.

    `u` [n + 1] and `v` [m + 1] are the grid's lines, `level` [n, m] the height of the cells. Returns corners (u, v,
    level) [Q, 4, 3] and the flat index [Q] of the cell each belongs to; a riser belongs to the higher of its two cells.
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
