"""Lamp posts, bare poles and bollards, and traffic lights, whose lenses measure 0.2 or 0.3 m (EN 12368)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, quads
from lidardraft.objects.object_builder import EMBEDMENT, ObjectBuilder
from lidardraft.objects.placed_object import Vector

LAMP_ARM = 1.9  # m, the longest: estimate


@dataclass(frozen=True, slots=True)
class _Lamp:
    """Street lamps [m]: estimates."""

    low: float = 5.0  # below, most are lanterns
    lantern_p: float = 0.6
    lantern: Vector = (0.42, 0.42, 0.5)
    arm: tuple[float, float] = (0.6, LAMP_ARM - 0.3)  # shortest and longest, to the luminaire's middle
    arm_width: float = 0.08
    arm_under: float = 0.08  # the top, its middle
    luminaire: Vector = (0.25, 0.6, 0.14)
    luminaire_under: float = 0.12
    fuse_box_p: float = 0.5
    fuse_box: tuple[float, float, float] = (1.15, 0.7, 0.5)  # times the mast's diameter, twice; height
    fuse_box_middle: float = 0.6


@dataclass(frozen=True, slots=True)
class _Pole:
    """Bare poles and bollards [m]: estimates."""

    wooden: tuple[float, float] = (5.0, 0.2)  # higher and thicker than this
    concrete: float = 0.25  # thicker than this
    bollard: float = 1.3  # lower than this
    band_p: float = 0.5
    band: tuple[float, float, float] = (1.04, 0.1, 0.85)  # of the diameter; height; middle, of the pole's height


@dataclass(frozen=True, slots=True)
class _TrafficLight:
    """Signals [m] with lenses of 0.2 m; those wider than `hanging` hang from a mast arm. Estimates."""

    hanging: float = 1.0
    post: float = 0.11
    post_over: float = 0.1  # over the housing's lower edge
    mast: float = 0.2
    mast_inset: float = 0.15  # its middle, from the right end
    arm: float = 0.14
    arm_shorter: float = 0.1
    arm_aside: float = 0.05
    arm_under: float = 0.08
    housing: Vector = (0.25, 0.32, 0.95)
    housing_inset: float = 0.2  # its middle, from the left end
    ahead: float = 0.2
    low: float = 2.3  # height of the signal on the mast


_LAMP, _POLE, _LIGHT = _Lamp(), _Pole(), _TrafficLight()


def lamp(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A lamp post: with an arm to its left (+y) and a luminaire, or, if it is low, a lantern on its top."""
    diameter, _, height = builder.placed.size
    add_post(builder, diameter, height)
    if height < _LAMP.low and rng.random() < _LAMP.lantern_p:
        builder.add("cylinder", (0.0, 0.0, height - _LAMP.lantern[2] / 2), _LAMP.lantern, "pole", "plastic")
        return
    arm = rng.uniform(*_LAMP.arm)
    size = (_LAMP.arm_width, arm, _LAMP.arm_width)
    builder.add("box", (0.0, arm / 2, height - _LAMP.arm_under), size, "pole")
    builder.add("box", (0.0, arm, height - _LAMP.luminaire_under), _LAMP.luminaire, "pole", "plastic")
    if rng.random() < _LAMP.fuse_box_p:
        deep, wide, tall = _LAMP.fuse_box
        size = (deep * diameter, wide * diameter, tall)
        builder.add("box", (0.0, 0.0, _LAMP.fuse_box_middle), size, "pole", "metal")


def pole(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bare pole, a wooden one if it is high and thick, or a bollard, some with a reflecting band."""
    diameter, _, height = builder.placed.size
    high, thick = _POLE.wooden
    wooden = height > high and diameter > thick
    add_post(builder, diameter, height, "wood" if wooden else "concrete" if diameter > _POLE.concrete else "metal")
    if height < _POLE.bollard and rng.random() < _POLE.band_p:
        share, tall, middle = _POLE.band
        size = (share * diameter, share * diameter, tall)
        builder.add("cylinder", (0.0, 0.0, middle * height), size, "pole", "retroreflector")


def traffic_light(builder: ObjectBuilder, _rng: np.random.Generator) -> None:
    """A housing with three lenses from `clearance` to the top, facing forward, on a post.

    One wider than 1 m hangs from a mast arm: the post stands at the right end (-y) of its width, the arm reaches to the
    left end and carries a signal; another is on the post.
    """
    depth, width, height = builder.placed.size
    tall = height - builder.placed.clearance
    if width <= _LIGHT.hanging:
        add_post(builder, _LIGHT.post, builder.placed.clearance + _LIGHT.post_over)
        _add_signal(builder, 0.0, builder.placed.clearance, (depth, width, tall))
        return
    mast = -width / 2 + _LIGHT.mast_inset
    add_post(builder, _LIGHT.mast, height, y=mast)
    arm = (_LIGHT.arm, width - _LIGHT.arm_shorter, _LIGHT.arm)
    builder.add("box", (0.0, _LIGHT.arm_aside, height - _LIGHT.arm_under), arm, "pole")
    deep, wide, most = _LIGHT.housing
    housing = (deep, wide, min(tall, most))
    _add_signal(builder, width / 2 - _LIGHT.housing_inset, height - housing[2], housing, ahead=_LIGHT.ahead)
    _add_signal(builder, mast, _LIGHT.low, _LIGHT.housing, ahead=_LIGHT.ahead)


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
