"""Walls with windows in recesses: made once for each number of windows and storeys, in shares of the building."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, quads

# Estimates for dwellings in Germany.
STOREY = 2.9  # m, floor to floor of a dwelling, usually 2.8 to 3.2
WINDOW_BAY = 3.0  # m from window to window, in a form
PLINTH = 0.8  # m, the depth of walls under the ground
RECESS = 0.16  # m from the wall's face to the frame of a window
# Of a window 0.7 is glass (DIN V 4108-6), the rest is its frame, here around one pane and of the wall's material.
_GLAZED = 0.7**0.5  # of its width and its height
_PANE = 0.02  # m, the distance of a pane before its frame
_SILL, _LINTEL = 0.9, 2.25  # m over the floor
# Projections of a wall, as extents of height and depth [m]: window sills, and a ledge at each floor.
_SILL_STONE, _LEDGE = (0.07, 0.045), (0.18, 0.04)
_SILL_BESIDE = 0.06  # m, the excess of a sill over its window on each side
_PROUD = 0.03  # m, the distance of panes of the back before the wall


@lru_cache(maxsize=512)
def walls(bays: int, deep: int, storeys: int, opening: float, blind: bool) -> tuple[MeshTemplate, MeshTemplate]:
    """Walls and panes of a building with that many windows along its front (-y) and its sides, and storeys.

    In shares of the building. `opening` is the share of windows in a bay. There is a recess for a door in the middle of
    the front. The back has half as many windows, flush with the wall; the sides of a `blind` building have none.
    """
    length, width, height = bays * WINDOW_BAY, deep * WINDOW_BAY, storeys * STOREY
    faces, panes = [], []
    for span, depth, count, turn in (
        (length, width, bays, 0),
        (width, length, deep, 1),
        (length, width, max(1, bays // 2), 2),
        (width, length, deep, 3),
    ):
        if turn == 2 or (blind and turn in (1, 3)):
            bare = np.array([(-span / 2, span / 2, -PLINTH, height)])
            faces.append(_turned(_upright(bare, 0.0), depth / 2, turn))
            if turn == 2:
                panes.append(_turned(_flush(span, count, storeys, opening), depth / 2, turn))
            continue
        door = count // 2 if turn == 0 else -1
        wall, pane = _facade(span, count, storeys, opening, door)
        faces.append(_turned(wall, depth / 2, turn))
        panes.append(_turned(pane, depth / 2, turn))
    lid = np.array([[(sx * length / 2, sy * width / 2, height) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]])
    extents = np.array([length, width, height])
    return (
        MeshTemplate.from_triangles(*quads(np.concatenate([*faces, lid]) / extents)),
        MeshTemplate.from_triangles(*quads(np.concatenate(panes) / extents)),
    )


@lru_cache(maxsize=256)
def front(bays: int, storeys: int, opening: float) -> tuple[MeshTemplate, MeshTemplate]:
    """Wall and panes of a front alone, which faces -y and has no door.

    In shares of its length and height, and in metres of depth: the wall is at y = 0, with panes behind it.
    """
    length, height = bays * WINDOW_BAY, storeys * STOREY
    extents = np.array([length, 1.0, height])
    wall, panes = (_turned(part, 0.0, 0) / extents for part in _facade(length, bays, storeys, opening, -1, sills=True))
    return MeshTemplate.from_triangles(*quads(wall)), MeshTemplate.from_triangles(*quads(panes))


def _facade(
    span: float, count: int, storeys: int, opening: float, door: int, *, sills: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Quadrilaterals [Q, 4, 3] of (u, height, out) [m]: wall with reveals, with or without `sills`, and panes."""
    step = span / count
    half = opening * step / 2
    middle = (np.arange(count) + 0.5) * step - span / 2
    low = np.arange(storeys) * STOREY
    sill, lintel = low + _SILL, low + _LINTEL
    edges = np.concatenate([[-span / 2], np.stack([middle - half, middle + half], axis=1).ravel(), [span / 2]])
    below = np.concatenate([[-PLINTH], lintel])
    above = np.concatenate([sill, [storeys * STOREY]])
    strips = [(-span / 2, span / 2, a, b) for a, b in zip(below, above, strict=True)]
    if door >= 0:
        # the strip under the lowest windows is split at the door
        strips[0] = (-span / 2, span / 2, -PLINTH, 0.0)
        strips += [(-span / 2, middle[door] - half, 0.0, sill[0]), (middle[door] + half, span / 2, 0.0, sill[0])]
    piers = [(edges[k], edges[k + 1], a, b) for a, b in zip(sill, lintel, strict=True) for k in range(0, len(edges), 2)]
    flat = _upright(np.array(strips + piers), 0.0)
    floor, bay = (a.ravel() for a in np.meshgrid(np.arange(storeys), np.arange(count), indexing="ij"))
    left, right = middle[bay] - half, middle[bay] + half
    foot, head = sill[floor].copy(), lintel[floor]
    entrance = (floor == 0) & (bay == door)
    foot[entrance] = 0.0
    recesses = np.stack([left, right, foot, head], axis=1)
    panes = _upright(_glazed(recesses[~entrance]), _PANE - RECESS)
    wide = np.stack([left - _SILL_BESIDE, right + _SILL_BESIDE, foot - _SILL_STONE[0], foot], axis=1)[~entrance]
    courses = np.array([(-span / 2, span / 2, a - _LEDGE[0], a) for a in low[1:]]).reshape(-1, 4)
    reveals = [
        _reveal((left, foot), (left, head)),
        _reveal((right, foot), (right, head)),
        _reveal((left, head), (right, head)),
    ]
    if sills:
        reveals.append(_reveal((left, foot), (right, foot)))
    stones = [_ledge(wide, _SILL_STONE[1]), _ledge(courses, _LEDGE[1])]
    return np.concatenate([flat, *reveals, *stones, _upright(recesses, -RECESS)]), panes


