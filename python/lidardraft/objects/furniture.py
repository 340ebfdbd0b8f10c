"""Street furniture: shelters, and the small objects on a sidewalk.

Sizes: waste bins EN 840 (240 l: 0.58 x 0.74 x 1.07 m), traffic cones EN 13422 (0.5 and 0.75 m), pillar hydrants DIN EN
14384 (about 1 m). Other numbers are estimates.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, box, join, lathe, loft
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder

# Bus stops [m], `_SHARES` of length, width and height; a poster case holds 1.2 x 1.8 m. Estimates.
_SHELTER_ROOF = 0.16
_SHELTER_POSTS_LOWER = 0.1
_SHELTER_PANE = 0.03
_SHELTER_PANE_EXTINCTION = 12.0  # 1/m: 3 cm pass 70 % of the rays, an estimate for both ways
_SHELTER_PANES_SHARES = (0.475, 0.72)  # middle and extent, of the height
_SHELTER_BACK_SHARES = (0.44, 0.92)  # behind the middle, of the width; of the length
_SHELTER_SIDE_SHARES = (0.48, 0.07, 0.68)  # beside the middle, of the length; behind it and extent, of the width
_SHELTER_BENCH_SHARES = (0.1, 0.28, 0.55)  # aside and behind the middle; of the length
_SHELTER_BENCH = (0.35, 0.06, 0.46)  # depth, thickness, height of its middle
_SHELTER_BENCH_LEG = (0.1, 0.25, 0.44)
_SHELTER_POSTER_P = 0.6
_SHELTER_POSTER_INSET = 0.1  # its middle, from the end
_SHELTER_POSTER = (0.2, 1.3, 1.8)  # depth, width at most, height
_SHELTER_POSTER_MIDDLE = 1.1
_SHELTER_POSTER_SHARE = 0.9  # of the width, at most
_SHELTER_POSTER_FOOT = (0.1, 0.5, 0.25)
_SHELTER_POSTER_FOOT_MIDDLE = 0.1

# Benches [m], `_SHARE` of an extent: estimates.
_BENCH_SEAT = (0.06, 0.45)  # thickness, height of its middle
_BENCH_LEG = (0.08, 0.42)  # thickness, height
_BENCH_LEGS_SHARE = 0.4  # of the length, from the middle
_BENCH_LEG_SHARE = 0.9  # of the width
_BENCH_BACK_P = 0.8
_BENCH_BACK = (0.06, 0.55)  # thickness, height of its lower edge
_BENCH_BACK_INSET = 0.04  # its middle, from the rear
_BENCH_STAY = (0.04, 0.12, 0.5)  # the support of the back: thickness, height, its middle
_BENCH_STAY_SHARE = 0.85  # of the length

# Letterboxes, hydrants and cabinets [m], in shares of the extents without a unit: estimates.
_COLUMN_LETTERBOX = (0.7, 0.6)  # its middle and its height
_COLUMN_LETTERBOX_POST = (0.4, 0.12)  # its height; m thick
_COLUMN_HYDRANT = (0.62, 0.9)  # diameter, of the lesser extent; height
_COLUMN_BONNET = (1.2, 0.24, 0.88)  # of the diameter; height, middle
_COLUMN_OUTLETS = (0.12, 0.66)  # m thick; middle
_COLUMN_CABINET = (0.9, 0.95)
_COLUMN_CABINET_LID = 0.06  # m
_COLUMN_CABINET_PLINTH = 0.1  # m


_LITTER_BIN_BELOW = 0.95  # m: lower bins are round litter bins
_LITTER_BIN_SHARE = 0.9  # of the extents
_CONE_FOOT = 0.05  # m
# The rings of a wheeled bin from the foot up: half length, half width and height, in shares of its extents.
_WHEELED_BIN = ((0.34, 0.38, 0.06), (0.44, 0.46, 0.86), (0.5, 0.5, 0.88), (0.5, 0.5, 0.93), (0.36, 0.36, 1.0))
# Profiles of a cone and its reflecting sleeve: radius and height, in shares of its extents.
_CONE, _SLEEVE = ((0.36, 0.04), (0.09, 1.0)), ((0.27, 0.45), (0.20, 0.72))
_SLEEVE_OVER = 1.03  # times as wide as the cone under it

# Boxes, tubs, tables with chairs [m], shares of the extents where no unit is said: estimates.
_CRATE_MATERIALS: tuple[str, ...] = ("wood", "plastic", "metal", "light-paint")
_CRATE_BODY, _CRATE_LID = (0.86, 1.0), 0.05
_PLANTER_TUB, _PLANTER_DENSITY = (0.35, 0.6), (2.0, 6.0)  # m; 1/m, as of shrubs
_PLANTER_MATERIALS: tuple[str, ...] = ("concrete", "wood", "rusty-metal")
_TABLE = (0.04, 0.74, 0.08)  # thickness, height, of its leg
_CHAIR = (0.42, 0.45, 0.04)  # seat, height of it, thickness


def shelter(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bus stop, open to its left (+y): a roof on posts, panes around it, a bench, a poster case."""
    length, width, height = builder.placed.size
    roof = _SHELTER_ROOF
    builder.add("box", (0.0, 0.0, height - roof / 2), (length, width, roof), "other", "metal")
    builder.add_mesh(_shelter_posts(), (length, width, height - _SHELTER_POSTS_LOWER), "other", "metal")
    _add_panes(builder)
    aside, behind, share = _SHELTER_BENCH_SHARES
    depth, thick, z = _SHELTER_BENCH
    x, y = -aside * length, -behind * width
    builder.add("box", (x, y, z), (share * length, depth, thick), "other", "wood")
    builder.add("box", (x, y, _SHELTER_BENCH_LEG[2] / 2), _SHELTER_BENCH_LEG, "other", "metal")
    if rng.random() < _SHELTER_POSTER_P:
        depth, wide, tall = _SHELTER_POSTER
        x = 0.5 * length - _SHELTER_POSTER_INSET
        size = (depth, min(wide, _SHELTER_POSTER_SHARE * width), tall)
        builder.add("box", (x, 0.0, _SHELTER_POSTER_MIDDLE), size, "other", "plastic")
        builder.add("box", (x, 0.0, _SHELTER_POSTER_FOOT_MIDDLE), _SHELTER_POSTER_FOOT, "other", "metal")


