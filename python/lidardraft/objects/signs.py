"""Signs of all sizes: on one post or two, billboards, and sign bridges over a road.

Signs have the sizes of the administrative rule of the German road code (VwV-StVO, on sections 39 to 43): discs of 0.42,
0.60 and 0.75 m, triangles of 0.63, 0.90 and 1.26 m, squares of 0.42, 0.60 and 0.84 m; clearance over a road is 4.5 m at
least.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, box, join, tube
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder, sample_name
from lidardraft.objects.poles import add_post

GANTRY_POST = 0.5  # m, the width of the posts of a gantry: an estimate

# Signs [m]: posts are the tubes of 76 mm of DIN EN 12767; shares are estimates.
_SIGN_POST = 0.076
_SIGN_POST_LOWER = 0.05  # than the sign's upper edge
_SIGN_WIDE = 1.5  # a wider sign is a board on two posts
_SIGN_WIDE_POST = 0.1
_SIGN_WIDE_POSTS_AT = 0.35  # share of the width, from the middle
_SIGN_TWO_PLATES = (1.3, 0.7)  # times as high as wide; the probability of two plates then
_SIGN_PLATE_GAP = 0.03
_SIGN_SQUARE = (0.8, 1.25)  # height over width: the range for a disc
_SIGN_AHEAD = 0.05  # of a plate, before the post's middle
_SIGN_THICKNESS = 0.015

# Posters of 18/1 (3.56 x 2.52 m) on posts [m]: estimates.
_BILLBOARD_NARROW = 2.0  # below, one post
_BILLBOARD_HIGH = 2.0  # above this clearance, one post
_BILLBOARD_POSTS_AT = 0.35  # share of the width, from the middle
_BILLBOARD_POST = (0.16, 0.2)
_BILLBOARD_POST_INTO = 0.1  # the board
_BILLBOARD_DEEPEST = 0.3
_BILLBOARD_FACE = (0.02, 0.94, 0.9)  # thickness; shares of width and height
_BILLBOARD_BOTH_SIDES_P = 0.5

# Sign bridges [m]: estimates.
_GANTRY_POST_DEPTH = 0.5  # at most
_GANTRY_TRUSS = (0.8, 1.2)  # depth and height at most
_GANTRY_PER_BOARD = 4.5
_GANTRY_BOARD_P = 0.75  # of those beside the middle one
_GANTRY_BOARD_SHARE = 0.8  # of the width for it
_GANTRY_BOARD_HEIGHT = (0.75, 1.0)  # shares of the height over the clearance
_GANTRY_BOARD_AHEAD = 0.02  # of the truss

# Shapes of single plates, and their frequencies: estimates.
_PLATES = {"disc": 0.4, "triangle": 0.2, "square": 0.36, "octagon": 0.04}
_UPPER_PLATES = ("disc", "triangle")  # of two, one over the other
# Corners of a plate, and the angle of the first in shares of that between two.
_OUTLINES = {"disc": (12, 0.5), "triangle": (3, 0.75), "square": (4, 0.5), "octagon": (8, 0.5)}


def sign(builder: ObjectBuilder, rng: np.random.Generator, *, square: bool = False) -> None:
    """A plate from `clearance` to the top on a post. Its face, to the front (+x), is retroreflective; its back is grey.

    It fills its extents if it is to be `square`; else it may be a disc, a triangle, an octagon, or two plates.
    """
    _, width, height = builder.placed.size
    tall = height - builder.placed.clearance
    if width > _SIGN_WIDE:
        for side in (-_SIGN_WIDE_POSTS_AT, _SIGN_WIDE_POSTS_AT):
            add_post(builder, _SIGN_WIDE_POST, height, y=side * width)
        _add_plate(builder, "square", 0.0, (width, tall), builder.placed.clearance)
        return
    add_post(builder, _SIGN_POST, height - _SIGN_POST_LOWER)
    slender, often = _SIGN_TWO_PLATES
    if not square and tall > slender * width and rng.random() < often:
        _add_plate(builder, str(rng.choice(_UPPER_PLATES)), 0.0, (width, width), height - width)
        _add_plate(builder, "square", 0.0, (width, tall - width - _SIGN_PLATE_GAP), builder.placed.clearance)
    else:
        low, high = _SIGN_SQUARE
        outline = sample_name(_PLATES, rng) if not square and low < tall / width < high else "square"
        _add_plate(builder, outline, 0.0, (width, tall), builder.placed.clearance)


def billboard(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A poster from `clearance` to the top, facing forward (+x), on one post or two."""
    depth, width, height = builder.placed.size
    tall = height - builder.placed.clearance
    top = builder.placed.clearance + _BILLBOARD_POST_INTO
    for y in billboard_posts(width, builder.placed.clearance):
        size = (*_BILLBOARD_POST, top + EMBEDMENT)
        builder.add("box", (0.0, y, (top - EMBEDMENT) / 2), size, "other", "metal")
    deep, middle = min(depth, _BILLBOARD_DEEPEST), builder.placed.clearance + tall / 2
    builder.add("box", (0.0, 0.0, middle), (deep, width, tall), "other", "metal")
    thick, wide, high = _BILLBOARD_FACE
    for side in (-1, 1) if rng.random() < _BILLBOARD_BOTH_SIDES_P else (1,):
        at = (side * (deep / 2), 0.0, middle)
        builder.add("box", at, (thick, wide * width, high * tall), "other", "plastic")