def _flush(span: float, count: int, storeys: int, opening: float) -> np.ndarray:
    """Panes [Q, 4, 3] just before a wall."""
    step = span / count
    half = min(opening * WINDOW_BAY, 0.5 * step) / 2
    floor, bay = (a.ravel() for a in np.meshgrid(np.arange(storeys), np.arange(count), indexing="ij"))
    middle, low = (bay + 0.5) * step - span / 2, floor * STOREY
    return _upright(_glazed(np.stack([middle - half, middle + half, low + _SILL, low + _LINTEL], axis=1)), _PROUD)


def _glazed(openings: np.ndarray) -> np.ndarray:
    """The panes [Q, 4] of windows [Q, 4] of (left, right, bottom, top)."""
    low, high = openings[:, ::2], openings[:, 1::2]
    margin = (1 - _GLAZED) / 2 * (high - low)
    return np.stack([low + margin, high - margin], axis=2).reshape(-1, 4)


def _ledge(cells: np.ndarray, out: float) -> np.ndarray:
    """Rectangles [2 Q, 4, 3] of the fronts and undersides of cells [Q, 4] that project from a wall by `out` [m]."""
    below = _upright(cells[:, [0, 1, 2, 2]], 0.0)
    below[:, 2:, 2] = out
    return np.concatenate([_upright(cells, out), below])


def _upright(cells: np.ndarray, out: float) -> np.ndarray:
    """Rectangles [Q, 4, 3] from cells [Q, 4] of (left, right, bottom, top)."""
    corners: np.ndarray = np.stack(
        [cells[:, [0, 1, 1, 0]], cells[:, [2, 2, 3, 3]], np.full((len(cells), 4), out)], axis=2
    )
    return corners


def _reveal(start: tuple[np.ndarray, np.ndarray], end: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Rectangles along edges from the wall's face back to the panes."""
    zero = np.zeros(len(start[0]))
    ring = [(*start, zero), (*end, zero), (*end, zero - RECESS), (*start, zero - RECESS)]
    return np.stack([np.stack(point, axis=-1) for point in ring], axis=1)


def _turned(corners: np.ndarray, out: float, turn: int) -> np.ndarray:
    """Facade coordinates (u, height, out) in the building's frame; turn 0 is the front (-y), then right, back, left."""
    u, z, level = np.moveaxis(corners, -1, 0)
    x, y = u, -(out + level)
    for _ in range(turn):
        x, y = -y, x
    return np.stack([x, y, z], axis=-1)
