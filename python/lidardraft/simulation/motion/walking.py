"""People on foot: a step of a walk, which waits at a kerb until the road can be crossed."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from lidardraft.scene.scenario import Walk

_STEP = 0.5  # m ahead that have to be free
_LOOKS = 0.4  # s between the times at which who waits looks


class Watch(Protocol):
    """What somebody on foot sees of the traffic."""

    def can_cross(self, places: np.ndarray, speed: float) -> bool:
        """Whether who is as fast as that [m/s] can go over a road from and to places [2, 2] now."""

    def is_free(self, x: float, y: float) -> bool:
        """Whether nobody drives or stands there."""


def walked(
    walk: Walk, place: tuple[float, float, float], begin: float, end: float, watch: Watch
) -> tuple[tuple[float, float, float], bool]:
    """Where x, y [m] and yaw [rad] are after a step from a time [s] to another, and whether that is the goal."""
    x, y, yaw = place
    rest, way = math.dist(walk.to, (x, y)), walk.speed * max(0.0, end - max(begin, walk.start))
    if way <= 0.0:
        return place, False
    ahead = ((walk.to[0] - x) / max(rest, way), (walk.to[1] - y) / max(rest, way))
    for first, last in walk.crosses:
        if rest - way < first <= rest:  # it would step onto a road
            there = np.array([(x, y), (x + ahead[0] * (rest - last), y + ahead[1] * (rest - last))])
            looks = math.floor(begin / _LOOKS) != math.floor(end / _LOOKS)
            if not (looks and watch.can_cross(there, walk.speed)):
                return place, False
        elif last < rest < first and not watch.is_free(x + _STEP * ahead[0], y + _STEP * ahead[1]):
            return place, False
    if way >= rest:
        return (*walk.to, yaw), True
    yaw += math.remainder(math.atan2(ahead[1], ahead[0]) - yaw, math.tau)
    return (x + way * ahead[0], y + way * ahead[1], yaw), False
