"""Pedestrians, standing or in a gait."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from lidardraft.objects.human_body import SEGMENTS, hanging, limb, torso
from lidardraft.objects.mesh import MeshTemplate, Triangles, box, join
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import Vector

_STANDING = 0.3  # m, the longest footprint of a standing person
_PHASES = 8  # of a gait
_HABITS, _HOLDING, _COATED = 4, 1, 2  # one in four holds something in front of the chest, one in four wears a coat

# Gaits: estimates, except the knee, which bends by 60 degrees in a brisk walk. The reach of the feet beyond the ankles,
# and the stride from one step to the next longer one, of the stature.
_GAIT_FEET = 0.17
_GAIT_STRIDE = 0.06
_GAIT_SWINGS: tuple[float, ...] = (0.0, 0.13, 0.20, 0.27, 0.34)  # rad, of the thigh, standing and of four steps
_GAIT_FORWARD = 0.35  # of the swing: the thigh goes further forward than back
_GAIT_STANDING_KNEE = 0.03  # rad
_GAIT_KNEE = (0.12, 2.6)  # rad; rad per rad of swing while the leg swings forward
_GAIT_ARM = 0.8  # of the swing of the thigh
_GAIT_ELBOW = (0.25, 0.3)  # rad; rad per rad of swing
_GAIT_HOLDING_ELBOW = 2.1  # rad

# Places and extents in shares of the stature, estimates in addition to `SEGMENTS`.
_FIGURE_HIP_ASIDE = 0.052
_FIGURE_HIP_OVER = 0.02  # the start of the leg over the hip's joint
_FIGURE_SHOE = (0.145, 0.052, 0.046)
_FIGURE_SHOE_AT = (0.035, 0.008, -0.016)  # its middle from the ankle
_FIGURE_SHOULDER_ASIDE = 0.108
_FIGURE_SHOULDER_UNDER = 0.012
_FIGURE_ELBOW_ASIDE = 0.016
_FIGURE_HAND_INSIDE = 0.004
_FIGURE_HOLDING_HAND_INSIDE = 0.05
_FIGURE_LEAN = 0.04
_FIGURE_HEAD = 0.13
_FIGURE_HEAD_FORWARD = 0.012
_FIGURE_HEAD_SHARES = (0.85, 0.7)  # depth and width of the head, of its height

# Luggage, in shares of the stature (and, `_LUGGAGE_BAG_ASIDE`, of the width): estimates.
_LUGGAGE_RUCKSACK_P = 0.15
_LUGGAGE_BAG_OR_RUCKSACK_P = 0.32
_LUGGAGE_RUCKSACK = (0.10, 0.16, 0.24)
_LUGGAGE_RUCKSACK_AT = (0.105, 0.70)  # behind the middle; over the ground
_LUGGAGE_BAG = (0.20, 0.06, 0.17)
_LUGGAGE_STRAP = (0.012, 0.012, 0.09)
_LUGGAGE_BAG_ASIDE = 0.44
_LUGGAGE_BAG_UP = 0.30
_LUGGAGE_STRAP_UP = 0.42


_CHILD = 1.5  # m: below, the size of the head is between a child's and an adult's
_CHILD_HEAD = 0.2  # m
_DARK_CLOTHES_P = 0.5  # an estimate


def person(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A person with the stride as the length of the footprint; standing if it is `_STANDING` or less."""
    length, width, height = builder.placed.size
    longest = len(_GAIT_SWINGS) - 1
    step = 0 if length <= _STANDING else int(np.clip((length / height - _GAIT_FEET) / _GAIT_STRIDE, 0, longest))
    phase, habit = int(rng.integers(_PHASES)), int(rng.integers(_HABITS))
    legs, top = _figure(step, phase, habit)
    scale = (height, height * width / (SEGMENTS.width * height), height)
    builder.add_mesh(legs, scale, "person", sample_clothes(rng))
    builder.add_mesh(top, scale, "person", sample_clothes(rng))
    head = _FIGURE_HEAD * height if height > _CHILD else 0.5 * (_FIGURE_HEAD * height + _CHILD_HEAD)
    deep, wide = _FIGURE_HEAD_SHARES
    at = (_FIGURE_HEAD_FORWARD * height, 0.0, height - head / 2)
    builder.add("ellipsoid", at, (deep * head, wide * head, head), "person", "skin")
    _add_luggage(builder, habit, rng)


def sample_clothes(rng: np.random.Generator) -> str:
    """The material of a garment."""
    return "dark-cloth" if rng.random() < _DARK_CLOTHES_P else "cloth"


