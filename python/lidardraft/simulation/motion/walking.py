"""People on foot: a step of a walk, which waits at a kerb until the road can be crossed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lidardraft.scene.scenario import Walk

Crosses = Callable[[np.ndarray, float], bool]  # whether who is as fast as that can go to and fro over places [2, 2] now
_LOOKS = 0.4  # s between the times at which who waits looks


def walked(
    walk: Walk, place: tuple[float, float, float], begin: float, end: float, crosses: Crosses
) -> tuple[tuple[float, float, float], bool]:
    """Where x, y [m] and yaw [rad] are after a step from a time [s] to another, and whether that is the goal."""
    x, y, yaw = place
    rest, way = math.dist(walk.to, (x, y)), walk.speed * max(0.0, end - max(begin, walk.start))
    if way <= 0.0 or _waits(walk, (x, y), rest, way, begin, end, crosses):
        return place, False
    if way >= rest:
        return (*walk.to, yaw), True
    yaw += math.remainder(math.atan2(walk.to[1] - y, walk.to[0] - x) - yaw, math.tau)
    return (x + (walk.to[0] - x) * way / rest, y + (walk.to[1] - y) * way / rest, yaw), False


def _waits(
    walk: Walk, here: tuple[float, float], rest: float, way: float, begin: float, end: float, crosses: Crosses
) -> bool:
    """Whether it would step onto a road, and may not now."""
    for first, last in walk.crosses:
        if rest - way < first <= rest:
            there = np.array([here, walk.to])[[0, 0]] + np.outer((0.0, rest - last), np.subtract(walk.to, here) / rest)
            looks = math.floor(begin / _LOOKS) != math.floor(end / _LOOKS)
            return not (looks and crosses(there, walk.speed))
    return False
