"""Lamp posts, bare poles and bollards, and traffic lights, whose lenses measure 0.2 or 0.3 m (EN 12368)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, quads
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder
from lidardraft.objects.placed_object import Vector

LAMP_ARM = 1.9  # m, the longest: estimate

# Street lamps [m]: estimates.
_LAMP_LOW = 5.0  # below, most are lanterns
_LAMP_LANTERN_P = 0.6
_LAMP_LANTERN = (0.42, 0.42, 0.5)
_LAMP_ARM = (0.6, LAMP_ARM - 0.3)  # shortest and longest, to the luminaire's middle
_LAMP_ARM_WIDTH = 0.08
_LAMP_ARM_UNDER = 0.08  # the top: its middle
_LAMP_LUMINAIRE = (0.25, 0.6, 0.14)
_LAMP_LUMINAIRE_UNDER = 0.12
_LAMP_FUSE_BOX_P = 0.5
_LAMP_FUSE_BOX = (1.15, 0.7, 0.5)  # times the mast's diameter, twice; height
_LAMP_FUSE_BOX_MIDDLE = 0.6

# Bare poles and bollards [m]: estimates.
_POLE_WOODEN = (5.0, 0.2)  # higher and thicker than this
_POLE_CONCRETE = 0.25  # thicker than this
_POLE_BOLLARD = 1.3  # lower than this
_POLE_BAND_P = 0.5
_POLE_BAND = (1.04, 0.1, 0.85)  # of the diameter; height; middle, of the pole's height

# Signals [m] with lenses of 0.2 m; those wider than `_LIGHT_HANGING` hang from a mast arm. Estimates.
_LIGHT_HANGING = 1.0
_LIGHT_POST = 0.11
_LIGHT_POST_OVER = 0.1  # over the housing's lower edge
_LIGHT_MAST = 0.2
_LIGHT_MAST_INSET = 0.15  # its middle, from the right end
_LIGHT_ARM = 0.14
_LIGHT_ARM_SHORTER = 0.1
_LIGHT_ARM_ASIDE = 0.05
_LIGHT_ARM_UNDER = 0.08
_LIGHT_HOUSING = (0.25, 0.32, 0.95)
_LIGHT_HOUSING_INSET = 0.2  # its middle, from the left end
_LIGHT_AHEAD = 0.2
_LIGHT_LOW = 2.3  # height of the signal on the mast


def lamp(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A lamp post: with an arm to its left (+y) and a luminaire, or, if it is low, a lantern on its top."""
    diameter, _, height = builder.placed.size
    add_post(builder, diameter, height)
    if height < _LAMP_LOW and rng.random() < _LAMP_LANTERN_P:
        builder.add("cylinder", (0.0, 0.0, height - _LAMP_LANTERN[2] / 2), _LAMP_LANTERN, "pole", "plastic")
        return
    arm = rng.uniform(*_LAMP_ARM)
    size = (_LAMP_ARM_WIDTH, arm, _LAMP_ARM_WIDTH)
    builder.add("box", (0.0, arm / 2, height - _LAMP_ARM_UNDER), size, "pole")
    builder.add("box", (0.0, arm, height - _LAMP_LUMINAIRE_UNDER), _LAMP_LUMINAIRE, "pole", "plastic")
    if rng.random() < _LAMP_FUSE_BOX_P:
        deep, wide, tall = _LAMP_FUSE_BOX
        size = (deep * diameter, wide * diameter, tall)
        builder.add("box", (0.0, 0.0, _LAMP_FUSE_BOX_MIDDLE), size, "pole", "metal")


def pole(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bare pole, a wooden one if it is high and thick, or a bollard, some with a reflecting band."""
    diameter, _, height = builder.placed.size
    high, thick = _POLE_WOODEN
    wooden = height > high and diameter > thick
    add_post(builder, diameter, height, "wood" if wooden else "concrete" if diameter > _POLE_CONCRETE else "metal")
    if height < _POLE_BOLLARD and rng.random() < _POLE_BAND_P:
        share, tall, middle = _POLE_BAND
        size = (share * diameter, share * diameter, tall)
        builder.add("cylinder", (0.0, 0.0, middle * height), size, "pole", "retroreflector")


def traffic_light(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A housing with three lenses from `clearance` to the top, facing forward, on a post.

    A housing wider than 1 m hangs from a mast arm: the post is at the right end (-y) of its width, and the arm carries
    a signal at the left end. Another signal is on the post.
    """
    depth, width, height = builder.placed.size
    tall = height - builder.placed.clearance
    if width <= _LIGHT_HANGING:
        add_post(builder, _LIGHT_POST, builder.placed.clearance + _LIGHT_POST_OVER)
        _add_signal(builder, 0.0, builder.placed.clearance, (depth, width, tall))
        return
    mast = -width / 2 + _LIGHT_MAST_INSET
    add_post(builder, _LIGHT_MAST, height, y=mast)
    arm = (_LIGHT_ARM, width - _LIGHT_ARM_SHORTER, _LIGHT_ARM)
    builder.add("box", (0.0, _LIGHT_ARM_ASIDE, height - _LIGHT_ARM_UNDER), arm, "pole")
    deep, wide, most = _LIGHT_HOUSING
    housing = (deep, wide, min(tall, most))
    _add_signal(builder, width / 2 - _LIGHT_HOUSING_INSET, height - housing[2], housing, ahead=_LIGHT_AHEAD)
    _add_signal(builder, mast, _LIGHT_LOW, _LIGHT_HOUSING, ahead=_LIGHT_AHEAD)


def add_post(
    builder: ObjectBuilder, diameter: float, height: float, material: str | None = None, *, y: float = 0.0
) -> None:
    """Add a round post that reaches a little into the ground."""
    size = (diameter, diameter, height + EMBEDMENT)
    builder.add("cylinder", (0.0, y, (height - EMBEDMENT) / 2), size, "pole", material)


def _add_signal(builder: ObjectBuilder, y: float, bottom: float, size: Vector, *, ahead: float = 0.0) -> None:
    """Add a housing and its lenses."""
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
