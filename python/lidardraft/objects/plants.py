"""Plants are media: a ray goes into a crown, a bush, a hedge or grass and returns from somewhere inside, or comes out.

Extinction is k = G * LAD: leaf-area density LAD [m2/m3] seen from anywhere (spherical leaf angles, G = 0.5; Ross, The
radiation regime and architecture of plant stands, 1981). LAD is the leaf-area index over the height of the foliage:
5.1 for temperate deciduous trees, 5.5 for conifers, 2.1 for shrubs, 1.7 for grass on average (Asner et al., Global
Ecology and Biogeography 12, 2003); single street trees have 3 to 5 (Nowak, Forest Science 42, 1996). Trimmed hedges are
denser, 5 to 10 m2/m3 (estimate of ours). An index is over the ground under a crown, so what narrows upward is denser.
Leafless twigs stop a fifth of what leaves do.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import join, tube
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import Primitive

_G = 0.5
_BOUGHS = 6  # ways to branch


def tree(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A trunk, boughs, and a crown from `clearance` to the top: broadleaf of lobes, a column, a conifer, or bare."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    crown, diameter = height - placed.clearance, trunk_diameter(height)
    pick = rng.random()
    slim = crown / max(length, width)
    conifer = pick < (0.3 if slim > 1.2 else 0.06)
    bare = not conifer and pick > 0.93
    top = placed.clearance + (0.85 if conifer else 0.45) * crown
    builder.add("cylinder", (0.0, 0.0, (top - EMBEDMENT) / 2), (diameter, diameter, top + EMBEDMENT), "trunk")
    if conifer:
        _stack(builder, crown, 1.5 * _G * rng.uniform(4.0, 7.0) / crown)
        return builder.primitives
    form = int(rng.integers(_BOUGHS))
    middle = (0.0, 0.0, placed.clearance + crown / 2)
    builder.add_mesh(_boughs(form, bare), (length, width, crown), "trunk", at=middle)
    density = _G * rng.uniform(3.0, 5.0) / crown * (0.2 if bare else 1.0)
    if slim > 1.8 or height < 5.0 or bare:
        # a column, a young tree
        builder.add("ellipsoid", middle, (0.98 * length, 0.98 * width, crown), "vegetation", extinction=1.5 * density)
    else:
        _lobes(builder, middle, (length, width, crown), density, rng)
    return builder.primitives


def trunk_diameter(height: float) -> float:
    """Of a tree of that height [m]: 20 cm at 4.5 m and 39 cm at 13 m, an estimate of ours for street trees."""
    return 0.10 + height / 45


def bush(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A bush from the ground up: two or three rounds of foliage, the middle one denser."""
    builder = ObjectBuilder(placed)
    length, width, height = placed.size
    density = _G * rng.uniform(2.0, 4.5) / height
    builder.add(
        "ellipsoid", (0.0, 0.0, 0.45 * height), (0.8 * length, 0.8 * width, 1.1 * height), "vegetation",
        extinction=1.5 * density,
    )  # fmt: skip
    for side in (-1, 1):
        share = rng.uniform(0.5, 0.66)
        tall = height * rng.uniform(0.6, 0.9)
        at = (side * (1 - share) / 2 * length, rng.uniform(-0.5, 0.5) * (1 - share) * width, 0.42 * tall)
        builder.add(
            "ellipsoid", at, (share * length, share * width, 1.1 * tall), "vegetation", extinction=1.5 * density
        )
    return builder.primitives


