"""People on foot: a step of a walk, which waits at a kerb until the road can be crossed."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from lidardraft.scene.scenario import Walk

_MEETS = (2.5, 0.9)  # m ahead and beside it where others are passed
_STEP = 0.6  # m ahead that have to be free
_LOOKS = 0.4  # s between the times at which who waits looks


class Watch(Protocol):
    """What somebody on foot sees of the traffic."""

    def can_cross(self, places: np.ndarray, speed: float) -> bool:
        """Whether who is as fast as that [m/s] can go over a road from and to places [2, 2] now."""

    def is_free(self, x: float, y: float) -> bool:
        """Whether nobody drives or stands there."""

    @property
    def people(self) -> np.ndarray:
        """x, y [P, 2] of all on foot."""


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
    if way >= rest:
        return (*walk.to, yaw), True
    yaw += math.remainder(math.atan2(ahead[1], ahead[0]) - yaw, math.tau)
    if any(last < rest < first for first, last in walk.crosses):
        on, aside = _passing(watch.people - (x, y), ahead)
        ahead = (on * ahead[0] - aside * ahead[1], on * ahead[1] + aside * ahead[0])
        if not watch.is_free(x + _STEP * ahead[0], y + _STEP * ahead[1]):
            return place, False
    return (x + way * ahead[0], y + way * ahead[1], yaw), False


def _passing(off: np.ndarray, ahead: tuple[float, float]) -> tuple[float, float]:
    """How far ahead and left it steps, of 1 m, to pass others who are `off` it [P, 2]."""
    along, left = off @ np.array(ahead), off @ np.array((-ahead[1], ahead[0]))
    met = np.flatnonzero((along > 0.0) & (along < _MEETS[0]) & (np.abs(left) < _MEETS[1]))
    if not len(met):
        return 1.0, 0.0
    nearest = met[int(along[met].argmin())]
    aside = -1.0 if left[nearest] >= 0.0 else 1.0
    return (0.0, aside) if along[nearest] < _MEETS[1] else (math.sqrt(0.5), aside * math.sqrt(0.5))
