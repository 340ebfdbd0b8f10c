"""People on foot: a step of a walk, which waits at a kerb until the road can be crossed and passes around others."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from lidardraft.scene.scenario import Walk

_MEETS, _CLEAR = 1.5, 0.5  # m ahead within which people pass others, and m from the middle of a person to these
_BESIDE, _PARALLEL = 0.43, 1e-9  # m to others beside a person that are not in its way; the least slope, and m
_TOUCHES, _SMALL = 0.45, 0.5  # m from the middle of a person: it comes no nearer to others; half the length of people
_DETOUR = 0.5  # sine of the angle to its goal at which a person is going around something
_THERE = 1.5  # m to a goal at which another stands
_MOVES = 0.5  # m/s from which a person lets others pass
_LOOKS = 0.4  # s between the looks of a waiting person
FORESEEN = (2.0, 6.0)  # s for which drivers expect people to walk on: anywhere, and at most on a road


class Watch(Protocol):
    """The traffic as a person on foot sees it."""

    def can_cross(self, places: np.ndarray, speed: float) -> bool:
        """Whether a person with a `speed` [m/s] can cross a road between `places` [2, 2] now."""

    @property
    def obstacles(self) -> np.ndarray:
        """All bodies, f64 [N, 6]: x, y, yaw, half the length and the width [m], and speed [m/s]."""


def walked(
    walk: Walk, place: tuple[float, float, float], begin: float, end: float, watch: Watch
) -> tuple[tuple[float, float, float], bool]:
    """x, y [m] and yaw [rad] after a step from `begin` to `end` [s], and whether that is the goal."""
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
    if walk.crosses:
        on, aside = _around(watch.obstacles, place, ahead)
        if on < 1.0 and rest < min(_THERE, walk.crosses[-1][1]):  # not on a road
            return place, True
        ahead = (on * ahead[0] - aside * ahead[1], on * ahead[1] + aside * ahead[0])
        ahead = _along_sides(watch.obstacles, (x, y), ahead, way)
    if ahead != (0.0, 0.0):
        yaw += math.remainder(math.atan2(ahead[1], ahead[0]) - yaw, math.tau)
    return (x + way * ahead[0], y + way * ahead[1], yaw), False


def foreseen(walk: Walk, place: tuple[float, float]) -> float:
    """The time [s] for which drivers expect a person to walk on: on a road, until it is crossed."""
    rest = math.dist(walk.to, place)
    over = ((rest - last) / walk.speed for first, last in walk.crosses if last < rest < first)
    return min(max(FORESEEN[0], *over, 0.0), FORESEEN[1])


def _along_sides(
    obstacles: np.ndarray, place: tuple[float, float], ahead: tuple[float, float], way: float
) -> tuple[float, float]:
    """The direction [2] that leads no nearer to touched obstacles: along the side of one, or 0, 0."""
    near = obstacles[np.hypot(*(obstacles[:, :2] - place).T) - np.hypot(*obstacles[:, 3:5].T) < way + _TOUCHES]
    off = _off(near, np.array(place))
    behind = (near[:, 3] < _SMALL) & (off @ ahead > 0.0)  # who walks up from behind does not hold it
    near, off = near[~behind], off[~behind]
    now = np.hypot(*off.T)
    for _ in range(2):
        after = np.hypot(*_off(near, np.add(place, np.multiply(way, ahead))).T)
        touched = np.flatnonzero((after < np.minimum(_TOUCHES, now) - _PARALLEL) & (now > 0.0))
        if not len(touched):
            return ahead
        nearest = touched[int(after[touched].argmin())]
        away = off[nearest] / now[nearest]
        x, y = (ahead - min(0.0, float(away @ ahead)) * away).tolist()
        ahead = (x, y)
    return 0.0, 0.0


def _off(obstacles: np.ndarray, place: np.ndarray) -> np.ndarray:
    """The vectors [N, 2] from the sides of obstacles to a place; 0 inside them."""
    cos, sin = np.cos(obstacles[:, 2]), np.sin(obstacles[:, 2])
    x, y = (place - obstacles[:, :2]).T
    u, v = x * cos + y * sin, y * cos - x * sin
    u -= np.clip(u, -obstacles[:, 3], obstacles[:, 3])
    v -= np.clip(v, -obstacles[:, 4], obstacles[:, 4])
    return np.stack([u * cos - v * sin, u * sin + v * cos], axis=1)


def _around(
    obstacles: np.ndarray, place: tuple[float, float, float], ahead: tuple[float, float]
) -> tuple[float, float]:
    """The direction (ahead, left), of length 1, past `obstacles`; 0, 0 to wait for moving ones."""
    off = obstacles[:, :2] - place[:2]
    along, left = off @ np.array(ahead), off @ np.array((-ahead[1], ahead[0]))
    turned = obstacles[:, 2] - math.atan2(ahead[1], ahead[0])
    cos, sin = np.cos(turned), np.sin(turned)
    # the distances at which a ray ahead enters and leaves each pair of sides
    slope = np.stack([cos, -sin])
    slope = np.where(np.abs(slope) < _PARALLEL, _PARALLEL, slope)
    middle = np.stack([along * cos + left * sin, left * cos - along * sin]) / slope
    spans = (obstacles[:, 3:5].T + _BESIDE) / np.abs(slope)
    enters, leaves = (middle - spans).max(axis=0), (middle + spans).min(axis=0)
    reach = np.abs(sin) * obstacles[:, 3] + np.abs(cos) * obstacles[:, 4] + _CLEAR
    low, high = left - reach, left + reach
    in_way = (enters < np.minimum(leaves, _MEETS)) & (enters > -_BESIDE) & (low < 0.0) & (high > 0.0)
    if not in_way.any():
        return 1.0, 0.0
    if (obstacles[in_way, 5] > _MOVES).any():
        return 0.0, 0.0
    met = in_way | ((np.abs(along) < _MEETS) & (along > 0.0))
    sides = np.concatenate([low[met], high[met]])
    free = sides[~((low[met] < sides[:, None]) & (sides[:, None] < high[met])).any(axis=1)]
    aside = math.sin(place[2] - math.atan2(ahead[1], ahead[0]))
    if abs(aside) > _DETOUR:  # it keeps to the side that it has taken
        free = free[free * aside > 0.0]
    side = float(free[np.abs(free).argmin()])
    on = max(0.0, float(enters[in_way].min()))
    return on / math.hypot(on, side), side / math.hypot(on, side)
