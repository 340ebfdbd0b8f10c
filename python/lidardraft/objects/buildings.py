"""Buildings: houses with pitched roofs, dormers and chimneys, blocks with balconies, sheds and garages."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.facades import PLINTH, RECESS, STOREY, WINDOW_BAY, walls
from lidardraft.objects.mesh import MeshTemplate, Triangles, box, frustum, frustum_corners, join, quads
from lidardraft.objects.object_builder import ObjectBuilder, sample_name
from lidardraft.objects.placed_object import Vector

__all__ = ["BALCONY", "EAVES", "MOST_PLINTH", "STOREY", "block", "house", "shed"]

EAVES = 0.35  # m, the overhang of a roof: an estimate
BALCONY = 1.2  # m, its depth: an estimate
MOST_PLINTH = 0.7  # m, the largest height of the ground floor over the lowest ground under it, less than `PLINTH`
# Share of a bay that is window: building codes require window areas of 1/8 to 1/4 of the floor.
_OPENINGS = (0.36, 0.45, 0.6)
# Materials of walls, and their frequencies: estimates for Germany.
_MATERIALS = {
    "house": {"plaster": 0.6, "brick": 0.28, "wood": 0.07, "stone": 0.05},
    "block": {"plaster": 0.6, "brick": 0.2, "concrete": 0.12, "stone": 0.08},
    "shed": {"plaster": 0.45, "wood": 0.2, "metal": 0.2, "concrete": 0.15},
}

# Dwellings of one or two families: estimates for Germany. Lengths are in metres, `_P` are probabilities, here and
# below; chimneys are anywhere within `_HOUSE_CHIMNEY_OFF` shares of length and width from the middle.
_HOUSE_SLENDER = 1.5  # times as long as wide: the ridge then always runs along it
_HOUSE_RIDGE_ALONG_P = 0.7
_HOUSE_HIP_SLENDER = 1.15  # times as long as wide: a hipped roof is then possible
_HOUSE_HIPPED_P = 0.25
_HOUSE_METAL_ROOF_P = 0.06
_HOUSE_DORMERS_P = 0.4
_HOUSE_PER_DORMER = 5.0
_HOUSE_MOST_DORMERS = 3
_HOUSE_CHIMNEY_P = 0.75
_HOUSE_CHIMNEY_OFF = (0.3, 0.06)
_HOUSE_CHIMNEY = (0.7, 0.55, 1.6)
_HOUSE_CHIMNEY_MIDDLE = 0.3  # under the ridge

# Blocks of flats and offices: estimates for inner cities in Germany.
_BLOCK_MANSARD = 2.6  # height of the storey under a mansard roof
_BLOCK_MANSARD_FROM = 3  # storeys
_BLOCK_MANSARD_P = 0.35
_BLOCK_BLIND_P = 0.5  # sides without windows: fire walls of blocks in a row
_BLOCK_VENTILATION_P = 0.5
_BLOCK_VENTILATION = (2.4, 1.8, 0.7)
_BLOCK_VENTILATION_OFF = (0.3, 0.2)
_BLOCK_BALCONIES_P = 0.45
_BLOCK_EVERY_BAY_P = 0.5  # balconies at every bay, not at every other
_BLOCK_GLASS_RAIL_P = 0.2
_BLOCK_RAIL = 1.0  # height of a balustrade
_BLOCK_SLAB = 0.18
_BLOCK_BALCONY_SHARE = 0.84  # of a bay

# Garages, workshops and halls [m]; estimates.
_SHED_ROOF = 0.16  # thickness
_SHED_ROOF_OVER = 0.2  # longer and wider than the walls
_SHED_PER_GATE = 3.0
_SHED_MOST_GATES = 4
_SHED_GATE = (2.5, 2.2)  # width and height at most
_SHED_GATE_SHARE = 0.85  # of its wall, at most
_SHED_GATE_DEPTH = 0.06

# A door [m]; estimates.
_DOOR_HEIGHT = 2.2
_DOOR_DEPTH = 0.06
_DOOR_RECESS = 0.8  # of the windows' recess


@dataclass(frozen=True, slots=True)
class _Dormers:
    """Boxes on a roof, in shares of its extents, for its front (-y); estimates."""

    width: float  # of the room for each
    middle: tuple[float, float]  # across and up
    size: tuple[float, float]  # depth and height
    pane: tuple[float, float]  # of the width; distance before the roof's middle
    pane_rise: tuple[float, float]


_ROOF_DORMERS = _Dormers(width=0.28, middle=(0.24, 0.48), size=(0.24, 0.5), pane=(0.75, 0.363), pane_rise=(0.36, 0.66))
_MANSARD_DORMERS = _Dormers(width=0.34, middle=(0.45, 0.42), size=(0.08, 0.76), pane=(0.8, 0.492), pane_rise=(0.2, 0.7))
_HIP = 0.22  # half the length of the ridge of a hipped roof
_MANSARD_TOP = (0.92, 0.84)  # shares of length and width
_PARAPET = (0.02, 0.03, 0.3)  # thickness in shares of length and width; height [m]


def house(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A house with its front (-y) to the street; `clearance` is the height of its eaves, the rest is a pitched roof."""
    length, width, height = builder.placed.size
    material = sample_name(_MATERIALS["house"], rng)
    _walls(builder, (length, width, builder.placed.clearance), material, rng)
    along = length > _HOUSE_SLENDER * width or rng.random() < _HOUSE_RIDGE_ALONG_P
    hipped = along and length > _HOUSE_HIP_SLENDER * width and rng.random() < _HOUSE_HIPPED_P
    rise = height - builder.placed.clearance
    over = (length + 2 * EAVES, width + 2 * EAVES, rise)
    eaves = (0.0, 0.0, builder.placed.clearance)
    roofing = "metal" if rng.random() < _HOUSE_METAL_ROOF_P else "roof-tile"
    builder.add_mesh(_roof(along, hipped), over, "building", roofing, at=eaves)
    if not hipped:
        # the ends of the roof, in the plane of the walls, at the height of the roof
        share = 1 - 2 * EAVES / over[1 if along else 0]
        builder.add_mesh(_gable(along), (length, width, share * rise), "building", material, at=eaves)
    if along and not hipped and rng.random() < _HOUSE_DORMERS_P:
        dormers, panes = _dormers(
            _ROOF_DORMERS, int(np.clip(length // _HOUSE_PER_DORMER, 1, _HOUSE_MOST_DORMERS)), (-1,)
        )
        builder.add_mesh(dormers, (length, width, rise), "building", roofing, at=eaves)
        builder.add_mesh(panes, (length, width, rise), "building", "window", at=eaves)
    if rng.random() < _HOUSE_CHIMNEY_P:
        along_off, across_off = _HOUSE_CHIMNEY_OFF
        x, y = rng.uniform(-along_off, along_off) * length, rng.uniform(-across_off, across_off) * width
        builder.add("box", (x, y, height - _HOUSE_CHIMNEY_MIDDLE), _HOUSE_CHIMNEY, "building", "brick")


def block(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A block of flats or offices with its front (-y) to the street: a flat or a mansard roof, with or without
    balconies."""
    length, width, height = builder.placed.size
    material = sample_name(_MATERIALS["block"], rng)
    mansard = height > _BLOCK_MANSARD_FROM * STOREY and rng.random() < _BLOCK_MANSARD_P
    top = height - _BLOCK_MANSARD if mansard else height
    _walls(builder, (length, width, top), material, rng, blind=bool(rng.random() < _BLOCK_BLIND_P))
    bays = max(1, round(length / WINDOW_BAY))
    if mansard:
        size, at = (length, width, _BLOCK_MANSARD), (0.0, 0.0, top)
        builder.add_mesh(_mansard_roof(), size, "building", "roof-tile", at=at)
        dormers, panes = _dormers(_MANSARD_DORMERS, max(1, bays // 2), (-1, 1))
        builder.add_mesh(dormers, size, "building", "roof-tile", at=at)
        builder.add_mesh(panes, size, "building", "window", at=at)
    else:
        builder.add_mesh(_parapet(), (length, width, 1.0), "building", "concrete", at=(0.0, 0.0, height))
        if rng.random() < _BLOCK_VENTILATION_P:
            along_off, across_off = _BLOCK_VENTILATION_OFF
            along_off = min(along_off, max(0.0, 0.5 - _BLOCK_VENTILATION[0] / 2 / length))  # not beyond the roof
            x, y = rng.uniform(-along_off, along_off) * length, rng.uniform(-across_off, across_off) * width
            at = (x, y, height + _BLOCK_VENTILATION[2] / 2)
            builder.add("box", at, _BLOCK_VENTILATION, "building", "metal")
    floors = max(1, round(top / STOREY))
    if floors > 1 and rng.random() < _BLOCK_BALCONIES_P:
        slabs, rails = _balconies(bays, floors, bool(rng.random() < _BLOCK_EVERY_BAY_P))
        size = (length, BALCONY, top)
        at = (0.0, -width / 2, 0.0)
        builder.add_mesh(slabs, size, "building", "concrete", at=at)
        builder.add_mesh(rails, size, "building", "glass" if rng.random() < _BLOCK_GLASS_RAIL_P else "metal", at=at)


def shed(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A garage or a hall: plain walls, gates in the front (-y), a flat roof with an edge."""
    length, width, height = builder.placed.size
    material = sample_name(_MATERIALS["shed"], rng)
    builder.add("box", (0.0, 0.0, (height - PLINTH) / 2), (length, width, height + PLINTH), "building", material)
    roof = (length + _SHED_ROOF_OVER, width + _SHED_ROOF_OVER, _SHED_ROOF)
    builder.add("box", (0.0, 0.0, height - _SHED_ROOF / 2), roof, "building", "concrete")
    gates = int(np.clip(length // _SHED_PER_GATE, 1, _SHED_MOST_GATES))
    wide, tall = min(_SHED_GATE[0], _SHED_GATE_SHARE * length / gates), min(_SHED_GATE[1], _SHED_GATE_SHARE * height)
    for number in range(gates):
        x = ((number + 0.5) / gates - 0.5) * length
        builder.add("box", (x, -width / 2, tall / 2), (wide, _SHED_GATE_DEPTH, tall), "building", "metal")


def _walls(
    builder: ObjectBuilder, size: Vector, material: str, rng: np.random.Generator, *, blind: bool = False
) -> None:
    """Walls, panes and a door."""
    length, width, height = size
    bays, deep = (max(1, round(extent / WINDOW_BAY)) for extent in (length, width))
    storeys = max(1, round(height / STOREY))
    opening = _OPENINGS[int(rng.integers(len(_OPENINGS)))]
    wall, panes = walls(bays, deep, storeys, opening, blind)
    builder.add_mesh(wall, size, "building", material)
    builder.add_mesh(panes, size, "building", "window")
    x = (bays // 2 + 0.5 - bays / 2) * length / bays
    leaf = (opening * length / bays, _DOOR_DEPTH, _DOOR_HEIGHT * height / (storeys * STOREY))
    builder.add("box", (x, -width / 2 + _DOOR_RECESS * RECESS, leaf[2] / 2), leaf, "building", "wood")


@lru_cache(maxsize=4)
def _roof(along: bool, hipped: bool) -> MeshTemplate:
    """Slopes and the underside of the eaves, in shares; the ridge runs along x or across."""
    end = _HIP if hipped else 0.5
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


@lru_cache(maxsize=32)
def _dormers(form: _Dormers, count: int, sides: tuple[int, ...]) -> tuple[MeshTemplate, MeshTemplate]:
    """Dormers side by side on the front (-1) or on both sides, and their windows."""
    (across, up), (deep, tall), (share, out), (low, high) = form.middle, form.size, form.pane, form.pane_rise
    solids: list[Triangles] = []
    panes = []
    for number in range(count):
        x, half = (number + 0.5) / count - 0.5, form.width / 2 / count
        left, right = x - share * half, x + share * half
        for side in sides:
            solids.append(box((x, side * across, up), (2 * half, deep, tall)))
            y = side * out
            panes.append([(left, y, low), (right, y, low), (right, y, high), (left, y, high)])
    return MeshTemplate.from_triangles(*join(*solids)), MeshTemplate.from_triangles(*quads(np.array(panes)))


@lru_cache(maxsize=1)
def _mansard_roof() -> MeshTemplate:
    """A storey that narrows to a flat top."""
    long, wide = _MANSARD_TOP
    corners = frustum_corners((-0.5, 0.5, 1.0, 0.0), (-long / 2, long / 2, wide, 1.0))
    return MeshTemplate.from_triangles(*frustum(corners))


@lru_cache(maxsize=1)
def _parapet() -> MeshTemplate:
    """A low wall around a flat roof, in shares of its length and width and in metres of height."""
    long, wide, tall = _PARAPET
    sides = [box((0.0, side * (0.5 - wide / 2), tall / 2), (1.0, wide, tall)) for side in (-1, 1)]
    ends = [box((side * (0.5 - long / 2), 0.0, tall / 2), (long, 1.0 - 2 * wide, tall)) for side in (-1, 1)]
    return MeshTemplate.from_triangles(*join(*sides, *ends))


@lru_cache(maxsize=256)
def _balconies(bays: int, floors: int, every: bool) -> tuple[MeshTemplate, MeshTemplate]:
    """Slabs of balconies on a front, in shares of its length, their depth and its height, and their balustrades."""
    slabs, rails = [], []
    columns = range(0 if every or bays == 1 else bays % 2, bays, 2)
    rail, foot = _BLOCK_RAIL / STOREY / floors, _BLOCK_SLAB / STOREY / floors
    for floor in range(1, floors):
        z = floor / floors
        for column in columns:
            x, half = (column + 0.5) / bays - 0.5, _BLOCK_BALCONY_SHARE / 2 / bays
            slabs.append([(x - half, 0.0, z), (x + half, 0.0, z), (x + half, -1.0, z), (x - half, -1.0, z)])
            a, b, c, d = (x - half, 0.0), (x - half, -1.0), (x + half, -1.0), (x + half, 0.0)
            for (u0, v0), (u1, v1) in ((a, b), (b, c), (c, d)):
                rails.append([(u0, v0, z - foot), (u1, v1, z - foot), (u1, v1, z + rail), (u0, v0, z + rail)])
    return MeshTemplate.from_triangles(*quads(np.array(slabs))), MeshTemplate.from_triangles(*quads(np.array(rails)))
