"""Enclosures and dividers: fences, walls and the barriers of roads.

Guard rails are 0.75 m and concrete barriers 0.8 to 1.15 m high (systems tested after EN 1317). Welded mesh of 50 x 200
mm with 5 mm wires covers 12 %, as does chain link of 50 mm with 3 mm wires.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, box, join, loft, quads
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder, sample_name

# Fences of palings and of iron bars [m], and those on walls: estimates.
_FENCE_IRON_P = 0.3
_FENCE_IRON_COVER = 0.17  # share of the length
_FENCE_PALING_COVERS: tuple[float, ...] = (0.65, 0.75, 0.9)  # shares of the length
_FENCE_PALING_APART = 0.15  # from middle to middle
_FENCE_LEAST_PALINGS = 4
_FENCE_PALINGS_AT = (0.3, 0.4)  # shares of the width: before the middle, depth
_FENCE_GAP = 0.06  # under the palings
_FENCE_POST_APART = 2.5

# Wire mesh between posts [m]: a medium that stops one in eight rays, see the module.
_MESH_FENCE_COVER = 0.12
_MESH_FENCE_THICKNESS = 0.04
_MESH_FENCE_GAP = 0.03  # under the mesh
_MESH_FENCE_POST = 0.06
_MESH_FENCE_POST_APART = 2.5

# Garden walls with copings [m]; those with an iron fence on top have pillars. Estimates.
_GARDEN_WALL_MATERIALS: tuple[str, ...] = ("brick", "stone", "concrete", "plaster")
_GARDEN_WALL_RAILED_FROM = 1.0
_GARDEN_WALL_RAILED_P = 0.3
_GARDEN_WALL_RAILED_SHARE = 0.5  # of the height: the wall in that case
_GARDEN_WALL_COPING = 0.08
_GARDEN_WALL_WIDTH_SHARE = 0.8  # of the coping's
_GARDEN_WALL_RAIL = 0.03  # thickness
_GARDEN_WALL_PILLAR_APART = 3.0
_GARDEN_WALL_PILLAR_SHARE = 0.1  # of their distance
_GARDEN_WALL_PILLAR_WIDTH = 0.7  # share of the width

# Noise barriers and walls of yards [m]: estimates.
_WALL_PANEL_SHARE = 0.5  # of the width
_WALL_PLINTH = 0.3
_WALL_PLINTH_SHARE = 0.8  # of the width
_WALL_POST_APART = 4.0

# Barriers of roads [m]: concrete from a height on (EN 1317), else steel; other numbers are estimates.
_BARRIER_CONCRETE_FROM = 0.8
_BARRIER_RAIL = 0.31  # height of a W-beam
_BARRIER_RAIL_DEPTH = 0.1
_BARRIER_RAIL_INSET = 0.05  # its middle, from the side
_BARRIER_DOUBLE_FROM = 0.5  # width, rails on both sides
_BARRIER_POST_APART = 4.0
_BARRIER_MOST_POSTS = 40
_BARRIER_POST_INSET = (0.12, 0.1)  # less than the width, and the least width
_BARRIER_POST_LOWER = 0.05
_BARRIER_REFLECTOR_P = 0.5
_BARRIER_REFLECTOR = (0.03, 0.08, 0.1)
_BARRIER_REFLECTOR_OVER = 0.03  # its middle, over the rail


# What grows over fences, in shares of length, width and height where no unit is said: estimates.
_OVERGROWN_APART, _OVERGROWN_P = 0.8, 0.8  # m between the middles of tufts; share of the places that have one
_OVERGROWN_LONG, _OVERGROWN_WIDE, _OVERGROWN_TALL = (0.8, 2.2), (0.4, 1.0), (0.4, 1.1)  # m, shares
_OVERGROWN_DENSITY = (2.0, 8.0)  # 1/m, as of shrubs and hedges


_WALL_MATERIALS = {"concrete": 0.4, "wood": 0.2, "metal": 0.2, "brick": 0.2}  # an estimate
_POST_SHARE = 0.04  # of the distance of posts, their thickness: an estimate
# One side of a concrete barrier from the foot up, after the New Jersey profile: shares of width and height.
_NEW_JERSEY = ((0.5, 0.0), (0.5, 0.4), (0.28, 0.55), (0.18, 1.0))
# The W of a guard rail: shares of depth and height.
_W_BEAM = ((-0.5, -0.5), (0.5, -0.25), (-0.3, 0.0), (0.5, 0.25), (-0.5, 0.5))


def fence(builder: ObjectBuilder, rng: np.random.Generator, *, dense: bool = False) -> None:
    """Upright palings or bars with gaps between them, on posts with two rails; a `dense` fence has close palings."""
    length, width, height = builder.placed.size
    iron = not dense and rng.random() < _FENCE_IRON_P
    material = "metal" if iron else "wood"
    covers = _FENCE_PALING_COVERS[-1:] if dense else _FENCE_PALING_COVERS
    cover = _FENCE_IRON_COVER if iron else float(rng.choice(covers))
    before, depth = _FENCE_PALINGS_AT
    size, at = (length, depth * width, height - _FENCE_GAP), (0.0, before * width, _FENCE_GAP)
    builder.add_mesh(_palings(_paling_count(length), cover), size, "fence", material, at=at)
    posts = _post_count(length, _FENCE_POST_APART)
    builder.add_mesh(_posts_and_rails(posts), (length, width, height), "fence", material)


def mesh_fence(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A wire mesh between posts: a thin medium."""
    length, width, height = builder.placed.size
    thick, gap = _MESH_FENCE_THICKNESS, _MESH_FENCE_GAP
    extinction = -float(np.log(1.0 - _MESH_FENCE_COVER)) / thick
    size = (length, thick, height - gap)
    builder.add("box", (0.0, 0.0, gap + (height - gap) / 2), size, "fence", "metal", extinction=extinction)
    posts = _posts(_post_count(length, _MESH_FENCE_POST_APART), _POST_SHARE)
    builder.add_mesh(posts, (length, min(width, _MESH_FENCE_POST), height), "fence", "metal")