def _add_panes(builder: ObjectBuilder) -> None:
    """A pane behind and one on each side."""
    length, width, height = builder.placed.size
    middle, extent = _SHELTER_PANES_SHARES
    z, tall, thick = middle * height, extent * height, _SHELTER_PANE
    behind, share = _SHELTER_BACK_SHARES
    aside, back, deep = _SHELTER_SIDE_SHARES
    for at, size in (
        ((0.0, -behind * width, z), (share * length, thick, tall)),
        ((-aside * length, -back * width, z), (thick, deep * width, tall)),
        ((aside * length, -back * width, z), (thick, deep * width, tall)),
    ):
        builder.add("box", at, size, "other", "glass", extinction=_SHELTER_PANE_EXTINCTION)


def bin(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A wheeled waste bin that widens to its lid, or a round litter bin."""
    length, width, height = builder.placed.size
    if height < _LITTER_BIN_BELOW:
        size = (_LITTER_BIN_SHARE * length, _LITTER_BIN_SHARE * width, height)
        builder.add("cylinder", (0.0, 0.0, height / 2), size, "other", "metal")
        return
    body, wheels = _wheeled_bin()
    builder.add_mesh(body, builder.placed.size, "other", "plastic")
    builder.add_mesh(wheels, builder.placed.size, "other", "rubber")


def bench(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bench that faces left (+y), open below; most have a back."""
    length, width, height = builder.placed.size
    thick, middle = _BENCH_SEAT
    builder.add("box", (0.0, 0.0, middle), (length, width, thick), "other", "wood")
    thick, tall = _BENCH_LEG
    for x in (-_BENCH_LEGS_SHARE * length, _BENCH_LEGS_SHARE * length):
        builder.add("box", (x, 0.0, tall / 2), (thick, _BENCH_LEG_SHARE * width, tall), "other", "metal")
    if rng.random() < _BENCH_BACK_P:
        y = _BENCH_BACK_INSET - width / 2
        thick, low = _BENCH_BACK
        builder.add("box", (0.0, y, (low + height) / 2), (length, thick, height - low), "other", "wood")
        thick, tall, middle = _BENCH_STAY
        builder.add("box", (0.0, y, middle), (_BENCH_STAY_SHARE * length, thick, tall), "other", "metal")


def cone(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A traffic cone on its foot, with a reflecting sleeve."""
    length, width, _ = builder.placed.size
    body, sleeve = _cone()
    builder.add_mesh(body, builder.placed.size, "other", "plastic")
    builder.add_mesh(sleeve, builder.placed.size, "other", "retroreflector")
    builder.add("box", (0.0, 0.0, _CONE_FOOT / 2), (length, width, _CONE_FOOT), "other", "rubber")


def letterbox(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A letterbox on a post, its slot forward (+x)."""
    length, width, height = builder.placed.size
    middle, tall = _COLUMN_LETTERBOX
    builder.add("box", (0.0, 0.0, middle * height), (length, width, tall * height), "other", "light-paint")
    share, thick = _COLUMN_LETTERBOX_POST
    post = share * height
    builder.add("box", (0.0, 0.0, (post - EMBEDMENT) / 2), (thick, thick, post + EMBEDMENT), "other", "metal")


def hydrant(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A pillar hydrant: a column with a bonnet and two outlets."""
    length, width, height = builder.placed.size
    share, tall = _COLUMN_HYDRANT
    diameter, column = share * min(length, width), tall * height
    size = (diameter, diameter, column + EMBEDMENT)
    builder.add("cylinder", (0.0, 0.0, (column - EMBEDMENT) / 2), size, "other", "metal")
    wide, tall, middle = _COLUMN_BONNET
    size = (wide * diameter, wide * diameter, tall * height)
    builder.add("ellipsoid", (0.0, 0.0, middle * height), size, "other", "metal")
    thick, middle = _COLUMN_OUTLETS
    builder.add("box", (0.0, 0.0, middle * height), (thick, width, thick), "other", "metal")


def cabinet(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A distribution cabinet on a plinth, with an overhanging lid and doors forward (+x)."""
    length, width, height = builder.placed.size
    long, wide = _COLUMN_CABINET
    size = (long * length, wide * width, height + EMBEDMENT)
    builder.add("box", (0.0, 0.0, (height - EMBEDMENT) / 2), size, "other", "plastic")
    lid, plinth = _COLUMN_CABINET_LID, _COLUMN_CABINET_PLINTH
    builder.add("box", (0.0, 0.0, height - lid / 2), (length, width, lid), "other", "plastic")
    size = (length, width, plinth + EMBEDMENT)
    builder.add("box", (0.0, 0.0, plinth / 2 - EMBEDMENT / 2), size, "other", "concrete")


def crate(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A box of wood, cardboard or plastic, as of goods, grit or waste; its lid may stick out."""
    length, width, height = builder.placed.size
    material, share = str(rng.choice(_CRATE_MATERIALS)), rng.uniform(*_CRATE_BODY)
    at, size = (0.0, 0.0, (height - EMBEDMENT) / 2), (share * length, share * width, height + EMBEDMENT)
    builder.add("box", at, size, "other", material)
    builder.add("box", (0.0, 0.0, height - _CRATE_LID / 2), (length, width, _CRATE_LID), "other", material)


def plant_tub(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A tub with a shrub in it."""
    length, width, height = builder.placed.size
    tub = rng.uniform(*_PLANTER_TUB)
    material, density = str(rng.choice(_PLANTER_MATERIALS)), rng.uniform(*_PLANTER_DENSITY)
    builder.add("box", (0.0, 0.0, (tub - EMBEDMENT) / 2), (length, width, tub + EMBEDMENT), "other", material)
    at, size = (0.0, 0.0, height - 0.6 * (height - tub)), (length, width, 1.2 * (height - tub))
    builder.add("ellipsoid", at, size, "vegetation", extinction=density)


def cafe_table(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A table of a street cafe on one leg, with a chair at both ends."""
    length, width, height = builder.placed.size
    thick, tall, leg = _TABLE
    builder.add("cylinder", (0.0, 0.0, tall), (width, width, thick), "other", str(rng.choice(_CRATE_MATERIALS)))
    builder.add("cylinder", (0.0, 0.0, tall / 2), (leg, leg, tall), "other", "metal")
    seat, high, back = _CHAIR
    for side in (-1, 1):
        x, y = side * (length - seat) / 2, rng.uniform(-0.5, 0.5) * (width - seat)
        builder.add("box", (x, y, high), (seat, seat, back), "other", "plastic")
        builder.add("box", (x, y, high / 2), (0.8 * seat, 0.1 * seat, high), "other", "metal")
        size = (back, seat, height - high)
        builder.add("box", (side * (length - back) / 2, y, (height + high) / 2), size, "other", "plastic")


@lru_cache(maxsize=1)
def _shelter_posts() -> MeshTemplate:
    """The posts and rails of a shelter."""
    posts = [box((x, y, 0.45), (0.02, 0.06, 1.1)) for x in (-0.48, 0.0, 0.48) for y in (-0.44,)]
    posts += [box((x, 0.3, 0.45), (0.02, 0.06, 1.1)) for x in (-0.48, 0.48)]
    posts += [box((0.0, -0.44, z), (0.96, 0.03, 0.02)) for z in (0.1, 0.85)]
    return MeshTemplate.from_triangles(*join(*posts))


@lru_cache(maxsize=1)
def _wheeled_bin() -> tuple[MeshTemplate, MeshTemplate]:
    """The tub with its lid; wheels, and the foot in front."""
    corners = np.array([(1, -1), (1, 1), (-1, 1), (-1, -1)])
    rings = [np.insert(corners * (long, wide), 2, z, axis=1) for long, wide, z in _WHEELED_BIN]
    wheels = [box((-0.36, side * 0.36, 0.09), (0.22, 0.08, 0.18)) for side in (-1, 1)]
    foot = box((0.3, 0.0, 0.04), (0.1, 0.6, 0.08))
    return MeshTemplate.from_triangles(*loft(np.stack(rings))), MeshTemplate.from_triangles(*join(*wheels, foot))


@lru_cache(maxsize=1)
def _cone() -> tuple[MeshTemplate, MeshTemplate]:
    body, sleeve = lathe(np.array(_CONE), 10), lathe(np.array(_SLEEVE) * (_SLEEVE_OVER, 1.0), 10)
    return MeshTemplate.from_triangles(*body), MeshTemplate.from_triangles(*sleeve)
