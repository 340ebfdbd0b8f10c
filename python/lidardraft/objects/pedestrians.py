"""People: on foot, standing or in a gait, and on two wheels.

Segments are shares of the stature: Winter, Biomechanics and Motor Control of Human Movement, 4th ed., figure 4.1 (ankle
0.039, knee 0.285, hip 0.530, shoulder 0.818, upper arm 0.186, forearm 0.146 and hand 0.108, foot 0.152, shoulders 0.259
wide); diameters after ISO 7250 / DIN 33402-2.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import Triangles, box, join, loft
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.scene.layout import Primitive

_ANKLE, _THIGH, _SHANK = 0.039, 0.245, 0.246
_UPPER_ARM, _FOREARM = 0.186, 0.20  # to the middle of the hand
_TORSO = 0.818 - 0.530
_WIDTH = 0.28  # shares of the stature over the elbows
_PHASES = 8
_STANDING = 0.3  # m, the longest footprint of one who stands


def person(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A person whose footprint's length is that of the stride; up to `_STANDING` he or she stands."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    # the feet reach half a foot and the heel beyond the ankles
    step = 0 if length <= _STANDING else int(np.clip((length / height - 0.17) / 0.06, 0, 4))
    phase, habit = int(rng.integers(_PHASES)), int(rng.integers(4))
    legs, top = _walker(step, phase, habit)
    scale = (height, height * width / (_WIDTH * height), height)
    builder.add_mesh(legs, scale, "person", _clothes(rng))
    builder.add_mesh(top, scale, "person", _clothes(rng))
    # a child's head is larger against the stature
    head = 0.13 * height if height > 1.5 else 0.5 * (0.13 * height + 0.2)
    builder.add(
        "ellipsoid", (0.012 * height, 0.0, height - head / 2), (0.85 * head, 0.7 * head, head), "person", "skin"
    )
    kind = rng.random()
    if kind < 0.15:  # a rucksack
        size = (0.10 * height, 0.16 * height, 0.24 * height)
        builder.add("box", (-0.105 * height, 0.0, 0.70 * height), size, "person", _clothes(rng))
    elif kind < 0.32 and habit != 1:  # a bag in one hand
        side = float(rng.choice((-1.0, 1.0)))
        size = (0.20 * height, 0.06 * height, 0.17 * height)
        builder.add("box", (0.0, side * 0.44 * width, 0.30 * height), size, "person", _clothes(rng))
        strap = (0.012 * height, 0.012 * height, 0.09 * height)
        builder.add("cylinder", (0.0, side * 0.44 * width, 0.42 * height), strap, "person", "dark-cloth")
    return builder.primitives


def rider(
    builder: ObjectBuilder, hip: Vector, foot: Vector, hand: Vector, lean: float, rng: np.random.Generator
) -> None:
    """Add a rider with the hip's middle there, the middle of the pedals at `foot` and of the handlebar at `hand` [m].

    The torso leans forward by `lean` [rad]; `y` of `foot` and `hand` is half the distance between both.
    """
    height = builder.placed.size[2]
    stature = (height - hip[2]) / (1 - 0.530 - 0.32 * (1 - math.cos(lean)))
    phase = int(rng.integers(_PHASES)) if builder.placed.kind == "cyclist" else -1
    legs, top, crown = _rider(hip, foot, hand, round(stature, 1), lean, phase)
    builder.add_mesh(legs, (1.0, 1.0, 1.0), "rider", _clothes(rng))
    builder.add_mesh(top, (1.0, 1.0, 1.0), "rider", _clothes(rng))
    head = 0.14 * round(stature, 1) + (0.04 if phase < 0 else 0.0)  # a motorcyclist wears a helmet
    center = (crown[0] + 0.02, 0.0, min(crown[2] + 0.62 * head, height - head / 2))
    covered = phase < 0 or rng.random() < 0.4
    builder.add("ellipsoid", center, (head, 0.8 * head, head), "rider", "light-paint" if covered else "skin")


def _clothes(rng: np.random.Generator) -> str:
    return "dark-cloth" if rng.random() < 0.5 else "cloth"


@lru_cache(maxsize=256)
def _walker(step: int, phase: int, habit: int) -> tuple[MeshTemplate, MeshTemplate]:
    """Legs, and torso with arms, at a phase of the gait and stature 1; step 0 stands, 4 is the longest."""
    swing = (0.0, 0.13, 0.20, 0.27, 0.34)[step]
    angle = 2 * math.pi * phase / _PHASES
    limbs, lowest = [], 1.0
    for side, at in ((-1, angle), (1, angle + math.pi)):
        hip = np.array([0.0, side * 0.052, 0.0])
        thigh = swing * math.sin(at) + 0.35 * swing
        # the knee bends while the leg swings forward: 60 degrees in a brisk walk
        shank = thigh - (0.12 + 2.6 * swing * max(0.0, math.cos(at)) if step else 0.03)
        knee = hip + _THIGH * _down(thigh)
        ankle = knee + _SHANK * _down(shank)
        limbs.append((hip, knee, ankle, side))
        lowest = min(lowest, float(ankle[2]))
    rise = np.array([0.0, 0.0, _ANKLE - lowest])
    legs = []
    for hip, knee, ankle, side in limbs:
        legs.append(limb(np.stack([hip + 0.02 * np.array([0, 0, 1]), knee, ankle]) + rise, (0.105, 0.078, 0.055)))
        foot = ankle + rise + (0.035, side * 0.008, -0.016)
        legs.append(box(tuple(foot.tolist()), (0.145, 0.052, 0.046)))
    hips = float(rise[2])
    arms = []
    for side, at in ((-1, angle + math.pi), (1, angle)):
        shoulder = np.array([0.0, side * 0.108, hips + _TORSO - 0.012])
        upper = 0.8 * swing * math.sin(at)
        lower = upper + 0.25 + (0.3 * swing if step else 0.0)
        if habit == 1 and side > 0:
            lower = upper + 2.1  # something is held before the chest
        elbow = shoulder + _UPPER_ARM * _down(upper) + (0.0, side * 0.016, 0.0)
        hand = elbow + _FOREARM * _down(lower) - (0.0, side * (0.05 if habit == 1 and side > 0 else 0.004), 0.0)
        arms.append(limb(np.stack([shoulder, elbow, hand]), (0.066, 0.056, 0.044)))
    trunk = _torso(np.array([0.0, 0.0, hips]), 0.04, coat=habit == 2)
    return MeshTemplate.from_triangles(*join(*legs)), MeshTemplate.from_triangles(*join(trunk, *arms))


@lru_cache(maxsize=256)
def _rider(
    hip: Vector, foot: Vector, hand: Vector, stature: float, lean: float, phase: int
) -> tuple[MeshTemplate, MeshTemplate, np.ndarray]:
    """Legs, torso with arms [m], and where the neck ends."""
    legs, arms = [], []
    up = np.array([math.sin(lean), 0.0, math.cos(lean)])
    neck = np.array(hip) + (_TORSO + 0.02) * stature * up
    for side in (-1, 1):
        crank = 0.17 if phase >= 0 else 0.0
        at = 2 * math.pi * phase / _PHASES + (math.pi if side > 0 else 0.0)
        pedal = np.array([foot[0] + crank * math.cos(at), side * foot[1], foot[2] + crank * math.sin(at)])
        socket = np.array([hip[0], side * 0.05 * stature, hip[2]])
        ankle = pedal + np.array([-0.04, 0.0, 0.08])
        knee = _joint(socket, ankle, _THIGH * stature, _SHANK * stature, forward=True)
        diameters = (0.105 * stature, 0.078 * stature, 0.055 * stature)
        legs.append(limb(np.stack([socket, knee, ankle]), diameters))
        legs.append(box((float(pedal[0]) + 0.02, float(pedal[1]), float(pedal[2]) + 0.04), (0.26, 0.09, 0.08)))
        shoulder = neck + stature * np.array([0.0, side * 0.105, -0.02])
        grip = np.array([hand[0], side * hand[1], hand[2]])
        elbow = _joint(shoulder, grip, _UPPER_ARM * stature, _FOREARM * stature, forward=False)
        arms.append(limb(np.stack([shoulder, elbow, grip]), (0.062 * stature, 0.05 * stature, 0.042 * stature)))
    vertices, faces = _torso(np.zeros(3), 0.0, coat=False)
    turned = np.stack(
        [
            vertices[:, 0] * math.cos(lean) + vertices[:, 2] * math.sin(lean),
            vertices[:, 1],
            vertices[:, 2] * math.cos(lean) - vertices[:, 0] * math.sin(lean),
        ],
        axis=1,
    )
    trunk = (turned * stature + hip, faces)
    return (
        MeshTemplate.from_triangles(*join(*legs)),
        MeshTemplate.from_triangles(*join(trunk, *arms)),
        neck + 0.05 * stature * up,
    )


def _torso(hip: np.ndarray, lean: float, *, coat: bool) -> Triangles:
    """Rings of a torso over the hip, from the seat (a coat's hem) to the neck."""
    z = np.array([-0.15 if coat else -0.045, 0.0, 0.10, 0.22, 0.285, 0.31, 0.345])
    half_y = np.array([0.098 if coat else 0.078, 0.094, 0.08, 0.102, 0.105, 0.05, 0.032])
    half_x = np.array([0.085 if coat else 0.055, 0.072, 0.066, 0.074, 0.058, 0.04, 0.034])
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


def _down(angle: float) -> np.ndarray:
    """The direction of a segment that hangs, turned forward by an angle."""
    return np.array([math.sin(angle), 0.0, -math.cos(angle)])


def _joint(start: np.ndarray, end: np.ndarray, upper: float, lower: float, *, forward: bool) -> np.ndarray:
    """Where two segments between two points meet, bent forward and up (a knee) or down (an elbow)."""
    reach = end - start
    distance = min(float(np.linalg.norm(reach)), 0.98 * (upper + lower))
    along = reach / np.linalg.norm(reach)
    share = (upper**2 - lower**2 + distance**2) / (2 * distance)
    off = math.sqrt(max(upper**2 - share**2, 0.0))
    bend = np.array([1.0, 0.0, 0.4]) if forward else np.array([0.0, 0.0, -1.0])
    bend = bend - along * (bend @ along)
    joint: np.ndarray = start + share * along + off * bend / np.linalg.norm(bend)
    return joint
