"""Street furniture: fences and walls, barriers, shelters, and the small things on a sidewalk.

Sizes: waste bins EN 840 (240 l: 0.58 x 0.74 x 1.07 m), traffic cones EN 13422 (0.5 and 0.75 m), guard rails 0.75 m and
concrete barriers 0.8 to 1.15 m high (systems tested after EN 1317), pillar hydrants DIN EN 14384 (about 1 m).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import box, join, lathe, loft, quads
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import Primitive

# welded mesh of 50 x 200 mm with 5 mm wires covers 12 %, chain link of 50 mm with 3 mm wires as much
_MESH_COVER = 0.12
_PANE = 12.0  # 1/m: a pane 3 cm thick lets 70 % of the rays through, an estimate of ours for two ways


def fence(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """Upright slats with gaps between them, or boards across, on posts with two rails."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    metal = rng.random() < 0.3
    material = "metal" if metal else "wood"
    # palings cover 65 to 90 %, iron bars a sixth
    share = 0.17 if metal else float(rng.choice((0.65, 0.75, 0.9)))
    count = max(4, round(length / 0.15 / 4) * 4)
    size = (length, 0.4 * width, height - 0.06)
    builder.add_mesh(_palings(count, share), size, "fence", material, at=(0.0, 0.3 * width, 0.06))
    posts = max(2, round(length / 2.5) + 1)
    builder.add_mesh(_rails(posts), (length, width, height), "fence", material)
    return builder.primitives


def mesh_fence(placed: PlacedObject, _rng: np.random.Generator) -> list[Primitive]:
    """A wire mesh between posts: a thin medium."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    thick = 0.04
    extinction = -float(np.log(1.0 - _MESH_COVER)) / thick
    builder.add(
        "box", (0.0, 0.0, 0.03 + (height - 0.03) / 2), (length, thick, height - 0.03), "fence", "metal",
        extinction=extinction,
    )  # fmt: skip
    posts = max(2, round(length / 2.5) + 1)
    builder.add_mesh(_uprights(posts), (length, min(width, 0.06), height), "fence", "metal")
    return builder.primitives


def garden_wall(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A wall with a coping; some with pillars and an iron fence on top of a low wall."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    material = str(rng.choice(("brick", "stone", "concrete", "plaster")))
    railed = height > 1.0 and rng.random() < 0.3
    top = 0.5 * height if railed else height
    builder.add(
        "box", (0.0, 0.0, (top - 0.08 - EMBEDMENT) / 2), (length, 0.8 * width, top - 0.08 + EMBEDMENT), "wall", material
    )
    builder.add("box", (0.0, 0.0, top - 0.04), (length, width, 0.08), "wall", "paving")
    if railed:
        count = max(4, round(length / 0.15 / 4) * 4)
        at = (0.0, 0.0, top)
        builder.add_mesh(_palings(count, 0.17), (length, 0.03, height - top), "fence", "metal", at=at)
        builder.add_mesh(
            _uprights(max(2, round(length / 3.0) + 1), 0.1), (length, 0.7 * width, height), "wall", material
        )
    return builder.primitives


def wall(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A noise barrier or the wall of a yard: panels between posts, on a plinth."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    material = str(rng.choice(("concrete", "wood", "metal", "brick"), p=(0.4, 0.2, 0.2, 0.2)))
    builder.add(
        "box", (0.0, 0.0, (height - EMBEDMENT) / 2), (length, 0.5 * width, height + EMBEDMENT), "wall", material
    )
    builder.add("box", (0.0, 0.0, (0.3 - EMBEDMENT) / 2), (length, 0.8 * width, 0.3 + EMBEDMENT), "wall", "concrete")
    posts = max(2, round(length / 4.0) + 1)
    builder.add_mesh(_uprights(posts), (length, width, height), "wall", "concrete" if material != "metal" else "metal")
    return builder.primitives


def barrier(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A motorway barrier: a guard rail on posts, or, from 0.8 m, a concrete wall of the New Jersey profile."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    if height >= 0.8:
        builder.add_mesh(
            _profile(), (length, width, height + EMBEDMENT), "fence", "concrete", at=(0.0, 0.0, -EMBEDMENT)
        )
        return builder.primitives
    rail = 0.31  # m, the height of a W-beam
    mesh = _beam()
    for side in (-1, 1) if width > 0.5 else (1,):
        at = (0.0, side * (width / 2 - 0.05), height - rail / 2)
        builder.add_mesh(mesh, (length, 0.1, rail), "fence", "metal", at=at)
    posts = int(np.clip(round(length / 4.0) + 1, 2, 40))
    builder.add_mesh(_uprights(posts), (length, max(width - 0.12, 0.1), height - 0.05), "fence", "metal")
    if rng.random() < 0.5:  # a reflector on top of the rail
        builder.add("box", (0.0, 0.0, height + 0.03), (0.03, 0.08, 0.1), "fence", "retroreflector")
    return builder.primitives


def shelter(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A bus stop, open to its left (+y): a roof on posts, panes around it, a bench, a poster case."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    builder.add("box", (0.0, 0.0, height - 0.08), (length, width, 0.16), "other", "metal")
    builder.add_mesh(_stands(), (length, width, height - 0.1), "other", "metal")
    z, tall = 0.475 * height, 0.72 * height
    for at, pane in (
        ((0.0, -0.44 * width, z), (0.92 * length, 0.03, tall)),
        ((-0.48 * length, -0.07 * width, z), (0.03, 0.68 * width, tall)),
        ((0.48 * length, -0.07 * width, z), (0.03, 0.68 * width, tall)),
    ):
        builder.add("box", at, pane, "other", "glass", extinction=_PANE)
    builder.add("box", (-0.1 * length, -0.28 * width, 0.46), (0.55 * length, 0.35, 0.06), "other", "wood")
    builder.add("box", (-0.1 * length, -0.28 * width, 0.22), (0.1, 0.25, 0.44), "other", "metal")
    if rng.random() < 0.6:
        # a lit poster case, 1.2 x 1.8 m
        at = (0.5 * length - 0.1, 0.0, 1.1)
        builder.add("box", at, (0.2, min(1.3, 0.9 * width), 1.8), "other", "plastic")
        builder.add("box", (at[0], 0.0, 0.1), (0.1, 0.5, 0.25), "other", "metal")
    return builder.primitives


def bin(placed: PlacedObject, _rng: np.random.Generator) -> list[Primitive]:
    """A wheeled waste bin that widens to its lid, or a round litter bin."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    if height < 0.95:
        builder.add("cylinder", (0.0, 0.0, height / 2), (0.9 * length, 0.9 * width, height), "other", "metal")
        return builder.primitives
    body, wheels = _tub()
    builder.add_mesh(body, placed.size, "other", "plastic")
    builder.add_mesh(wheels, placed.size, "other", "rubber")
    return builder.primitives


