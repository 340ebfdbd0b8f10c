"""Street furniture: lamps, signs, traffic lights, fences, garden walls, bins, benches."""

from __future__ import annotations

import numpy as np

from lidardraft.scene.layout import Primitive
from lidardraft.streets.solids import quads
from lidardraft.streets.thing import Parts, Thing

LAMP_ARM = 1.9  # m, the longest
SINK = 0.3  # m that posts and walls reach into the ground, so that no slope shows a gap


def lamp(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A lamp post with an arm to its left (+y) and a luminaire."""
    girth, _, height = thing.size
    parts = Parts(thing)
    _post(parts, girth, height)
    arm = rng.uniform(0.6, LAMP_ARM - 0.3)
    parts.add("box", (0.0, arm / 2, height - 0.08), (0.08, arm, 0.08), "pole")
    parts.add("box", (0.0, arm, height - 0.12), (0.25, 0.6, 0.14), "pole")
    return parts.primitives


def pole(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A bare pole or bollard."""
    parts = Parts(thing)
    _post(parts, thing.size[0], thing.size[2])
    return parts.primitives


def sign(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A plate from `stem` to the top, facing forward, on a post; a disc or a rectangle."""
    _, width, height = thing.size
    parts = Parts(thing)
    _post(parts, 0.076, height)
    plate = (0.06, 0.0, (thing.stem + height) / 2), (0.03, width, height - thing.stem)
    parts.add("ellipsoid" if rng.random() < 0.5 else "box", *plate, "traffic-sign")
    return parts.primitives


def traffic_light(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A housing with three lenses from `stem` to the top, facing forward, on a post."""
    depth, width, height = thing.size
    parts = Parts(thing)
    _post(parts, 0.11, thing.stem)
    parts.add("box", (0.0, 0.0, (thing.stem + height) / 2), (depth, width, height - thing.stem), "traffic-light")
    for lens in range(3):
        z = thing.stem + (lens + 0.5) * (height - thing.stem) / 3
        parts.add("ellipsoid", (depth / 2, 0.0, z), (0.12, 0.22, 0.22), "traffic-light", "glass")
    return parts.primitives


def fence(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """Upright slats with gaps between them, posts and two rails."""
    length, width, height = thing.size
    parts = Parts(thing)
    share = rng.uniform(0.65, 0.92)
    pitch = rng.uniform(0.12, 0.2)
    x = np.arange(-length / 2, length / 2 - pitch * share, pitch)
    slats = np.zeros((len(x), 4, 3))
    slats[:, :, 0] = x[:, None] + np.array([0.0, pitch * share, pitch * share, 0.0])
    slats[:, :, 1] = width / 2
    slats[:, :, 2] = [0.06, 0.06, height, height]
    parts.add_mesh(*quads(slats), "fence")
    for z in (0.25 * height, 0.8 * height):
        parts.add("box", (0.0, 0.0, z), (length, 0.05, 0.08), "fence")
    for post in np.linspace(-length / 2 + 0.05, length / 2 - 0.05, max(2, round(length / 2.5) + 1)).tolist():
        parts.add("box", (post, 0.0, (height - SINK) / 2), (0.09, 0.09, height + SINK), "fence")
    return parts.primitives


def garden_wall(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A wall with a coping."""
    length, width, height = thing.size
    parts = Parts(thing)
    parts.add("box", (0.0, 0.0, (height - 0.08 - SINK) / 2), (length, 0.8 * width, height - 0.08 + SINK), "wall")
    parts.add("box", (0.0, 0.0, height - 0.04), (length, width, 0.08), "wall", "paving")
    return parts.primitives


def bin(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A wheeled waste bin with a lid."""
    length, width, height = thing.size
    parts = Parts(thing)
    parts.add("box", (0.0, 0.0, 0.47 * height), (0.85 * length, 0.85 * width, 0.94 * height), "other", "rubber")
    parts.add("box", (0.0, 0.0, 0.97 * height), (length, width, 0.06 * height), "other", "rubber")
    return parts.primitives


def bench(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A bench with a back, open below."""
    length, width, height = thing.size
    parts = Parts(thing)
    parts.add("box", (0.0, 0.0, 0.45), (length, width, 0.06), "other", "wood")
    parts.add("box", (0.0, -width / 2 + 0.04, (0.5 + height) / 2), (length, 0.06, height - 0.55), "other", "wood")
    for x in (-0.4 * length, 0.4 * length):
        parts.add("box", (x, 0.0, 0.21), (0.08, 0.9 * width, 0.42), "other", "metal")
    return parts.primitives


def _post(parts: Parts, girth: float, height: float) -> None:
    parts.add("cylinder", (0.0, 0.0, (height - SINK) / 2), (girth, girth, height + SINK), "pole")
