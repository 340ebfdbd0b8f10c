"""Riders of bicycles and motorcycles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.human_body import SEGMENTS, bent_joint, limb, torso
from lidardraft.objects.mesh import MeshTemplate, box, join
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.pedestrians import sample_clothes
from lidardraft.objects.placed_object import Vector

_PHASES = 8  # of the cranks
_CRANK = 0.17  # m, their length: the usual one
_HELMET_P = 0.4  # of cyclists; an estimate


@dataclass(frozen=True, slots=True)
class Seat:
    """The seat of a rider [m]: the middle of the hip, of the pedals and of the handlebar.

    `y` of `foot` and `hand` is half the distance between both.
    """

    hip: Vector
    foot: Vector
    hand: Vector


# Places and extents of a rider, in shares of the stature without a unit: estimates.
_FIGURE_HEAD = 0.14
_FIGURE_HELMET = 0.04  # m, the height of a motorcyclist's helmet over the head
_FIGURE_LOWERED = 0.32  # the drop of the head, per 1 - cos(lean)
_FIGURE_HEAD_FORWARD = 0.02  # m
_FIGURE_HEAD_OVER = 0.62  # of the head, from the neck to its middle
_FIGURE_HEAD_WIDTH = 0.8  # of its height
_FIGURE_NECK = 0.02
_FIGURE_NECK_LENGTH = 0.05
_FIGURE_HIP_ASIDE = 0.05
_FIGURE_ANKLE = (-0.04, 0.08)  # m, behind and over the pedal
_FIGURE_SHOE = (0.26, 0.09, 0.08)  # m
_FIGURE_SHOE_AT = (0.02, 0.04)  # m, before and over the pedal
_FIGURE_SHOULDER = (0.105, -0.02)  # aside and over the neck
_FIGURE_ARM_DIAMETERS = (0.062, 0.05, 0.042)  # at shoulder, elbow and hand


def add_rider(builder: ObjectBuilder, seat: Seat, lean: float, rng: np.random.Generator, *, pedals: bool) -> None:
    """Add a rider whose torso leans forward by `lean` [rad]. One who `pedals` may wear a helmet, others always do."""
    height = builder.placed.size[2]
    stature = (height - seat.hip[2]) / (1 - SEGMENTS.hip - _FIGURE_LOWERED * (1 - math.cos(lean)))
    stature = round(stature, 1)  # so that riders share their meshes
    phase = int(rng.integers(_PHASES)) if pedals else None
    legs, top, neck = _rider(seat, stature, lean, phase)
    builder.add_mesh(legs, (1.0, 1.0, 1.0), "rider", sample_clothes(rng))
    builder.add_mesh(top, (1.0, 1.0, 1.0), "rider", sample_clothes(rng))
    head = _FIGURE_HEAD * stature + (0.0 if pedals else _FIGURE_HELMET)
    up = min(neck[2] + _FIGURE_HEAD_OVER * head, height - head / 2)
    covered = not pedals or rng.random() < _HELMET_P
    builder.add(
        "ellipsoid", (neck[0] + _FIGURE_HEAD_FORWARD, 0.0, up), (head, _FIGURE_HEAD_WIDTH * head, head), "rider",
        "light-paint" if covered else "skin",
    )  # fmt: skip


@lru_cache(maxsize=256)
def _rider(seat: Seat, stature: float, lean: float, phase: int | None) -> tuple[MeshTemplate, MeshTemplate, np.ndarray]:
    """Legs, torso with arms [m], and the end of the neck; without a phase both feet are on their rests."""
    legs, arms = [], []
    up = np.array([math.sin(lean), 0.0, math.cos(lean)])
    neck = np.array(seat.hip) + (SEGMENTS.torso + _FIGURE_NECK) * stature * up
    leg_diameters = tuple(share * stature for share in SEGMENTS.leg_diameters)
    arm_diameters = tuple(share * stature for share in _FIGURE_ARM_DIAMETERS)
    for side in (-1, 1):
        crank = 0.0 if phase is None else _CRANK
        at = 2 * math.pi * (phase or 0) / _PHASES + (math.pi if side > 0 else 0.0)
        x, y, z = seat.foot
        pedal = np.array([x + crank * math.cos(at), side * y, z + crank * math.sin(at)])
        hip = np.array([seat.hip[0], side * _FIGURE_HIP_ASIDE * stature, seat.hip[2]])
        behind, over = _FIGURE_ANKLE
        ankle = pedal + np.array([behind, 0.0, over])
        knee = bent_joint(hip, ankle, SEGMENTS.thigh * stature, SEGMENTS.shank * stature, knee=True)
        legs.append(limb(np.stack([hip, knee, ankle]), leg_diameters))
        before, over = _FIGURE_SHOE_AT
        shoe = (float(pedal[0]) + before, float(pedal[1]), float(pedal[2]) + over)
        legs.append(box(shoe, _FIGURE_SHOE))
        aside, over = _FIGURE_SHOULDER
        shoulder = neck + stature * np.array([0.0, side * aside, over])
        hand = np.array([seat.hand[0], side * seat.hand[1], seat.hand[2]])
        elbow = bent_joint(shoulder, hand, SEGMENTS.upper_arm * stature, SEGMENTS.forearm * stature, knee=False)
        arms.append(limb(np.stack([shoulder, elbow, hand]), arm_diameters))
    trunk = _leaning_torso(np.array(seat.hip), stature, lean)
    end = neck + _FIGURE_NECK_LENGTH * stature * up
    return MeshTemplate.from_triangles(*join(*legs)), MeshTemplate.from_triangles(*join(trunk, *arms)), end


def _leaning_torso(hip: np.ndarray, stature: float, lean: float) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = torso(np.zeros(3), 0.0, coat=False)
    turned = np.stack(
        [
            vertices[:, 0] * math.cos(lean) + vertices[:, 2] * math.sin(lean),
            vertices[:, 1],
            vertices[:, 2] * math.cos(lean) - vertices[:, 0] * math.sin(lean),
        ],
        axis=1,
    )
    return turned * stature + hip, faces
