"""Plants are media: a ray goes into a crown, a bush, a hedge or grass and returns from somewhere inside, or comes out.

Extinction is k = G * LAD: leaf-area density LAD [m2/m3] seen from anywhere (spherical leaf angles, G = 0.5; Ross, The
radiation regime and architecture of plant stands, 1981). LAD is the leaf-area index over the height of the foliage:
5.1 for temperate deciduous trees, 5.5 for conifers, 2.1 for shrubs, 1.7 for grass on average (Asner et al., Global
Ecology and Biogeography 12, 2003); single street trees have 3 to 5 (Nowak, Forest Science 42, 1996). Trimmed hedges are
denser, 5 to 10 m2/m3 (estimate). An index is over the ground under a crown, so what narrows upward is denser.
Leafless twigs stop a fifth of what leaves do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, join, tube
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder
from lidardraft.objects.placed_object import Vector

_G = 0.5
_BOUGHS = 6  # ways to branch: an estimate
_BOUGH_STREAM = 19  # random numbers of a way to branch


@dataclass(frozen=True, slots=True)
class _LeafArea:
    """Leaf-area indices [m2/m2], lowest and highest, sources in the module; densities of parts over the whole's."""

    broadleaf: tuple[float, float] = (3.0, 5.0)
    conifer: tuple[float, float] = (4.0, 7.0)
    bush: tuple[float, float] = (2.0, 4.5)
    hedge: tuple[float, float] = (5.0, 10.0)  # density [m2/m3]
    grass: tuple[float, float] = (1.7, 0.6)  # mean and deviation
    grass_limits: tuple[float, float] = (0.6, 4.0)
    twigs: float = 0.2  # of what leaves stop
    single: float = 1.5  # what is one ellipsoid, and bushes: narrower towards the top
    tiers: float = 1.5
    core: float = 1.2  # of a crown of lobes, whose gaps take from the others what
    lobes: float = 1.7  # these have more
    hedge_core: float = 2.0


@dataclass(frozen=True, slots=True)
class _Tree:
    """Forms of street trees, in shares of the crown's extents where no unit is said: estimates."""

    conifer_p: tuple[float, float] = (0.06, 0.3)  # of wide and of slender ones
    slender: float = 1.2  # times as high as wide
    bare_above: float = 0.93  # of the same number in 0 to 1: 7 % have no leaves
    trunk: tuple[float, float] = (0.45, 0.85)  # how far it goes into the crown: broadleaf, conifer
    column: float = 1.8  # times as high as wide: one ellipsoid
    young: float = 5.0  # m, below: one ellipsoid
    single: float = 0.98
    core: tuple[float, float] = (0.78, 0.96)  # width and height
    lobes: tuple[int, int] = (2, 5)  # fewest, and one more than the most
    lobe_turn: float = 0.2  # of the angle between two
    lobe_width: tuple[float, float] = (0.46, 0.62)
    lobe_height: tuple[float, float] = (0.45, 0.65)
    lobe_rise: tuple[float, float] = (-0.8, 0.5)  # of the room over and under the lobe
    # Tiers of conifers: middle, width, height; how much denser than the lowest they may be.
    tiers: tuple[Vector, ...] = ((0.2, 1.0, 0.4), (0.42, 0.76, 0.42), (0.64, 0.52, 0.4), (0.84, 0.28, 0.32))
    narrowest: float = 0.4


@dataclass(frozen=True, slots=True)
class _Bush:
    """Rounds of foliage of a bush, in shares of its extents: estimates."""

    core: Vector = (0.8, 0.8, 1.1)
    core_middle: float = 0.45
    round: tuple[float, float] = (0.5, 0.66)  # length and width
    height: tuple[float, float] = (0.6, 0.9)
    tall: float = 1.1  # of that height, the ellipsoid reaches into the ground
    middle: float = 0.42  # of that height


@dataclass(frozen=True, slots=True)
class _Hedge:
    """Cut hedges: estimates."""

    inset: float = 0.3  # m that the core is shorter
    least_core: float = 0.5  # share of the length
    core: tuple[float, float] = (0.5, 0.85)  # shares of width and height
    per_part: float = 3.5  # m
    most_parts: int = 5
    width: tuple[float, float] = (0.86, 1.0)  # shares, of the parts
    height: tuple[float, float] = (0.93, 1.0)