def overgrown_fence(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A wire mesh that climbers and shrubs hide, in tufts of uneven depth and height."""
    length, width, height = builder.placed.size
    mesh_fence(builder, rng)
    density = rng.uniform(*_OVERGROWN_DENSITY)
    for middle in np.arange(0.5 * _OVERGROWN_APART, length, _OVERGROWN_APART).tolist():
        if rng.random() < _OVERGROWN_P:
            wide, tall = rng.uniform(*_OVERGROWN_WIDE) * width, min(rng.uniform(*_OVERGROWN_TALL), 1.0) * height
            at = (middle - length / 2, rng.uniform(-0.5, 0.5) * (width - wide), rng.uniform(0.35, 0.5) * tall)
            long = min(rng.uniform(*_OVERGROWN_LONG), 2 * min(middle, length - middle))
            builder.add("ellipsoid", at, (long, wide, tall), "vegetation", extinction=density)


def garden_wall(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A wall with a coping; some with pillars and an iron fence on top of a low wall."""
    length, width, height = builder.placed.size
    material = str(rng.choice(_GARDEN_WALL_MATERIALS))
    railed = height > _GARDEN_WALL_RAILED_FROM and rng.random() < _GARDEN_WALL_RAILED_P
    top, coping = _GARDEN_WALL_RAILED_SHARE * height if railed else height, _GARDEN_WALL_COPING
    size = (length, _GARDEN_WALL_WIDTH_SHARE * width, top - coping + EMBEDMENT)
    builder.add("box", (0.0, 0.0, (top - coping - EMBEDMENT) / 2), size, "wall", material)
    builder.add("box", (0.0, 0.0, top - coping / 2), (length, width, coping), "wall", "paving")
    if railed:
        rails = _palings(_paling_count(length), _FENCE_IRON_COVER)
        size = (length, _GARDEN_WALL_RAIL, height - top)
        builder.add_mesh(rails, size, "fence", "metal", at=(0.0, 0.0, top))
        pillars = _posts(_post_count(length, _GARDEN_WALL_PILLAR_APART), _GARDEN_WALL_PILLAR_SHARE)
        builder.add_mesh(pillars, (length, _GARDEN_WALL_PILLAR_WIDTH * width, height), "wall", material)


def wall(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A noise barrier or a yard wall: panels between posts, on a plinth."""
    length, width, height = builder.placed.size
    material = sample_name(_WALL_MATERIALS, rng)
    size = (length, _WALL_PANEL_SHARE * width, height + EMBEDMENT)
    builder.add("box", (0.0, 0.0, (height - EMBEDMENT) / 2), size, "wall", material)
    size = (length, _WALL_PLINTH_SHARE * width, _WALL_PLINTH + EMBEDMENT)
    builder.add("box", (0.0, 0.0, (_WALL_PLINTH - EMBEDMENT) / 2), size, "wall", "concrete")
    posts = _posts(_post_count(length, _WALL_POST_APART), _POST_SHARE)
    builder.add_mesh(posts, (length, width, height), "wall", "concrete" if material != "metal" else "metal")


def barrier(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A motorway barrier: a guard rail on posts, or, from 0.8 m, a concrete wall of the New Jersey profile."""
    length, width, height = builder.placed.size
    if height >= _BARRIER_CONCRETE_FROM:
        size, at = (length, width, height + EMBEDMENT), (0.0, 0.0, -EMBEDMENT)
        builder.add_mesh(_concrete_barrier(), size, "fence", "concrete", at=at)
        return
    size = (length, _BARRIER_RAIL_DEPTH, _BARRIER_RAIL)
    for side in (-1, 1) if width > _BARRIER_DOUBLE_FROM else (1,):
        at = (0.0, side * (width / 2 - _BARRIER_RAIL_INSET), height - _BARRIER_RAIL / 2)
        builder.add_mesh(_guard_rail(), size, "fence", "metal", at=at)
    posts = min(_post_count(length, _BARRIER_POST_APART), _BARRIER_MOST_POSTS)
    inset, least = _BARRIER_POST_INSET
    size = (length, max(width - inset, least), height - _BARRIER_POST_LOWER)
    builder.add_mesh(_posts(posts, _POST_SHARE), size, "fence", "metal")
    if rng.random() < _BARRIER_REFLECTOR_P:
        at = (0.0, 0.0, height + _BARRIER_REFLECTOR_OVER)
        builder.add("box", at, _BARRIER_REFLECTOR, "fence", "retroreflector")


def _paling_count(length: float) -> int:
    """About as many as fit, in multiples of four, so that fences of similar lengths share their mesh."""
    return max(_FENCE_LEAST_PALINGS, round(length / _FENCE_PALING_APART / 4) * 4)


def _post_count(length: float, apart: float) -> int:
    return max(2, round(length / apart) + 1)


@lru_cache(maxsize=256)
def _palings(count: int, cover: float) -> MeshTemplate:
    """Flat upright slats that cover that share of a length, in shares of length and height."""
    x = (np.arange(count) + 0.5) / count - 0.5
    half = cover / count / 2
    across, tall = half * np.array([-1, 1, 1, -1]), np.array([0.0, 0.0, 1.0, 1.0])
    corners = np.zeros((count, 4, 3))
    corners[:, :, 0] = x[:, None] + across
    corners[:, :, 2] = tall
    return MeshTemplate.from_triangles(*quads(corners))


@lru_cache(maxsize=64)
def _posts(count: int, share: float) -> MeshTemplate:
    """Posts along a length, with a width of that share of their distance, from under the ground to the top."""
    thick = share / count
    return MeshTemplate.from_triangles(*join(*(box((x, 0.0, 0.4), (thick, 1.0, 1.2)) for x in _places(count, thick))))


@lru_cache(maxsize=64)
def _posts_and_rails(count: int) -> MeshTemplate:
    """Posts, and two rails between them."""
    thick = _POST_SHARE / count
    posts = [box((x, -0.1, 0.4), (thick, 0.8, 1.2)) for x in _places(count, thick)]
    rails = [box((0.0, -0.05, z), (1.0, 0.5, 0.06)) for z in (0.25, 0.8)]
    return MeshTemplate.from_triangles(*join(*posts, *rails))


def _places(count: int, thick: float) -> list[float]:
    """Middles of posts of that thickness along the unit length, the outer ones flush with its ends."""
    places: list[float] = np.linspace((thick - 1.0) / 2, (1.0 - thick) / 2, count).tolist()
    return places


@lru_cache(maxsize=1)
def _concrete_barrier() -> MeshTemplate:
    left = np.array(_NEW_JERSEY)
    outline = np.concatenate([left, left[::-1] * (-1, 1)])
    return MeshTemplate.from_triangles(*loft(np.stack([np.insert(outline, 0, end, axis=1) for end in (-0.5, 0.5)])))


@lru_cache(maxsize=1)
def _guard_rail() -> MeshTemplate:
    y, z = np.array(_W_BEAM).T
    rear, front = (np.stack([np.full(len(y), x), y, z], axis=1) for x in (-0.5, 0.5))
    return MeshTemplate.from_triangles(*quads(np.stack([rear[:-1], front[:-1], front[1:], rear[1:]], axis=1)))
