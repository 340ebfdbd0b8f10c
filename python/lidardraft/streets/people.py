"""People: on foot and on two wheels."""

from __future__ import annotations

import numpy as np

from lidardraft.scene.layout import Primitive
from lidardraft.streets.thing import Parts, Thing

# Shares of the stature: Winter, Biomechanics and Motor Control of Human Movement (hip 0.53, shoulder 0.82).
_HIP, _SHOULDER = 0.53, 0.82


def person(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A person standing or walking: legs in a stride, torso, arms that swing, head; sometimes a bag."""
    length, width, height = thing.size
    parts = Parts(thing)
    stride = 0.5 * max(length - 0.25, 0.0) * rng.uniform(0.6, 1.0)
    hip, shoulder = _HIP * height, _SHOULDER * height
    for side, ahead in ((-1, stride), (1, -stride)):
        # a leg leans: thigh under the hip, shank and foot further out
        parts.add("ellipsoid", (0.35 * ahead, side * 0.09, 0.75 * hip), (0.21, 0.19, 0.66 * hip), "person")
        parts.add("cylinder", (0.8 * ahead, side * 0.10, 0.25 * hip), (0.14, 0.14, 0.5 * hip), "person")
        parts.add("box", (0.8 * ahead + 0.06, side * 0.10, 0.04), (0.26, 0.10, 0.08), "person", "rubber")
        parts.add(
            "ellipsoid", (-0.5 * ahead, side * 0.42 * width, 0.62 * height), (0.12, 0.11, 0.40 * height), "person"
        )
    parts.add("ellipsoid", (0.0, 0.0, (hip + shoulder) / 2), (0.30, 0.92 * width, 1.45 * (shoulder - hip)), "person")
    parts.add("ellipsoid", (0.02, 0.0, 0.935 * height), (0.19, 0.16, 0.13 * height), "person")
    if rng.random() < 0.25:
        parts.add("box", (-0.19, 0.0, 0.68 * height), (0.18, 0.3, 0.42), "person")
    return parts.primitives


def rider(parts: Parts, *, seat: float, lean: float, rng: np.random.Generator) -> None:
    """Add a rider on a seat of that height [m], leaning forward by `lean` [m] at the shoulders."""
    thing = parts.thing
    torso = thing.size[2] - seat
    parts.add("ellipsoid", (-0.15 + 0.5 * lean, 0.0, seat + 0.36 * torso), (0.34, 0.44, 0.85 * torso), "rider")
    parts.add("ellipsoid", (-0.12 + lean, 0.0, seat + 0.87 * torso), (0.22, 0.19, 0.26 * torso), "rider")
    swing = rng.uniform(-0.15, 0.15)
    for side in (-1, 1):
        parts.add("ellipsoid", (0.12 + lean, side * 0.2, seat + 0.42 * torso), (0.52, 0.11, 0.13), "rider")
        parts.add("ellipsoid", (0.06, side * 0.14, seat - 0.12 + side * swing), (0.5, 0.17, 0.2), "rider")
        parts.add("cylinder", (0.14, side * 0.14, seat - 0.42 + side * swing), (0.12, 0.12, 0.5), "rider")