def _add_luggage(builder: ObjectBuilder, habit: int, rng: np.random.Generator) -> None:
    """A rucksack, a bag in one hand, or nothing."""
    _, width, height = builder.placed.size

    def scaled(size: Vector) -> Vector:
        return size[0] * height, size[1] * height, size[2] * height

    pick = rng.random()
    if pick < _LUGGAGE_RUCKSACK_P:
        behind, up = _LUGGAGE_RUCKSACK_AT
        at = (-behind * height, 0.0, up * height)
        builder.add("box", at, scaled(_LUGGAGE_RUCKSACK), "person", sample_clothes(rng))
    elif pick < _LUGGAGE_BAG_OR_RUCKSACK_P and habit != _HOLDING:
        y = float(rng.choice((-1.0, 1.0))) * _LUGGAGE_BAG_ASIDE * width
        builder.add("box", (0.0, y, _LUGGAGE_BAG_UP * height), scaled(_LUGGAGE_BAG), "person", sample_clothes(rng))
        at = (0.0, y, _LUGGAGE_STRAP_UP * height)
        builder.add("cylinder", at, scaled(_LUGGAGE_STRAP), "person", "dark-cloth")


@lru_cache(maxsize=256)
def _figure(step: int, phase: int, habit: int) -> tuple[MeshTemplate, MeshTemplate]:
    """Legs, and torso with arms, at a phase of the gait and stature 1; step 0 stands."""
    swing = _GAIT_SWINGS[step]
    angle = 2 * math.pi * phase / _PHASES
    sides = ((-1, angle), (1, angle + math.pi))  # with the phase of the leg; the opposite arm has the same
    legs, hips = _legs(swing, sides)
    arms = _arms(swing, ((-1, angle + math.pi), (1, angle)), hips, holding=habit == _HOLDING)
    trunk = torso(np.array([0.0, 0.0, hips]), _FIGURE_LEAN, coat=habit == _COATED)
    return MeshTemplate.from_triangles(*join(*legs)), MeshTemplate.from_triangles(*join(trunk, *arms))


def _legs(swing: float, sides: tuple[tuple[int, float], ...]) -> tuple[list[Triangles], float]:
    """Legs and shoes of both sides at their phases, the lower foot on the ground, and the height of the hip."""
    straight, bent = _GAIT_KNEE
    joints, lowest = [], 1.0
    for side, at in sides:
        hip = np.array([0.0, side * _FIGURE_HIP_ASIDE, 0.0])
        thigh = swing * math.sin(at) + _GAIT_FORWARD * swing
        shank = thigh - (straight + bent * swing * max(0.0, math.cos(at)) if swing else _GAIT_STANDING_KNEE)
        knee = hip + SEGMENTS.thigh * hanging(thigh)
        ankle = knee + SEGMENTS.shank * hanging(shank)
        joints.append((hip, knee, ankle, side))
        lowest = min(lowest, float(ankle[2]))
    rise = np.array([0.0, 0.0, SEGMENTS.ankle - lowest])
    legs = []
    for hip, knee, ankle, side in joints:
        top = hip + _FIGURE_HIP_OVER * np.array([0, 0, 1])
        legs.append(limb(np.stack([top, knee, ankle]) + rise, SEGMENTS.leg_diameters))
        x, y, z = _FIGURE_SHOE_AT
        foot = ankle + rise + (x, side * y, z)
        legs.append(box(tuple(foot.tolist()), _FIGURE_SHOE))
    return legs, float(rise[2])


def _arms(swing: float, sides: tuple[tuple[int, float], ...], hips: float, *, holding: bool) -> list[Triangles]:
    """Arms of both sides at their phases; the left one may hold something in front of the chest."""
    bent, more = _GAIT_ELBOW
    arms = []
    for side, at in sides:
        holds = holding and side > 0
        shoulder = np.array([0.0, side * _FIGURE_SHOULDER_ASIDE, hips + SEGMENTS.torso - _FIGURE_SHOULDER_UNDER])
        upper = _GAIT_ARM * swing * math.sin(at)
        lower = upper + _GAIT_HOLDING_ELBOW if holds else upper + bent + (more * swing if swing else 0.0)
        elbow = shoulder + SEGMENTS.upper_arm * hanging(upper) + (0.0, side * _FIGURE_ELBOW_ASIDE, 0.0)
        inside = _FIGURE_HOLDING_HAND_INSIDE if holds else _FIGURE_HAND_INSIDE
        hand = elbow + SEGMENTS.forearm * hanging(lower) - (0.0, side * inside, 0.0)
        arms.append(limb(np.stack([shoulder, elbow, hand]), SEGMENTS.arm_diameters))
    return arms
