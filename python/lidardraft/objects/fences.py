"""What encloses and divides: fences, walls and the barriers of roads.

Guard rails are 0.75 m and concrete barriers 0.8 to 1.15 m high (systems tested after EN 1317). Welded mesh of 50 x 200
mm with 5 mm wires covers 12 %, chain link of 50 mm with 3 mm wires as much.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, box, join, loft, quads
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder, sample_name


@dataclass(frozen=True, slots=True)
class _Fence:
    """Fences of palings and of iron bars [m], and those on walls: estimates."""

    iron_p: float = 0.3
    iron_cover: float = 0.17  # share of the length
    paling_covers: tuple[float, ...] = (0.65, 0.75, 0.9)  # shares of the length
    paling_apart: float = 0.15  # from middle to middle
    least_palings: int = 4
    palings_at: tuple[float, float] = (0.3, 0.4)  # shares of the width: before the middle, depth
    gap: float = 0.06  # under the palings
    post_apart: float = 2.5


@dataclass(frozen=True, slots=True)
class _MeshFence:
    """Wire mesh between posts [m]: a medium that one in eight rays meets, see the module."""

    cover: float = 0.12
    thickness: float = 0.04
    gap: float = 0.03  # under the mesh
    post: float = 0.06
    post_apart: float = 2.5


@dataclass(frozen=True, slots=True)
class _GardenWall:
    """Garden walls with copings [m]; those with an iron fence on top have pillars. Estimates."""

    materials: tuple[str, ...] = ("brick", "stone", "concrete", "plaster")
    railed_from: float = 1.0
    railed_p: float = 0.3
    railed_share: float = 0.5  # of the height that is wall then
    coping: float = 0.08
    width_share: float = 0.8  # of the coping's
    rail: float = 0.03  # thickness
    pillar_apart: float = 3.0
    pillar_share: float = 0.1  # of their distance
    pillar_width: float = 0.7  # share of the width


@dataclass(frozen=True, slots=True)
class _Wall:
    """Noise barriers and walls of yards [m]: estimates."""

    panel_share: float = 0.5  # of the width
    plinth: float = 0.3
    plinth_share: float = 0.8  # of the width
    post_apart: float = 4.0


@dataclass(frozen=True, slots=True)
class _Barrier:
    """Barriers of roads [m]: concrete from a height on (EN 1317), else steel; other numbers are estimates."""

    concrete_from: float = 0.8
    rail: float = 0.31  # height of a W-beam
    rail_depth: float = 0.1
    rail_inset: float = 0.05  # its middle, from the side
    double_from: float = 0.5  # width, rails on both sides
    post_apart: float = 4.0
    most_posts: int = 40
    post_inset: tuple[float, float] = (0.12, 0.1)  # less than the width, and the least width
    post_lower: float = 0.05
    reflector_p: float = 0.5
    reflector: tuple[float, float, float] = (0.03, 0.08, 0.1)
    reflector_over: float = 0.03  # its middle, over the rail


_FENCE, _MESH_FENCE, _GARDEN_WALL, _WALL, _BARRIER = _Fence(), _MeshFence(), _GardenWall(), _Wall(), _Barrier()
_WALL_MATERIALS = {"concrete": 0.4, "wood": 0.2, "metal": 0.2, "brick": 0.2}  # an estimate
_POST_SHARE = 0.04  # of the distance of posts, their thickness: an estimate
# One side of a concrete barrier from the foot up, after the New Jersey profile: shares of width and height.
_NEW_JERSEY = ((0.5, 0.0), (0.5, 0.4), (0.28, 0.55), (0.18, 1.0))
# The W of a guard rail: shares of depth and height.
_W_BEAM = ((-0.5, -0.5), (0.5, -0.25), (-0.3, 0.0), (0.5, 0.25), (-0.5, 0.5))


def fence(builder: ObjectBuilder, rng: np.random.Generator, *, dense: bool = False) -> None:
    """Upright palings or bars with gaps between them, on posts with two rails; a `dense` one has close palings."""
    length, width, height = builder.placed.size
    iron = not dense and rng.random() < _FENCE.iron_p
    material = "metal" if iron else "wood"
    covers = _FENCE.paling_covers[-1:] if dense else _FENCE.paling_covers
    cover = _FENCE.iron_cover if iron else float(rng.choice(covers))
    before, depth = _FENCE.palings_at
    size, at = (length, depth * width, height - _FENCE.gap), (0.0, before * width, _FENCE.gap)
    builder.add_mesh(_palings(_paling_count(length), cover), size, "fence", material, at=at)
    posts = _post_count(length, _FENCE.post_apart)
    builder.add_mesh(_posts_and_rails(posts), (length, width, height), "fence", material)


def mesh_fence(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A wire mesh between posts: a thin medium."""
    length, width, height = builder.placed.size
    thick, gap = _MESH_FENCE.thickness, _MESH_FENCE.gap
    extinction = -float(np.log(1.0 - _MESH_FENCE.cover)) / thick
    size = (length, thick, height - gap)
    builder.add("box", (0.0, 0.0, gap + (height - gap) / 2), size, "fence", "metal", extinction=extinction)
    posts = _posts(_post_count(length, _MESH_FENCE.post_apart), _POST_SHARE)
    builder.add_mesh(posts, (length, min(width, _MESH_FENCE.post), height), "fence", "metal")


