"""Buildings: houses with pitched roofs, dormers and chimneys, blocks with balconies, sheds and garages."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.facades import PLINTH, RECESS, STOREY, WINDOW_BAY, walls
from lidardraft.objects.mesh import Triangles, box, frustum, frustum_corners, join, quads
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.scene.layout import Primitive

__all__ = ["BALCONY", "EAVES", "MOST_PLINTH", "STOREY", "block", "house", "shed"]

EAVES = 0.35  # m that a roof overhangs
BALCONY = 1.2  # m, its depth
MOST_PLINTH = 0.7  # m that the ground floor may lie over the lowest ground under it, less than `PLINTH`
_MANSARD = 2.6  # m, the height of a storey under a mansard roof
_OPENINGS = (0.36, 0.45, 0.6)  # of a bay; window areas of 1/8 to 1/4 of the floor, as building codes ask for


def house(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A house, its front (-y) to the street; `clearance` is the height of its eaves, the rest is a pitched roof."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    material = str(rng.choice(("plaster", "brick", "wood", "stone"), p=(0.6, 0.28, 0.07, 0.05)))
    _body(builder, (length, width, placed.clearance), material, rng)
    along = length > 1.5 * width or rng.random() < 0.7
    hipped = along and length > 1.15 * width and rng.random() < 0.25
    rise = height - placed.clearance
    over = (length + 2 * EAVES, width + 2 * EAVES, rise)
    eaves = (0.0, 0.0, placed.clearance)
    tile = "metal" if rng.random() < 0.06 else "roof-tile"
    builder.add_mesh(_roof(along, hipped), over, "building", tile, at=eaves)
    if not hipped:
        # the ends of the roof, in the plane of the walls, as high as the roof is there
        share = 1 - 2 * EAVES / over[1 if along else 0]
        builder.add_mesh(
            _gable(along), (length, width, share * rise), "building", material, at=(0.0, 0.0, placed.clearance)
        )
    if along and not hipped and rng.random() < 0.4:
        count = int(np.clip(length // 5, 1, 3))
        dormers, panes = _dormers(count)
        builder.add_mesh(dormers, (length, width, rise), "building", tile, at=eaves)
        builder.add_mesh(panes, (length, width, rise), "building", "window", at=eaves)
    if rng.random() < 0.75:
        x, y = rng.uniform(-0.3, 0.3) * length, rng.uniform(-0.06, 0.06) * width
        builder.add("box", (x, y, height - 0.3), (0.7, 0.55, 1.6), "building", "brick")
    return builder.primitives


def block(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A block of flats or offices, its front (-y) to the street: a flat or a mansard roof, balconies or none."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    material = str(rng.choice(("plaster", "brick", "concrete", "stone"), p=(0.6, 0.2, 0.12, 0.08)))
    mansard = height > 3 * STOREY and rng.random() < 0.35
    top = height - _MANSARD if mansard else height
    # the sides of blocks in a row are fire walls without windows
    _body(builder, (length, width, top), material, rng, blind=bool(rng.random() < 0.5))
    bays = max(1, round(length / WINDOW_BAY))
    if mansard:
        size, at = (length, width, _MANSARD), (0.0, 0.0, top)
        builder.add_mesh(_frustum(), size, "building", "roof-tile", at=at)
        gables, panes = _attic(max(1, bays // 2))
        builder.add_mesh(gables, size, "building", "roof-tile", at=at)
        builder.add_mesh(panes, size, "building", "window", at=at)
    else:
        builder.add_mesh(_parapet(), (length, width, 1.0), "building", "concrete", at=(0.0, 0.0, height))
        if rng.random() < 0.5:  # ventilation
            at = (rng.uniform(-0.3, 0.3) * length, rng.uniform(-0.2, 0.2) * width, height + 0.35)
            builder.add("box", at, (2.4, 1.8, 0.7), "building", "metal")
    floors = max(1, round(top / STOREY))
    if floors > 1 and rng.random() < 0.45:
        slabs, rails = _balconies(bays, floors, bool(rng.random() < 0.5))
        size = (length, BALCONY, top)
        at = (0.0, -width / 2, 0.0)
        builder.add_mesh(slabs, size, "building", "concrete", at=at)
        builder.add_mesh(rails, size, "building", "glass" if rng.random() < 0.2 else "metal", at=at)
    return builder.primitives


def shed(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A garage or a hall: plain walls, gates in the front (-y), a flat roof with an edge."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    material = str(rng.choice(("plaster", "wood", "metal", "concrete"), p=(0.45, 0.2, 0.2, 0.15)))
    builder.add("box", (0.0, 0.0, (height - PLINTH) / 2), (length, width, height + PLINTH), "building", material)
    builder.add("box", (0.0, 0.0, height - 0.08), (length + 0.2, width + 0.2, 0.16), "building", "concrete")
    gates = int(np.clip(length // 3.0, 1, 4))
    for number in range(gates):
        x = ((number + 0.5) / gates - 0.5) * length
        gate = (min(2.5, 0.85 * length / gates), 0.06, min(2.2, 0.85 * height))
        builder.add("box", (x, -width / 2, gate[2] / 2), gate, "building", "metal")
    return builder.primitives


def _body(
    builder: ObjectBuilder, size: Vector, material: str, rng: np.random.Generator, *, blind: bool = False
) -> None:
    """Walls, panes and a door."""
    length, width, height = size
    bays, deep = (max(1, round(extent / WINDOW_BAY)) for extent in (length, width))
    opening = _OPENINGS[int(rng.integers(3))]
    wall, panes = walls(bays, deep, max(1, round(height / STOREY)), opening, blind)
    builder.add_mesh(wall, size, "building", material)
    builder.add_mesh(panes, size, "building", "window")
    x = (bays // 2 + 0.5 - bays / 2) * length / bays
    leaf = (opening * length / bays, 0.06, 2.2 * height / (max(1, round(height / STOREY)) * STOREY))
    builder.add("box", (x, -width / 2 + 0.8 * RECESS, leaf[2] / 2), leaf, "building", "wood")


@lru_cache(maxsize=4)
def _roof(along: bool, hipped: bool) -> MeshTemplate:
    """Slopes and the underside of the eaves, in shares; the ridge runs along x or across."""
    end = 0.22 if hipped else 0.5
    a, b, c, d = (-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)
    rear, front = (-end, 0.0, 1.0), (end, 0.0, 1.0)
    faces = [(a, b, front, rear), (c, d, rear, front), (a, b, c, d)]
    if hipped:
        faces += [(b, c, front, front), (d, a, rear, rear)]
    corners = np.array(faces)
    return MeshTemplate.from_triangles(*quads(corners if along else corners[..., [1, 0, 2]]))


@lru_cache(maxsize=2)
def _gable(along: bool) -> MeshTemplate:
    """The triangles of wall under both ends of a roof."""
    triangles = np.array([[(x, -0.5, 0.0), (x, 0.5, 0.0), (x, 0.0, 1.0)] for x in (-0.5, 0.5)])
    triangles = triangles if along else triangles[..., [1, 0, 2]]
    return MeshTemplate.from_triangles(triangles.reshape(-1, 3), np.arange(6).reshape(2, 3))


@lru_cache(maxsize=4)
def _dormers(count: int) -> tuple[MeshTemplate, MeshTemplate]:
    """Boxes that stand out of the front slope, and their windows."""
    solids: list[Triangles] = []
    panes = []
    for number in range(count):
        x, half = (number + 0.5) / count - 0.5, 0.14 / count
        solids.append(box((x, -0.24, 0.48), (2 * half, 0.24, 0.5)))
        panes.append(
            [(x + sx * half, -0.363, z) for sx, z in ((-0.75, 0.36), (0.75, 0.36), (0.75, 0.66), (-0.75, 0.66))]
        )
    return MeshTemplate.from_triangles(*join(*solids)), MeshTemplate.from_triangles(*quads(np.array(panes)))


@lru_cache(maxsize=1)
def _frustum() -> MeshTemplate:
    return MeshTemplate.from_triangles(*frustum(frustum_corners((-0.5, 0.5, 1.0, 0.0), (-0.46, 0.46, 0.84, 1.0))))


@lru_cache(maxsize=32)
def _attic(count: int) -> tuple[MeshTemplate, MeshTemplate]:
    """Dormers on both long sides of a mansard, and their windows."""
    solids: list[Triangles] = []
    panes = []
    for number in range(count):
        x, half = (number + 0.5) / count - 0.5, 0.17 / count
        for side in (-1, 1):
            solids.append(box((x, side * 0.45, 0.42), (2 * half, 0.08, 0.76)))
            panes.append(
                [(x + sx * half, side * 0.492, z) for sx, z in ((-0.8, 0.2), (0.8, 0.2), (0.8, 0.7), (-0.8, 0.7))]
            )
    return MeshTemplate.from_triangles(*join(*solids)), MeshTemplate.from_triangles(*quads(np.array(panes)))


@lru_cache(maxsize=1)
def _parapet() -> MeshTemplate:
    """A low wall around a flat roof."""
    long = [box((0.0, side * 0.485, 0.15), (1.0, 0.03, 0.3)) for side in (-1, 1)]
    return MeshTemplate.from_triangles(
        *join(*long, *(box((side * 0.49, 0.0, 0.15), (0.02, 0.94, 0.3)) for side in (-1, 1)))
    )


@lru_cache(maxsize=256)
def _balconies(bays: int, floors: int, every: bool) -> tuple[MeshTemplate, MeshTemplate]:
    """Slabs of balconies before a front, in shares of its length, their depth and its height, and their balustrades."""
    slabs, rails = [], []
    columns = range(0 if every else bays % 2, bays, 2)
    rail, foot = 1.0 / STOREY / floors, 0.18 / STOREY / floors  # a slab is 0.18 m thick
    for floor in range(1, floors):
        z = floor / floors
        for column in columns:
            x, half = (column + 0.5) / bays - 0.5, 0.42 / bays
            slabs.append([(x - half, 0.0, z), (x + half, 0.0, z), (x + half, -1.0, z), (x - half, -1.0, z)])
            a, b, c, d = (x - half, 0.0), (x - half, -1.0), (x + half, -1.0), (x + half, 0.0)
            for (u0, v0), (u1, v1) in ((a, b), (b, c), (c, d)):
                rails.append([(u0, v0, z - foot), (u1, v1, z - foot), (u1, v1, z + rail), (u0, v0, z + rail)])
    return MeshTemplate.from_triangles(*quads(np.array(slabs))), MeshTemplate.from_triangles(*quads(np.array(rails)))