def billboard_posts(width: float, clearance: float) -> tuple[float, ...]:
    """The places of a billboard's posts across its width [m]: narrow and high ones have one."""
    aside = _BILLBOARD_POSTS_AT * width
    single = width < _BILLBOARD_NARROW or clearance > _BILLBOARD_HIGH
    return (0.0,) if single else (-aside, aside)


def gantry(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A sign bridge over a road along x: posts at the ends of its width, a truss, boards that face forward (+x).

    `clearance` is the height under it.
    """
    depth, width, height = builder.placed.size
    tall = height - builder.placed.clearance
    for side in (-1, 1):
        y = side * (width - GANTRY_POST) / 2
        size = (min(depth, _GANTRY_POST_DEPTH), GANTRY_POST, height + EMBEDMENT)
        builder.add("box", (0.0, y, (height - EMBEDMENT) / 2), size, "pole")
    deep, high = min(depth, _GANTRY_TRUSS[0]), min(tall, _GANTRY_TRUSS[1])
    builder.add_mesh(_truss(), (deep, width, high), "pole", "metal", at=(0, 0, builder.placed.clearance))
    count = max(1, round(width / _GANTRY_PER_BOARD))
    room = width - 2 * GANTRY_POST
    for number in range(count):
        if rng.random() < _GANTRY_BOARD_P or number == count // 2:
            board = (_GANTRY_BOARD_SHARE * room / count, tall * rng.uniform(*_GANTRY_BOARD_HEIGHT))
            y = (number + 0.5 - count / 2) * room / count
            _add_plate(builder, "square", y, board, builder.placed.clearance, ahead=deep / 2 + _GANTRY_BOARD_AHEAD)


def _add_plate(
    builder: ObjectBuilder,
    outline: str,
    y: float,
    size: tuple[float, float],
    bottom: float,
    *,
    ahead: float = _SIGN_AHEAD,
) -> None:
    """Add a plate of that width and height that faces forward, and its back."""
    width, height = size
    for x, material in ((ahead + _SIGN_THICKNESS, "retroreflector"), (ahead, "sign-back")):
        at = (x, y, bottom + height / 2)
        builder.add_mesh(_plate(outline), (1.0, width, height), "traffic-sign", material, at=at)


@lru_cache(maxsize=8)
def _plate(outline: str) -> MeshTemplate:
    """A flat plate across x in the unit square."""
    sides, first = _OUTLINES[outline]
    angle = 2 * np.pi * (np.arange(sides) + first) / sides
    ring = np.stack([np.zeros(sides), np.cos(angle), np.sin(angle)], axis=1)
    low, high = ring.min(axis=0), ring.max(axis=0)
    ring = (ring - (low + high) / 2) / np.where(high > low, high - low, 1.0)
    fan = np.stack([np.zeros(sides - 2, dtype=np.int64), np.arange(1, sides - 1), np.arange(2, sides)], axis=1)
    return MeshTemplate.from_triangles(ring, fan)


@lru_cache(maxsize=1)
def _truss() -> MeshTemplate:
    """Four chords and the diagonals between them, in shares of depth, width and height over the clearance."""
    chords = [box((x, 0.0, z), (0.16, 1.0, 0.12)) for x in (-0.42, 0.42) for z in (0.08, 0.92)]
    steps = np.linspace(-0.48, 0.48, 11)
    bars = [
        tube((x, float(a), z), (x, float(b), 1.0 - z), (0.008, 0.008), 3)
        for x in (-0.42, 0.42)
        for a, b, z in zip(steps[:-1], steps[1:], [0.1, 0.9] * 5, strict=True)
    ]
    return MeshTemplate.from_triangles(*join(*chords, *bars))