def garden_wall(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A wall with a coping; some with pillars and an iron fence on top of a low wall."""
    length, width, height = builder.placed.size
    material = str(rng.choice(_GARDEN_WALL.materials))
    railed = height > _GARDEN_WALL.railed_from and rng.random() < _GARDEN_WALL.railed_p
    top, coping = _GARDEN_WALL.railed_share * height if railed else height, _GARDEN_WALL.coping
    size = (length, _GARDEN_WALL.width_share * width, top - coping + EMBEDMENT)
    builder.add("box", (0.0, 0.0, (top - coping - EMBEDMENT) / 2), size, "wall", material)
    builder.add("box", (0.0, 0.0, top - coping / 2), (length, width, coping), "wall", "paving")
    if railed:
        rails = _palings(_paling_count(length), _FENCE.iron_cover)
        size = (length, _GARDEN_WALL.rail, height - top)
        builder.add_mesh(rails, size, "fence", "metal", at=(0.0, 0.0, top))
        pillars = _posts(_post_count(length, _GARDEN_WALL.pillar_apart), _GARDEN_WALL.pillar_share)
        builder.add_mesh(pillars, (length, _GARDEN_WALL.pillar_width * width, height), "wall", material)


def wall(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A noise barrier or the wall of a yard: panels between posts, on a plinth."""
    length, width, height = builder.placed.size
    material = sample_name(_WALL_MATERIALS, rng)
    size = (length, _WALL.panel_share * width, height + EMBEDMENT)
    builder.add("box", (0.0, 0.0, (height - EMBEDMENT) / 2), size, "wall", material)
    size = (length, _WALL.plinth_share * width, _WALL.plinth + EMBEDMENT)
    builder.add("box", (0.0, 0.0, (_WALL.plinth - EMBEDMENT) / 2), size, "wall", "concrete")
    posts = _posts(_post_count(length, _WALL.post_apart), _POST_SHARE)
    builder.add_mesh(posts, (length, width, height), "wall", "concrete" if material != "metal" else "metal")


def barrier(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A motorway barrier: a guard rail on posts, or, from 0.8 m, a concrete wall of the New Jersey profile."""
    length, width, height = builder.placed.size
    if height >= _BARRIER.concrete_from:
        size, at = (length, width, height + EMBEDMENT), (0.0, 0.0, -EMBEDMENT)
        builder.add_mesh(_concrete_barrier(), size, "fence", "concrete", at=at)
        return
    size = (length, _BARRIER.rail_depth, _BARRIER.rail)
    for side in (-1, 1) if width > _BARRIER.double_from else (1,):
        at = (0.0, side * (width / 2 - _BARRIER.rail_inset), height - _BARRIER.rail / 2)
        builder.add_mesh(_guard_rail(), size, "fence", "metal", at=at)
    posts = min(_post_count(length, _BARRIER.post_apart), _BARRIER.most_posts)
    inset, least = _BARRIER.post_inset
    size = (length, max(width - inset, least), height - _BARRIER.post_lower)
    builder.add_mesh(_posts(posts, _POST_SHARE), size, "fence", "metal")
    if rng.random() < _BARRIER.reflector_p:
        at = (0.0, 0.0, height + _BARRIER.reflector_over)
        builder.add("box", at, _BARRIER.reflector, "fence", "retroreflector")


def _paling_count(length: float) -> int:
    """About as many as fit, in fours, so that fences of similar lengths share their mesh."""
    return max(_FENCE.least_palings, round(length / _FENCE.paling_apart / 4) * 4)


def _post_count(length: float, apart: float) -> int:
    return max(2, round(length / apart) + 1)


@lru_cache(maxsize=256)
def _palings(count: int, cover: float) -> MeshTemplate:
    """Upright slats that cover that share of a length, flat, in shares of length and height."""
    x = (np.arange(count) + 0.5) / count - 0.5
    half = cover / count / 2
    across, tall = half * np.array([-1, 1, 1, -1]), np.array([0.0, 0.0, 1.0, 1.0])
    corners = np.zeros((count, 4, 3))
    corners[:, :, 0] = x[:, None] + across
    corners[:, :, 2] = tall
    return MeshTemplate.from_triangles(*quads(corners))


@lru_cache(maxsize=64)
def _posts(count: int, share: float) -> MeshTemplate:
    """Posts along a length, as wide as that share of their distance, from under the ground to the top."""
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