@dataclass(frozen=True, slots=True)
class _Grass:
    """Patches of grass: estimates."""

    per_part: float = 8.0  # m
    most_parts: int = 4
    height: tuple[float, float] = (0.45, 1.0)  # shares, of all but the middle part, which has the whole


@dataclass(frozen=True, slots=True)
class _Boughs:
    """Boughs in shares of the crown, with leaves and without: estimates."""

    count: tuple[int, int] = (5, 9)
    turn: float = 0.382  # of a circle, from one to the next: the golden angle
    off: float = 0.3  # of that, at random
    reach: tuple[tuple[float, float], tuple[float, float]] = ((0.26, 0.36), (0.36, 0.46))
    foot: tuple[float, float] = (-0.48, 0.4)  # of the lowest; how far the others are spread over it
    rise: tuple[float, float] = (0.25, 0.45)
    top: float = 0.4
    diameter: float = 0.03
    thinner: float = 0.4  # the highest
    tip: float = 0.3  # of the diameter at the foot
    leader: tuple[Vector, Vector, tuple[float, float]] = ((0.0, 0.0, -0.1), (0.02, 0.01, 0.42), (0.03, 0.008))


_LEAVES, _TREE, _BUSH, _HEDGE, _GRASS, _BOUGH = _LeafArea(), _Tree(), _Bush(), _Hedge(), _Grass(), _Boughs()


def tree(builder: ObjectBuilder, rng: np.random.Generator, *, bare: bool | None = None) -> None:
    """A trunk, boughs, and a crown from `clearance` to the top: broadleaf of lobes, a column, a conifer, or bare.

    `bare` says whether it is, which is else left to chance.
    """
    length, width, height = builder.placed.size
    crown, diameter = height - builder.placed.clearance, trunk_diameter(height)
    pick = rng.random()
    slender = crown / max(length, width)
    conifer = pick < _TREE.conifer_p[slender > _TREE.slender]
    bare = not conifer and (pick > _TREE.bare_above if bare is None else bare)
    top = builder.placed.clearance + _TREE.trunk[conifer] * crown
    builder.add("cylinder", (0.0, 0.0, (top - EMBEDMENT) / 2), (diameter, diameter, top + EMBEDMENT), "trunk")
    if conifer:
        _add_tiers(builder, crown, _LEAVES.tiers * _G * rng.uniform(*_LEAVES.conifer) / crown)
        return
    form = int(rng.integers(_BOUGHS))
    middle = (0.0, 0.0, builder.placed.clearance + crown / 2)
    builder.add_mesh(_boughs(form, bare), (length, width, crown), "trunk", at=middle)
    density = _G * rng.uniform(*_LEAVES.broadleaf) / crown * (_LEAVES.twigs if bare else 1.0)
    if slender > _TREE.column or height < _TREE.young or bare:
        size = (_TREE.single * length, _TREE.single * width, crown)
        builder.add("ellipsoid", middle, size, "vegetation", extinction=_LEAVES.single * density)
    else:
        _add_lobes(builder, middle, (length, width, crown), density, rng)


def trunk_diameter(height: float) -> float:
    """Of a tree of that height [m]: 20 cm at 4.5 m and 39 cm at 13 m, an estimate for street trees."""
    return 0.10 + height / 45