def hedge(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A cut hedge: a dense core of twigs, and foliage in lengths that are not quite as high and wide as each other."""
    builder = ObjectBuilder(placed)
    length, width, height = placed.size
    density = _G * rng.uniform(5.0, 10.0)
    core = (max(length - 0.3, 0.5 * length), 0.5 * width, 0.85 * height + EMBEDMENT)
    builder.add("box", (0.0, 0.0, core[2] / 2 - EMBEDMENT), core, "vegetation", extinction=2.0 * density)
    count = int(np.clip(round(length / 3.5), 1, 5))
    step = length / count
    for number in range(count):
        wide, tall = width * rng.uniform(0.86, 1.0), height * rng.uniform(0.93, 1.0)
        at = ((number + 0.5) * step - length / 2, rng.uniform(-0.5, 0.5) * (width - wide), (tall - EMBEDMENT) / 2)
        builder.add("box", at, (step, wide, tall + EMBEDMENT), "vegetation", extinction=density)
    return builder.primitives


def grass(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """Grass over a verge, in patches of different heights up to that of the thing; `z` is the lowest ground there."""
    builder = ObjectBuilder(placed)
    length, width, height = placed.size
    count = int(np.clip(round(length / 8.0), 1, 4))
    step = length / count
    for number in range(count):
        tall = height * (1.0 if number == count // 2 else rng.uniform(0.45, 1.0))
        density = _G * float(np.clip(rng.normal(1.7, 0.6), 0.6, 4.0)) / tall
        at = ((number + 0.5) * step - length / 2, 0.0, tall / 2)
        builder.add("box", at, (step, width, tall), "terrain", "grass", extinction=density)
    return builder.primitives


def _lobes(
    builder: ObjectBuilder,
    middle: tuple[float, float, float],
    size: tuple[float, float, float],
    density: float,
    rng: np.random.Generator,
) -> None:
    """A crown of overlapping lobes around a core; what the gaps between them take, they have in density."""
    length, width, crown = size
    builder.add(
        "ellipsoid", middle, (0.78 * length, 0.78 * width, 0.96 * crown), "vegetation", extinction=1.2 * density
    )  # fmt: skip
    count = int(rng.integers(2, 5))
    start = rng.uniform(0.0, 2 * math.pi)
    for number in range(count):
        angle = start + 2 * math.pi * (number + rng.uniform(-0.2, 0.2)) / count
        share, tall = rng.uniform(0.46, 0.62), rng.uniform(0.45, 0.65)
        off = (1.0 - share) / 2
        rise = rng.uniform(-0.8, 0.5) * (1.0 - tall) / 2
        at = (math.cos(angle) * off * length, math.sin(angle) * off * width, middle[2] + rise * crown)
        builder.add(
            "ellipsoid", at, (share * length, share * width, tall * crown), "vegetation", extinction=1.7 * density
        )


def _stack(builder: ObjectBuilder, crown: float, density: float) -> None:
    """The tiers of a conifer, narrower and denser towards the top."""
    length, width, _ = builder.placed.size
    for middle, share, tall in ((0.2, 1.0, 0.4), (0.42, 0.76, 0.42), (0.64, 0.52, 0.4), (0.84, 0.28, 0.32)):
        at = (0.0, 0.0, builder.placed.clearance + middle * crown)
        size = (share * length, share * width, tall * crown)
        builder.add("ellipsoid", at, size, "vegetation", extinction=density / max(share, 0.4))


@lru_cache(maxsize=2 * _BOUGHS)
def _boughs(form: int, bare: bool) -> MeshTemplate:
    """Boughs in shares of the crown, two thirds of the way to its rim; more and longer ones where it is bare."""
    rng = np.random.default_rng([form, 19])
    count = 9 if bare else 5
    bars = []
    for number in range(count):
        angle = 2 * math.pi * (number + rng.uniform(-0.3, 0.3)) * 0.382  # the golden angle's share
        reach = rng.uniform(0.36, 0.46) if bare else rng.uniform(0.26, 0.36)
        low = -0.48 + 0.4 * number / count
        high = min(low + rng.uniform(0.25, 0.45), 0.4)
        diameter = 0.03 * (1.0 - 0.4 * number / count)
        bars.append(
            tube(
                (0.0, 0.0, low), (reach * math.cos(angle), reach * math.sin(angle), high), (diameter, 0.3 * diameter), 5
            )
        )
    bars.append(tube((0.0, 0.0, -0.1), (0.02, 0.01, 0.42), (0.03, 0.008), 5))
    return MeshTemplate.from_triangles(*join(*bars))
