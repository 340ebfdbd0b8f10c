"""Plants are media: a ray enters a crown, a bush, a hedge or grass and returns from the inside, or leaves it.

Extinction is k = G * LAD: leaf-area density LAD [m2/m3] seen from any direction (spherical leaf angles, G = 0.5; Ross,
The radiation regime and architecture of plant stands, 1981). LAD is the leaf-area index over the height of the foliage:
5.1 for temperate deciduous trees, 5.5 for conifers, 2.1 for shrubs, 1.7 for grass on average (Asner et al., Global
Ecology and Biogeography 12, 2003); single street trees have 3 to 5 (Nowak, Forest Science 42, 1996). Trimmed hedges are
denser, 5 to 10 m2/m3 (estimate). An index is per area of the ground under a crown, so crowns that narrow upwards are
denser. Leafless twigs stop a fifth as much as leaves.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, join, tube
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder
from lidardraft.objects.placed_object import Vector

_G = 0.5
_BOUGHS = 6  # ways to branch: an estimate
_BOUGH_STREAM = 19  # random numbers of a way to branch

# Leaf-area indices [m2/m2], lowest and highest, sources in the module; densities of parts over the whole's.
_LEAVES_BROADLEAF = (3.0, 5.0)
_LEAVES_CONIFER = (4.0, 7.0)
_LEAVES_BUSH = (2.0, 4.5)
_LEAVES_HEDGE = (5.0, 10.0)  # density [m2/m3]
_LEAVES_GRASS = (1.7, 0.6)  # mean and deviation
_LEAVES_GRASS_LIMITS = (0.6, 4.0)
_LEAVES_TWIGS = 0.2  # relative to leaves
_LEAVES_SINGLE = 1.5  # single ellipsoids, and bushes: narrower towards the top
_LEAVES_TIERS = 1.5
_LEAVES_CORE = 1.2  # of a crown of lobes; the lobes make up for the gaps
_LEAVES_LOBES = 1.7  # of the lobes
_LEAVES_HEDGE_CORE = 2.0

# Forms of street trees, in shares of the crown's extents without a unit: estimates.
_TREE_CONIFER_P = (0.06, 0.3)  # of wide and of slender ones
_TREE_SLENDER = 1.2  # times as high as wide
_TREE_BARE_ABOVE = 0.93  # of the same number in 0 to 1: 7 % have no leaves
_TREE_TRUNK = (0.45, 0.85)  # its reach into the crown: broadleaf, conifer
_TREE_COLUMN = 1.8  # times as high as wide: one ellipsoid
_TREE_YOUNG = 5.0  # m, below: one ellipsoid
_TREE_SINGLE = 0.98
_TREE_CORE = (0.78, 0.96)  # width and height
_TREE_LOBES = (2, 5)  # fewest, and one more than the most
_TREE_LOBE_TURN = 0.2  # of the angle between two
_TREE_LOBE_WIDTH = (0.46, 0.62)
_TREE_LOBE_HEIGHT = (0.45, 0.65)
_TREE_LOBE_RISE = (-0.8, 0.5)  # of the room over and under the lobe
# Tiers of conifers: middle, width, height; the limit of their density relative to the lowest.
_TREE_TIERS: tuple[Vector, ...] = ((0.2, 1.0, 0.4), (0.42, 0.76, 0.42), (0.64, 0.52, 0.4), (0.84, 0.28, 0.32))
_TREE_NARROWEST = 0.4

# Rounds of foliage of a bush, in shares of its extents: estimates.
_BUSH_CORE = (0.8, 0.8, 1.1)
_BUSH_CORE_MIDDLE = 0.45
_BUSH_ROUND = (0.5, 0.66)  # length and width
_BUSH_HEIGHT = (0.6, 0.9)
_BUSH_TALL = 1.1  # of that height; the ellipsoid reaches into the ground
_BUSH_MIDDLE = 0.42  # of that height

# Cut hedges: estimates.
_HEDGE_INSET = 0.3  # m, the difference of the core's length
_HEDGE_LEAST_CORE = 0.5  # share of the length
_HEDGE_CORE = (0.5, 0.85)  # shares of width and height
_HEDGE_PER_PART = 3.5  # m
_HEDGE_MOST_PARTS = 5
_HEDGE_WIDTH = (0.86, 1.0)  # shares, of the parts
_HEDGE_HEIGHT = (0.93, 1.0)

# Patches of grass: estimates.
_GRASS_PER_PART = 8.0  # m
_GRASS_MOST_PARTS = 4
_GRASS_HEIGHT = (0.45, 1.0)  # shares, of all but the middle part, which has the full height

# Boughs in shares of the crown, with leaves and without: estimates.
_BOUGH_COUNT = (5, 9)
_BOUGH_TURN = 0.382  # of a circle, from one to the next: the golden angle
_BOUGH_OFF = 0.3  # of that, at random
_BOUGH_REACH = ((0.26, 0.36), (0.36, 0.46))
_BOUGH_FOOT = (-0.48, 0.4)  # of the lowest; the spread of the others above it
_BOUGH_RISE = (0.25, 0.45)
_BOUGH_TOP = 0.4
_BOUGH_DIAMETER = 0.03
_BOUGH_THINNER = 0.4  # the highest
_BOUGH_TIP = 0.3  # of the diameter at the foot
_BOUGH_LEADER = ((0.0, 0.0, -0.1), (0.02, 0.01, 0.42), (0.03, 0.008))


def tree(builder: ObjectBuilder, rng: np.random.Generator, *, bare: bool | None = None) -> None:
    """A trunk, boughs, and a crown from `clearance` to the top: broadleaf of lobes, a column, a conifer, or bare.

    `bare` decides whether it has leaves; None leaves that to chance.
    """
    length, width, height = builder.placed.size
    crown, diameter = height - builder.placed.clearance, trunk_diameter(height)
    pick = rng.random()
    slender = crown / max(length, width)
    conifer = pick < _TREE_CONIFER_P[slender > _TREE_SLENDER]
    bare = not conifer and (pick > _TREE_BARE_ABOVE if bare is None else bare)
    top = builder.placed.clearance + _TREE_TRUNK[conifer] * crown
    builder.add("cylinder", (0.0, 0.0, (top - EMBEDMENT) / 2), (diameter, diameter, top + EMBEDMENT), "trunk")
    if conifer:
        _add_tiers(builder, crown, _LEAVES_TIERS * _G * rng.uniform(*_LEAVES_CONIFER) / crown)
        return
    form = int(rng.integers(_BOUGHS))
    middle = (0.0, 0.0, builder.placed.clearance + crown / 2)
    builder.add_mesh(_boughs(form, bare), (length, width, crown), "trunk", at=middle)
    density = _G * rng.uniform(*_LEAVES_BROADLEAF) / crown * (_LEAVES_TWIGS if bare else 1.0)
    if slender > _TREE_COLUMN or height < _TREE_YOUNG or bare:
        size = (_TREE_SINGLE * length, _TREE_SINGLE * width, crown)
        builder.add("ellipsoid", middle, size, "vegetation", extinction=_LEAVES_SINGLE * density)
    else:
        _add_lobes(builder, middle, (length, width, crown), density, rng)


def trunk_diameter(height: float) -> float:
    """The diameter of the trunk of a tree of that height [m]: 20 cm at 4.5 m, 39 cm at 13 m, an estimate for street
    trees."""
    return 0.10 + height / 45


def bush(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bush from the ground up: three rounds of foliage."""
    length, width, height = builder.placed.size
    density = _LEAVES_SINGLE * (_G * rng.uniform(*_LEAVES_BUSH) / height)
    a, b, c = _BUSH_CORE
    at = (0.0, 0.0, _BUSH_CORE_MIDDLE * height)
    builder.add("ellipsoid", at, (a * length, b * width, c * height), "vegetation", extinction=density)
    for side in (-1, 1):
        share = rng.uniform(*_BUSH_ROUND)
        tall = height * rng.uniform(*_BUSH_HEIGHT)
        x, y = side * (1 - share) / 2 * length, rng.uniform(-0.5, 0.5) * (1 - share) * width
        size = (share * length, share * width, _BUSH_TALL * tall)
        builder.add("ellipsoid", (x, y, _BUSH_MIDDLE * tall), size, "vegetation", extinction=density)


