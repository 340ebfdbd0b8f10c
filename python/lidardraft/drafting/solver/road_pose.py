"""A place in the frame of a road, and how such places are sampled."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

YAW_DEVIATION = 0.01  # rad, standard deviation of the heading in a lane or along a kerb; estimate of ours


class RoadPose(NamedTuple):
    """A place in the road's frame: along and across [m], and the yaw from the road's heading there [rad]."""

    along: float
    across: float
    yaw: float


PoseSampler = Callable[[np.random.Generator, float, int, float], RoadPose]
"""A pose from a generator, a distance along [m], the number of the object, and an effort that rises from 0 to 1 while
nothing fits."""


def alternate(sides: tuple[int, ...], number: int) -> int:
    """The side of one of several objects that take the sides in turns."""
    return sides[number % len(sides)]


def turned(rng: np.random.Generator, yaw: float) -> float:
    """A yaw [rad] as precise as drivers are."""
    return yaw + float(rng.normal(0.0, YAW_DEVIATION))


def walking_yaw(heading: str, rng: np.random.Generator) -> float:
    """The yaw [rad] of who walks: across the road, one way or the other, where the `heading` says so, else along it."""
    way = {"across-left": 1, "across-right": -1}.get(heading) or int(rng.choice([-1, 1]))
    return (math.pi / 2 if heading.startswith("across") else 0.0) * way + float(rng.normal(0.0, 0.2))


BACKWARDS = math.pi  # rad, against the ego's direction