def bench(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A bench that looks to its left (+y), open below; most have a back."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    builder.add("box", (0.0, 0.0, 0.45), (length, width, 0.06), "other", "wood")
    for x in (-0.4 * length, 0.4 * length):
        builder.add("box", (x, 0.0, 0.21), (0.08, 0.9 * width, 0.42), "other", "metal")
    if rng.random() < 0.8:
        back = (length, 0.06, height - 0.55)
        builder.add("box", (0.0, 0.04 - width / 2, (0.55 + height) / 2), back, "other", "wood")
        builder.add("box", (0.0, 0.04 - width / 2, 0.5), (0.85 * length, 0.04, 0.12), "other", "metal")
    return builder.primitives


def cone(placed: PlacedObject, _rng: np.random.Generator) -> list[Primitive]:
    """A traffic cone on its foot, with a reflecting sleeve."""
    length, width, _ = placed.size
    builder = ObjectBuilder(placed)
    body, sleeve = _cone()
    builder.add_mesh(body, placed.size, "other", "plastic")
    builder.add_mesh(sleeve, placed.size, "other", "retroreflector")
    builder.add("box", (0.0, 0.0, 0.025), (length, width, 0.05), "other", "rubber")
    return builder.primitives


def letterbox(placed: PlacedObject, _rng: np.random.Generator) -> list[Primitive]:
    """A letterbox on a post, its slot forward (+x)."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    builder.add("box", (0.0, 0.0, 0.7 * height), (length, width, 0.6 * height), "other", "light-paint")
    builder.add(
        "box", (0.0, 0.0, (0.4 * height - EMBEDMENT) / 2), (0.12, 0.12, 0.4 * height + EMBEDMENT), "other", "metal"
    )
    return builder.primitives


def hydrant(placed: PlacedObject, _rng: np.random.Generator) -> list[Primitive]:
    """A pillar hydrant: a column with a bonnet and two outlets."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    diameter = 0.62 * min(length, width)
    builder.add(
        "cylinder",
        (0.0, 0.0, (0.9 * height - EMBEDMENT) / 2),
        (diameter, diameter, 0.9 * height + EMBEDMENT),
        "other",
        "metal",
    )
    builder.add(
        "ellipsoid", (0.0, 0.0, 0.88 * height), (1.2 * diameter, 1.2 * diameter, 0.24 * height), "other", "metal"
    )
    builder.add("box", (0.0, 0.0, 0.66 * height), (0.12, width, 0.12), "other", "metal")
    return builder.primitives


def cabinet(placed: PlacedObject, _rng: np.random.Generator) -> list[Primitive]:
    """A distribution cabinet on a plinth, with a lid that sticks out and doors forward (+x)."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    builder.add(
        "box",
        (0.0, 0.0, (height - EMBEDMENT) / 2),
        (0.9 * length, 0.95 * width, height + EMBEDMENT),
        "other",
        "plastic",
    )
    builder.add("box", (0.0, 0.0, height - 0.03), (length, width, 0.06), "other", "plastic")
    builder.add("box", (0.0, 0.0, 0.05 - EMBEDMENT / 2), (length, width, 0.1 + EMBEDMENT), "other", "concrete")
    return builder.primitives


@lru_cache(maxsize=256)
def _palings(count: int, share: float) -> MeshTemplate:
    """Upright slats that cover that share of a length, flat, in shares of length and height."""
    x = (np.arange(count) + 0.5) / count - 0.5
    half = share / count / 2
    across, tall = half * np.array([-1, 1, 1, -1]), np.array([0.0, 0.0, 1.0, 1.0])
    corners = np.zeros((count, 4, 3))
    corners[:, :, 0] = x[:, None] + across
    corners[:, :, 2] = tall
    return MeshTemplate.from_triangles(*quads(corners))


@lru_cache(maxsize=64)
def _uprights(count: int, share: float = 0.04) -> MeshTemplate:
    """Posts along a length, as wide as that share of their distance, from under the ground to the top."""
    thick = share / count
    x = np.linspace((thick - 1.0) / 2, (1.0 - thick) / 2, count).tolist()
    return MeshTemplate.from_triangles(*join(*(box((at, 0.0, 0.4), (thick, 1.0, 1.2)) for at in x)))


@lru_cache(maxsize=64)
def _rails(count: int) -> MeshTemplate:
    """Posts, and two rails between them."""
    thick = 0.04 / count
    x = np.linspace((thick - 1.0) / 2, (1.0 - thick) / 2, count).tolist()
    posts = [box((at, -0.1, 0.4), (thick, 0.8, 1.2)) for at in x]
    return MeshTemplate.from_triangles(*join(*posts, *(box((0.0, -0.05, z), (1.0, 0.5, 0.06)) for z in (0.25, 0.8))))


@lru_cache(maxsize=1)
def _profile() -> MeshTemplate:
    side = np.array([(0.5, 0.0), (0.5, 0.4), (0.28, 0.55), (0.18, 1.0)])
    coarse_shapes = np.concatenate([side, side[::-1] * (-1, 1)])
    return MeshTemplate.from_triangles(
        *loft(np.stack([np.insert(coarse_shapes, 0, end, axis=1) for end in (-0.5, 0.5)]))
    )


@lru_cache(maxsize=1)
def _beam() -> MeshTemplate:
    """The W of a guard rail."""
    y = np.array([-0.5, 0.5, -0.3, 0.5, -0.5])
    z = np.array([-0.5, -0.25, 0.0, 0.25, 0.5])
    ends = [np.stack([np.full(5, x), y, z], axis=1) for x in (-0.5, 0.5)]
    return MeshTemplate.from_triangles(*quads(np.stack([ends[0][:-1], ends[1][:-1], ends[1][1:], ends[0][1:]], axis=1)))


@lru_cache(maxsize=1)
def _stands() -> MeshTemplate:
    """The posts and rails of a shelter."""
    posts = [box((x, y, 0.45), (0.02, 0.06, 1.1)) for x in (-0.48, 0.0, 0.48) for y in (-0.44,)]
    posts += [box((x, 0.3, 0.45), (0.02, 0.06, 1.1)) for x in (-0.48, 0.48)]
    posts += [box((0.0, -0.44, z), (0.96, 0.03, 0.02)) for z in (0.1, 0.85)]
    return MeshTemplate.from_triangles(*join(*posts))


@lru_cache(maxsize=1)
def _tub() -> tuple[MeshTemplate, MeshTemplate]:
    def ring(long: float, wide: float, z: float, back: float = 0.0) -> np.ndarray:
        return np.array([(x * long + back, y * wide, z) for x, y in ((1, -1), (1, 1), (-1, 1), (-1, -1))])

    body = loft(np.stack([ring(0.34, 0.38, 0.06), ring(0.44, 0.46, 0.86), ring(0.5, 0.5, 0.88), ring(0.5, 0.5, 0.93),
                          ring(0.36, 0.36, 1.0)]))  # fmt: skip
    wheels = [box((-0.36, side * 0.36, 0.09), (0.22, 0.08, 0.18)) for side in (-1, 1)]
    return MeshTemplate.from_triangles(*body), MeshTemplate.from_triangles(
        *join(*wheels, box((0.3, 0.0, 0.04), (0.1, 0.6, 0.08)))
    )


@lru_cache(maxsize=1)
def _cone() -> tuple[MeshTemplate, MeshTemplate]:
    body = lathe(np.array([(0.36, 0.04), (0.09, 1.0)]), 10)
    sleeve = lathe(np.array([(0.27, 0.45), (0.20, 0.72)]) * (1.03, 1.0), 10)
    return MeshTemplate.from_triangles(*body), MeshTemplate.from_triangles(*sleeve)