def bush(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bush from the ground up: three rounds of foliage."""
    length, width, height = builder.placed.size
    density = _LEAVES.single * (_G * rng.uniform(*_LEAVES.bush) / height)
    a, b, c = _BUSH.core
    at = (0.0, 0.0, _BUSH.core_middle * height)
    builder.add("ellipsoid", at, (a * length, b * width, c * height), "vegetation", extinction=density)
    for side in (-1, 1):
        share = rng.uniform(*_BUSH.round)
        tall = height * rng.uniform(*_BUSH.height)
        x, y = side * (1 - share) / 2 * length, rng.uniform(-0.5, 0.5) * (1 - share) * width
        size = (share * length, share * width, _BUSH.tall * tall)
        builder.add("ellipsoid", (x, y, _BUSH.middle * tall), size, "vegetation", extinction=density)


def hedge(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A cut hedge: a dense core of twigs, and foliage in lengths that are not quite as high and wide as each other."""
    length, width, height = builder.placed.size
    density = _G * rng.uniform(*_LEAVES.hedge)
    wide, tall = _HEDGE.core
    core = (max(length - _HEDGE.inset, _HEDGE.least_core * length), wide * width, tall * height + EMBEDMENT)
    at = (0.0, 0.0, core[2] / 2 - EMBEDMENT)
    builder.add("box", at, core, "vegetation", extinction=_LEAVES.hedge_core * density)
    count = int(np.clip(round(length / _HEDGE.per_part), 1, _HEDGE.most_parts))
    step = length / count
    for number in range(count):
        wide, tall = width * rng.uniform(*_HEDGE.width), height * rng.uniform(*_HEDGE.height)
        at = ((number + 0.5) * step - length / 2, rng.uniform(-0.5, 0.5) * (width - wide), (tall - EMBEDMENT) / 2)
        builder.add("box", at, (step, wide, tall + EMBEDMENT), "vegetation", extinction=density)


def grass(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """Grass over a verge, in patches of different heights up to the object's; `z` is the lowest ground there."""
    length, width, height = builder.placed.size
    count = int(np.clip(round(length / _GRASS.per_part), 1, _GRASS.most_parts))
    step = length / count
    for number in range(count):
        tall = height * (1.0 if number == count // 2 else rng.uniform(*_GRASS.height))
        density = _G * float(np.clip(rng.normal(*_LEAVES.grass), *_LEAVES.grass_limits)) / tall
        at = ((number + 0.5) * step - length / 2, 0.0, tall / 2)
        builder.add("box", at, (step, width, tall), "terrain", "grass", extinction=density)


def _add_lobes(builder: ObjectBuilder, middle: Vector, size: Vector, density: float, rng: np.random.Generator) -> None:
    """A crown of overlapping lobes around a core; what the gaps between them take, they have in density."""
    length, width, crown = size
    wide, tall = _TREE.core
    core = (wide * length, wide * width, tall * crown)
    builder.add("ellipsoid", middle, core, "vegetation", extinction=_LEAVES.core * density)
    count = int(rng.integers(*_TREE.lobes))
    start = rng.uniform(0.0, 2 * math.pi)
    for number in range(count):
        angle = start + 2 * math.pi * (number + rng.uniform(-_TREE.lobe_turn, _TREE.lobe_turn)) / count
        share, tall = rng.uniform(*_TREE.lobe_width), rng.uniform(*_TREE.lobe_height)
        off = (1.0 - share) / 2
        rise = rng.uniform(*_TREE.lobe_rise) * (1.0 - tall) / 2
        at = (math.cos(angle) * off * length, math.sin(angle) * off * width, middle[2] + rise * crown)
        lobe = (share * length, share * width, tall * crown)
        builder.add("ellipsoid", at, lobe, "vegetation", extinction=_LEAVES.lobes * density)


def _add_tiers(builder: ObjectBuilder, crown: float, density: float) -> None:
    """The tiers of a conifer, narrower and denser towards the top."""
    length, width, _ = builder.placed.size
    for middle, share, tall in _TREE.tiers:
        at = (0.0, 0.0, builder.placed.clearance + middle * crown)
        tier = (share * length, share * width, tall * crown)
        builder.add("ellipsoid", at, tier, "vegetation", extinction=density / max(share, _TREE.narrowest))


@lru_cache(maxsize=2 * _BOUGHS)
def _boughs(form: int, bare: bool) -> MeshTemplate:
    """Boughs in shares of the crown, two thirds of the way to its rim; more and longer ones where it is bare."""
    rng = np.random.default_rng([form, _BOUGH_STREAM])
    count = _BOUGH.count[bare]
    low_foot, spread = _BOUGH.foot
    bars = []
    for number in range(count):
        angle = 2 * math.pi * (number + rng.uniform(-_BOUGH.off, _BOUGH.off)) * _BOUGH.turn
        reach = rng.uniform(*_BOUGH.reach[bare])
        low = low_foot + spread * number / count
        high = min(low + rng.uniform(*_BOUGH.rise), _BOUGH.top)
        foot = _BOUGH.diameter * (1.0 - _BOUGH.thinner * number / count)
        end = (reach * math.cos(angle), reach * math.sin(angle), high)
        bars.append(tube((0.0, 0.0, low), end, (foot, _BOUGH.tip * foot), 5))
    bars.append(tube(*_BOUGH.leader, 5))
    return MeshTemplate.from_triangles(*join(*bars))
