"""Plants: trees, bushes and hedges of loose foliage, so that rays go partly through."""

from __future__ import annotations

import numpy as np

from lidardraft.scene.layout import Primitive
from lidardraft.streets.solids import Solid
from lidardraft.streets.thing import Parts, Thing


def tree(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A trunk, and a crown of foliage between `stem` and the top."""
    length, width, height = thing.size
    parts = Parts(thing)
    crown = height - thing.stem
    girth = trunk_diameter(thing)
    top = thing.stem + 0.4 * crown
    # the lower end is a little under the ground, so that no slope shows a gap
    parts.add("cylinder", (0.0, 0.0, (top - 0.3) / 2), (girth, girth, top + 0.3), "trunk")
    parts.add_mesh(*_crown((length, width, crown), thing.stem, 1100, rng), "vegetation")
    return parts.primitives


def trunk_diameter(thing: Thing) -> float:
    """Growing with the height, 20 cm at 4.5 m and 39 cm at 13 m: an estimate of ours for street trees."""
    return 0.10 + thing.size[2] / 45


def bush(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A bush from the ground up: a core that stops rays in loose foliage."""
    parts = Parts(thing)
    length, width, height = thing.size
    parts.add("ellipsoid", (0.0, 0.0, 0.45 * height), (0.75 * length, 0.75 * width, 0.75 * height), "vegetation")
    parts.add_mesh(*_crown(thing.size, 0.0, 1000, rng), "vegetation")
    return parts.primitives


def hedge(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A cut hedge: a core that stops rays and foliage that makes its faces uneven."""
    parts = Parts(thing)
    length, width, height = thing.size
    parts.add("box", (0.0, 0.0, height / 2 - 0.2), (length - 0.2, 0.62 * width, height), "vegetation")
    count = int(80 * length)
    spread = 0.1
    at = rng.uniform(-0.5, 0.5, (count, 3)) * (np.array(thing.size) - 2.0 * spread)
    # pushed out to a face: two in three to the sides, the others to the top
    side = rng.random(count) < 0.67
    at[:, 1] = np.where(side, np.sign(at[:, 1]) * (width / 2 - spread), at[:, 1])
    at[:, 2] = height / 2 + np.where(side, at[:, 2], height / 2 - spread)
    parts.add_mesh(*_leaves(at, spread, rng), "vegetation")
    return parts.primitives


def _leaves(at: np.ndarray, spread: float, rng: np.random.Generator) -> Solid:
    """A triangle of foliage around each point [n, 3], facing anywhere; `spread` [m] is the deviation of its corners."""
    corners = at[:, None, :] + np.clip(rng.normal(0.0, spread, (len(at), 3, 3)), -1.5 * spread, 1.5 * spread)
    return corners.reshape(-1, 3), np.arange(3 * len(at)).reshape(-1, 3)


def _crown(size: tuple[float, float, float], bottom: float, count: int, rng: np.random.Generator) -> Solid:
    """An ellipsoid of foliage, most of it near the rim as the light would have it, with holes."""
    extent = np.array(size)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    radius = rng.uniform(0.4, 1.0, (count, 1)) ** 0.12
    # boughs: foliage keeps to lobes of the crown
    lobes = rng.normal(size=(4, 3))
    radius *= 1.0 - 0.07 * (np.sin(3.0 * direction @ lobes.T).mean(axis=1, keepdims=True) + 0.5).clip(0.0, 1.0)
    spread = 0.06 * float(extent.min())
    at = 0.5 * direction * radius * (extent - 0.8 * spread) + (0.0, 0.0, bottom + size[2] / 2)
    return _leaves(at, spread, rng)
