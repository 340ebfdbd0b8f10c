"""The human body: lengths and diameters of its segments, and the meshes of its limbs and torso.

Segments are shares of the stature: Winter, Biomechanics and Motor Control of Human Movement, 4th ed., figure 4.1 (ankle
0.039, knee 0.285, hip 0.530, shoulder 0.818, upper arm 0.186, forearm 0.146 and hand 0.108, foot 0.152, shoulders 0.259
wide); diameters after ISO 7250 / DIN 33402-2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.objects.mesh import Triangles, loft


@dataclass(frozen=True, slots=True)
class Segments:
    """Lengths, heights and diameters in shares of the stature."""

    ankle: float = 0.039
    thigh: float = 0.245
    shank: float = 0.246
    hip: float = 0.530
    torso: float = 0.818 - 0.530
    upper_arm: float = 0.186
    forearm: float = 0.20  # to the middle of the hand
    leg_diameters: tuple[float, float, float] = (0.105, 0.078, 0.055)  # at hip, knee and ankle
    arm_diameters: tuple[float, float, float] = (0.066, 0.056, 0.044)  # at shoulder, elbow and hand, with sleeves
    width: float = 0.28  # over the elbows


SEGMENTS = Segments()
# Rings of a torso [7], in shares of the stature: heights over the hip, and half widths to the side and to the front.
_RING_HEIGHTS = (-0.045, 0.0, 0.10, 0.22, 0.285, 0.31, 0.345)
_RING_HALF_WIDTHS = (0.078, 0.094, 0.08, 0.102, 0.105, 0.05, 0.032)
_RING_HALF_DEPTHS = (0.055, 0.072, 0.066, 0.074, 0.058, 0.04, 0.034)
_COAT_HEM = (-0.15, 0.098, 0.085)  # the lowest of them under a coat
_MOST_REACH = 0.98  # of two segments: joints are never quite straight
_KNEE_BENDS, _ELBOW_BENDS = (1.0, 0.0, 0.4), (0.0, 0.0, -1.0)  # directions: forward and up, down


def torso(hip: np.ndarray, lean: float, *, coat: bool) -> Triangles:
    """A torso over the hip, from the seat (a coat's hem) to the neck, moved forward by `lean` per height."""
    z, half_y, half_x = (np.array(row) for row in (_RING_HEIGHTS, _RING_HALF_WIDTHS, _RING_HALF_DEPTHS))
    if coat:
        z[0], half_y[0], half_x[0] = _COAT_HEM
    angle = 2 * np.pi * np.arange(8) / 8
    rings = np.stack(
        [
            half_x[:, None] * np.cos(angle) + lean * z[:, None],
            half_y[:, None] * np.sin(angle),
            np.broadcast_to(z[:, None], (len(z), 8)),
        ],
        axis=2,
    )
    return loft(rings + hip)


def limb(joints: np.ndarray, diameters: tuple[float, ...], sides: int = 6) -> Triangles:
    """A round limb through joints [n, 3], with its diameter at each."""
    along = np.gradient(joints, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, (0.0, 1.0, 0.0))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = np.cross(along, across)
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = across[:, None] * np.cos(angle)[:, None] + other[:, None] * np.sin(angle)[:, None]
    return loft(joints[:, None] + ring * (np.array(diameters) / 2)[:, None, None])


def hanging(angle: float) -> np.ndarray:
    """The direction of a hanging segment, turned forward by an angle [rad]."""
    return np.array([math.sin(angle), 0.0, -math.cos(angle)])


def bent_joint(start: np.ndarray, end: np.ndarray, upper: float, lower: float, *, knee: bool) -> np.ndarray:
    """The joint of two segments between two points: a knee bends forward and up, an elbow down."""
    reach = end - start
    distance = min(float(np.linalg.norm(reach)), _MOST_REACH * (upper + lower))
    along = reach / np.linalg.norm(reach)
    share = (upper**2 - lower**2 + distance**2) / (2 * distance)
    off = math.sqrt(max(upper**2 - share**2, 0.0))
    bend = np.array(_KNEE_BENDS if knee else _ELBOW_BENDS)
    bend = bend - along * (bend @ along)
    joint: np.ndarray = start + share * along + off * bend / np.linalg.norm(bend)
    return joint
