"""What stands on posts: lamps, poles, signs, traffic lights, billboards, gantries.

Signs have the sizes of the administrative rule of the German road code (VwV-StVO, on sections 39 to 43): discs of 0.42,
0.60 and 0.75 m, triangles of 0.63, 0.90 and 1.26 m, squares of 0.42, 0.60 and 0.84 m; lenses of traffic lights measure
0.2 or 0.3 m (EN 12368); clearance over a road is 4.5 m at least.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import box, join, quads, tube
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import Primitive

LAMP_ARM = 1.9  # m, the longest
GANTRY_POST = 0.5  # m, how wide the posts of a gantry are
_FORMS = ("disc", "triangle", "square", "octagon")


def lamp(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A lamp post: with an arm to its left (+y) and a luminaire, or, if it is low, a lantern on its top."""
    diameter, _, height = placed.size
    builder = ObjectBuilder(placed)
    post(builder, diameter, height)
    if height < 5.0 and rng.random() < 0.6:
        builder.add("cylinder", (0.0, 0.0, height - 0.25), (0.42, 0.42, 0.5), "pole", "plastic")
        return builder.primitives
    arm = rng.uniform(0.6, LAMP_ARM - 0.3)
    builder.add("box", (0.0, arm / 2, height - 0.08), (0.08, arm, 0.08), "pole")
    builder.add("box", (0.0, arm, height - 0.12), (0.25, 0.6, 0.14), "pole", "plastic")
    if rng.random() < 0.5:  # the door of the fuse box
        builder.add("box", (0.0, 0.0, 0.6), (1.15 * diameter, 0.7 * diameter, 0.5), "pole", "metal")
    return builder.primitives