def hedge(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A trimmed hedge: a dense core of twigs, and foliage in lengths of slightly different heights and widths."""
    length, width, height = builder.placed.size
    density = _G * rng.uniform(*_LEAVES_HEDGE)
    wide, tall = _HEDGE_CORE
    core = (max(length - _HEDGE_INSET, _HEDGE_LEAST_CORE * length), wide * width, tall * height + EMBEDMENT)
    at = (0.0, 0.0, core[2] / 2 - EMBEDMENT)
    builder.add("box", at, core, "vegetation", extinction=_LEAVES_HEDGE_CORE * density)
    count = int(np.clip(round(length / _HEDGE_PER_PART), 1, _HEDGE_MOST_PARTS))
    step = length / count
    for number in range(count):
        wide, tall = width * rng.uniform(*_HEDGE_WIDTH), height * rng.uniform(*_HEDGE_HEIGHT)
        at = ((number + 0.5) * step - length / 2, rng.uniform(-0.5, 0.5) * (width - wide), (tall - EMBEDMENT) / 2)
        builder.add("box", at, (step, wide, tall + EMBEDMENT), "vegetation", extinction=density)


def grass(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """Grass over a verge, in patches of different heights up to the object's; `z` is the lowest ground there."""
    length, width, height = builder.placed.size
    count = int(np.clip(round(length / _GRASS_PER_PART), 1, _GRASS_MOST_PARTS))
    step = length / count
    for number in range(count):
        tall = height * (1.0 if number == count // 2 else rng.uniform(*_GRASS_HEIGHT))
        density = _G * float(np.clip(rng.normal(*_LEAVES_GRASS), *_LEAVES_GRASS_LIMITS)) / tall
        at = ((number + 0.5) * step - length / 2, 0.0, tall / 2)
        builder.add("box", at, (step, width, tall), "terrain", "grass", extinction=density)


def _add_lobes(builder: ObjectBuilder, middle: Vector, size: Vector, density: float, rng: np.random.Generator) -> None:
    """A crown of overlapping lobes around a core; their density makes up for the gaps between them."""
    length, width, crown = size
    wide, tall = _TREE_CORE
    core = (wide * length, wide * width, tall * crown)
    builder.add("ellipsoid", middle, core, "vegetation", extinction=_LEAVES_CORE * density)
    count = int(rng.integers(*_TREE_LOBES))
    start = rng.uniform(0.0, 2 * math.pi)
    for number in range(count):
        angle = start + 2 * math.pi * (number + rng.uniform(-_TREE_LOBE_TURN, _TREE_LOBE_TURN)) / count
        share, tall = rng.uniform(*_TREE_LOBE_WIDTH), rng.uniform(*_TREE_LOBE_HEIGHT)
        off = (1.0 - share) / 2
        rise = rng.uniform(*_TREE_LOBE_RISE) * (1.0 - tall) / 2
        at = (math.cos(angle) * off * length, math.sin(angle) * off * width, middle[2] + rise * crown)
        lobe = (share * length, share * width, tall * crown)
        builder.add("ellipsoid", at, lobe, "vegetation", extinction=_LEAVES_LOBES * density)


def _add_tiers(builder: ObjectBuilder, crown: float, density: float) -> None:
    """The tiers of a conifer, narrower and denser towards the top."""
    length, width, _ = builder.placed.size
    for middle, share, tall in _TREE_TIERS:
        at = (0.0, 0.0, builder.placed.clearance + middle * crown)
        tier = (share * length, share * width, tall * crown)
        builder.add("ellipsoid", at, tier, "vegetation", extinction=density / max(share, _TREE_NARROWEST))


@lru_cache(maxsize=2 * _BOUGHS)
def _boughs(form: int, bare: bool) -> MeshTemplate:
    """Boughs in shares of the crown, up to two thirds of the way to its rim; more and longer ones in a bare crown."""
    rng = np.random.default_rng([form, _BOUGH_STREAM])
    count = _BOUGH_COUNT[bare]
    low_foot, spread = _BOUGH_FOOT
    bars = []
    for number in range(count):
        angle = 2 * math.pi * (number + rng.uniform(-_BOUGH_OFF, _BOUGH_OFF)) * _BOUGH_TURN
        reach = rng.uniform(*_BOUGH_REACH[bare])
        low = low_foot + spread * number / count
        high = min(low + rng.uniform(*_BOUGH_RISE), _BOUGH_TOP)
        foot = _BOUGH_DIAMETER * (1.0 - _BOUGH_THINNER * number / count)
        end = (reach * math.cos(angle), reach * math.sin(angle), high)
        bars.append(tube((0.0, 0.0, low), end, (foot, _BOUGH_TIP * foot), 5))
    bars.append(tube(*_BOUGH_LEADER, 5))
    return MeshTemplate.from_triangles(*join(*bars))
