"""Buildings: walls with window recesses, doors, pitched and flat roofs, balconies."""

from __future__ import annotations

import numpy as np

from lidardraft.scene.layout import Primitive
from lidardraft.streets.solids import Solid, join, prism, quads, stepped_grid
from lidardraft.streets.thing import Parts, Thing

STOREY = 2.9  # m, floor to floor of a dwelling, usually 2.8 to 3.2
_PLINTH = 0.8  # m that walls reach under the ground
EAVES = 0.35  # m that a roof overhangs
BALCONY = 1.2  # m, its depth
_RECESS = 0.16  # m from the wall's face to the pane


def house(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A house whose front (-y) looks to the street; `stem` is the height of its eaves, the rest is a pitched roof."""
    length, width, height = thing.size
    parts = Parts(thing)
    _walls(parts, (length, width, thing.stem), rng, door=True)
    _gable(parts, rng)
    if rng.random() < 0.6:
        x = rng.uniform(-0.3, 0.3) * length
        parts.add("box", (x, 0.0, height), (0.6, 0.6, 1.2), "building", "brick")
    return parts.primitives


def block(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A block of flats or offices with a flat roof, its front (-y) to the street, with balconies or without."""
    length, width, height = thing.size
    parts = Parts(thing)
    _walls(parts, thing.size, rng, door=True)
    parts.add("box", (0.0, 0.0, height + 0.15), (length, width, 0.3), "building", "paving")
    if rng.random() < 0.4:
        step = length / max(1, round(length / 7.0))
        for x in np.arange(-length / 2 + step / 2, length / 2, step):
            for floor in range(1, max(1, round(height / STOREY))):
                _balcony(parts, float(x), -width / 2, floor * STOREY)
    return parts.primitives


def shed(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A garage or a hall: plain walls, a wide gate in the front (-y), a flat roof."""
    length, width, height = thing.size
    parts = Parts(thing)
    parts.add("box", (0.0, 0.0, (height - _PLINTH) / 2), (length, width, height + _PLINTH), "building")
    parts.add("box", (0.0, -width / 2, 1.1), (min(2.6, 0.8 * length), 0.06, 2.2), "building", "metal")
    return parts.primitives


def _walls(parts: Parts, size: tuple[float, float, float], rng: np.random.Generator, *, door: bool) -> None:
    length, width, height = size
    material = "brick" if rng.random() < 0.35 else "plaster"
    storeys = max(1, round(height / STOREY))
    pitch, window = rng.uniform(2.4, 3.6), rng.uniform(0.9, 1.5)
    walls: list[Solid] = []
    panes: list[Solid] = []
    for span, depth, turn, entrance in ((length, width, 0, door), (width, length, 1, False), (width, length, 3, False)):
        wall, pane = _facade(span, height, storeys, pitch, window, entrance)
        for solids, corners in ((walls, wall), (panes, pane)):
            if len(corners):
                solids.append(quads(_turned(corners, depth / 2, turn)))
    back = np.array(
        [[[-length / 2, -_PLINTH, 0], [length / 2, -_PLINTH, 0], [length / 2, height, 0], [-length / 2, height, 0]]]
    )
    lid = np.array([[(sx * length / 2, sy * width / 2, height) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]])
    parts.add_mesh(*join(*walls, quads(_turned(back, width / 2, 2)), quads(lid)), "building", material)
    if panes:
        parts.add_mesh(*join(*panes), "building", "window")


def _facade(
    span: float, height: float, storeys: int, pitch: float, window: float, entrance: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Quadrilaterals (u, height, out) of wall and of panes: a grid of windows, with a door in the middle of a front."""
    count = max(1, int((span - 0.8) / pitch))
    step = span / count
    middle = (np.arange(count) + 0.5) * step - span / 2
    u = np.concatenate([[-span / 2], np.stack([middle - window / 2, middle + window / 2], axis=1).ravel(), [span / 2]])
    storey = height / storeys
    sill = np.arange(storeys) * storey
    v = np.concatenate([[-_PLINTH, 0.05], np.stack([sill + 0.9, sill + 0.9 + 1.35], axis=1).ravel(), [height]])
    pane = np.zeros((len(u) - 1, len(v) - 1), dtype=bool)
    pane[1::2, 2::2] = True
    level = np.where(pane, -_RECESS, 0.0)
    if entrance:
        door = 1 + 2 * (count // 2)
        pane[door, 1:3] = False
        level[door, 1:3] = -_RECESS
    corners, cell = stepped_grid(u, v, level)
    glass = pane.ravel()[cell]
    return corners[~glass], corners[glass]


def _turned(corners: np.ndarray, out: float, turn: int) -> np.ndarray:
    """Facade coordinates (u, height, out) to the building's frame; turn 0 is the front (-y), then right, back, left."""
    u, z, level = np.moveaxis(corners, -1, 0)
    x, y = u, -(out + level)
    for _ in range(turn):
        x, y = -y, x
    return np.stack([x, y, z], axis=-1)


def _gable(parts: Parts, rng: np.random.Generator) -> None:
    length, width, height = parts.thing.size
    eaves, over = parts.thing.stem, EAVES
    along = rng.random() < 0.7 or length > 1.6 * width
    half = width / 2 if along else length / 2
    profile = np.array([(-half, eaves), (half, eaves), (0.0, height)])
    vertices, faces = prism(profile, (length if along else width) + 2 * over)
    if along:
        vertices = vertices[:, [1, 0, 2]]
    parts.add_mesh(vertices, faces, "building", "roof-tile")


def _balcony(parts: Parts, x: float, y: float, z: float) -> None:
    parts.add("box", (x, y - BALCONY / 2, z), (2.6, BALCONY, 0.18), "building", "paving")
    parts.add("box", (x, y - BALCONY + 0.03, z + 0.55), (2.6, 0.06, 0.95), "building", "metal")