def pole(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A bare pole, a wooden one if it is high and thick, or a bollard, some with a reflecting band."""
    diameter, _, height = placed.size
    builder = ObjectBuilder(placed)
    post(
        builder,
        diameter,
        height,
        "wood" if height > 5.0 and diameter > 0.2 else "concrete" if diameter > 0.25 else "metal",
    )
    if height < 1.3 and rng.random() < 0.5:
        builder.add(
            "cylinder", (0.0, 0.0, 0.85 * height), (1.04 * diameter, 1.04 * diameter, 0.1), "pole", "retroreflector"
        )
    return builder.primitives


def sign(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A plate from `clearance` to the top on a post: its face, to the front (+x), reflects back, its back is grey."""
    _, width, height = placed.size
    builder = ObjectBuilder(placed)
    tall = height - placed.clearance
    post(builder, 0.076, height - 0.05)  # DIN EN 12767 tube, 76 mm
    if width > 1.5:  # a board on two posts
        builder.primitives.clear()
        for side in (-0.35, 0.35):
            at = (0.0, side * width, (height - EMBEDMENT) / 2)
            builder.add("cylinder", at, (0.1, 0.1, height + EMBEDMENT), "pole")
        _plate(builder, "square", 0.0, width, placed.clearance, tall)
    elif tall > 1.3 * width and rng.random() < 0.7:
        # two plates, one over the other
        _plate(builder, str(rng.choice(_FORMS[:2])), 0.0, width, height - width, width)
        _plate(builder, "square", 0.0, width, placed.clearance, tall - width - 0.03)
    else:
        form = str(rng.choice(_FORMS, p=(0.4, 0.2, 0.36, 0.04))) if 0.8 < tall / width < 1.25 else "square"
        _plate(builder, form, 0.0, width, placed.clearance, tall)
    return builder.primitives


def traffic_light(placed: PlacedObject, _rng: np.random.Generator) -> list[Primitive]:
    """A housing with three lenses from `clearance` to the top, facing forward, on a post.

    One wider than 1 m hangs from a mast arm: the post stands at the right end (-y) of its width, the arm reaches to the
    left end and carries a signal; another is on the post.
    """
    depth, width, height = placed.size
    builder = ObjectBuilder(placed)
    tall = height - placed.clearance
    if width <= 1.0:
        post(builder, 0.11, placed.clearance + 0.1)
        _signal(builder, 0.0, placed.clearance, (depth, width, tall))
        return builder.primitives
    at = -width / 2 + 0.15
    post(builder, 0.2, height, y=at)
    builder.add("box", (0.0, 0.05, height - 0.08), (0.14, width - 0.1, 0.14), "pole")
    housing = (0.25, 0.32, min(tall, 0.95))
    _signal(builder, width / 2 - 0.2, height - housing[2], housing, ahead=0.2)
    _signal(builder, at, 2.3, (0.25, 0.32, 0.95), ahead=0.2)
    return builder.primitives


def billboard(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A poster (18/1: 3.56 x 2.52 m) from `clearance` to the top, facing forward (+x), on one post or two."""
    depth, width, height = placed.size
    builder = ObjectBuilder(placed)
    tall = height - placed.clearance
    posts = (0.0,) if width < 2.0 or placed.clearance > 2.0 else (-0.35 * width, 0.35 * width)
    for y in posts:
        builder.add(
            "box",
            (0.0, y, (placed.clearance + 0.1 - EMBEDMENT) / 2),
            (0.16, 0.2, placed.clearance + 0.1 + EMBEDMENT),
            "other",
            "metal",
        )
    builder.add("box", (0.0, 0.0, placed.clearance + tall / 2), (min(depth, 0.3), width, tall), "other", "metal")
    out = min(depth, 0.3) / 2
    face = (0.02, 0.94 * width, 0.9 * tall)
    for side in (-1, 1) if rng.random() < 0.5 else (1,):
        builder.add("box", (side * out, 0.0, placed.clearance + tall / 2), face, "other", "plastic")
    return builder.primitives


def gantry(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A sign bridge over a road along x: posts at the ends of its width, a truss, boards that face forward (+x).

    `clearance` is the clearance under it.
    """
    depth, width, height = placed.size
    builder = ObjectBuilder(placed)
    tall = height - placed.clearance
    for side in (-1, 1):
        y = side * (width - GANTRY_POST) / 2
        size = (min(depth, 0.5), GANTRY_POST, height + EMBEDMENT)
        builder.add("box", (0.0, y, (height - EMBEDMENT) / 2), size, "pole")
    builder.add_mesh(_truss(), (min(depth, 0.8), width, min(tall, 1.2)), "pole", "metal", at=(0, 0, placed.clearance))
    count = max(1, round(width / 4.5))
    for number in range(count):
        if rng.random() < 0.75 or number == count // 2:
            wide = 0.8 * (width - 2 * GANTRY_POST) / count
            y = (number + 0.5 - count / 2) * (width - 2 * GANTRY_POST) / count
            board = tall * rng.uniform(0.75, 1.0)
            _plate(builder, "square", y, wide, placed.clearance, board, ahead=min(depth, 0.8) / 2 + 0.02)
    return builder.primitives


def post(builder: ObjectBuilder, diameter: float, height: float, material: str | None = None, y: float = 0.0) -> None:
    """Add a round post that reaches a little into the ground."""
    builder.add(
        "cylinder", (0.0, y, (height - EMBEDMENT) / 2), (diameter, diameter, height + EMBEDMENT), "pole", material
    )


def _plate(
    builder: ObjectBuilder, form: str, y: float, width: float, bottom: float, tall: float, *, ahead: float = 0.05
) -> None:
    mesh, scale = _face(form), (1.0, width, tall)
    for x, material in ((ahead + 0.015, "retroreflector"), (ahead, "sign-back")):
        builder.add_mesh(mesh, scale, "traffic-sign", material, at=(x, y, bottom + tall / 2))


@lru_cache(maxsize=8)
def _face(form: str) -> MeshTemplate:
    """A flat plate across x in the unit square."""
    sides, turn = {"disc": (12, 0.5), "triangle": (3, 0.75), "square": (4, 0.5), "octagon": (8, 0.5)}[form]
    angle = 2 * np.pi * (np.arange(sides) + turn) / sides
    ring = np.stack([np.zeros(sides), np.cos(angle), np.sin(angle)], axis=1)
    low, high = ring.min(axis=0), ring.max(axis=0)
    ring = (ring - (low + high) / 2) / np.where(high > low, high - low, 1.0)
    fan = np.stack([np.zeros(sides - 2, dtype=np.int64), np.arange(1, sides - 1), np.arange(2, sides)], axis=1)
    return MeshTemplate.from_triangles(ring, fan)


def _signal(
    builder: ObjectBuilder, y: float, bottom: float, size: tuple[float, float, float], *, ahead: float = 0.0
) -> None:
    center = (ahead, y, bottom + size[2] / 2)
    builder.add("box", center, size, "traffic-light", "plastic")
    builder.add_mesh(_lenses(), size, "traffic-light", "glass", at=center)


@lru_cache(maxsize=1)
def _lenses() -> MeshTemplate:
    """Three lenses before the front of a housing, and the shades over them."""
    angle = 2 * np.pi * np.arange(8) / 8
    ring = np.stack([np.full(8, 0.53), 0.34 * np.cos(angle), 0.12 * np.sin(angle)], axis=1)
    quadrilaterals = []
    for z in (-1 / 3, 0.0, 1 / 3):
        disc = ring + np.array([0.0, 0.0, z])
        quadrilaterals.append(disc[[[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 7]]])
        shade = np.array(
            [[(0.5, -0.36, z + 0.13), (0.5, 0.36, z + 0.13), (1.0, 0.36, z + 0.11), (1.0, -0.36, z + 0.11)]]
        )
        quadrilaterals.append(shade)
    return MeshTemplate.from_triangles(*quads(np.concatenate(quadrilaterals)))


@lru_cache(maxsize=1)
def _truss() -> MeshTemplate:
    """Four chords and the diagonals between, in shares of depth, width and height over the clearance."""
    chords = [box((x, 0.0, z), (0.16, 1.0, 0.12)) for x in (-0.42, 0.42) for z in (0.08, 0.92)]
    steps = np.linspace(-0.48, 0.48, 11)
    bars = [
        tube((x, float(a), z), (x, float(b), 1.0 - z), (0.008, 0.008), 3)
        for x in (-0.42, 0.42)
        for a, b, z in zip(steps[:-1], steps[1:], [0.1, 0.9] * 5, strict=True)
    ]
    return MeshTemplate.from_triangles(*join(*chords, *bars))
