"""A driver in a lane: its place, and the speed that it would like."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from lidardraft.scene.lane import Lane
from lidardraft.scene.scenario import AlongLane
from lidardraft.scene.solids import Solid

_TURN = 0.35  # rad against its lane; bodies turned by more do not drive along it
_BESIDE = 3  # half lane widths that an overtaking vehicle is beside the middle of its lane, at most
# Factors of the speed of the road, and highest speeds [m/s]: estimates.
_PACES = {
    "motorcycle": (1.0, math.inf),
    "bicycle": (1.0, 5.0),
    "rider": (1.0, 5.0),
    "bus": (0.85, 22.0),
    "truck": (0.85, 22.0),
    "train": (0.85, 14.0),
}
_SPREAD = (0.8, 1.0)  # of the speeds of drivers, as shares of it
_HALTS = 8.0  # s that a bus halts


@dataclass(frozen=True, slots=True)
class Body:
    """An object that may move: its name and classes, x, y, z of its middle [m] and yaw [rad], length, width, height
    [m], and the parts that others can collide with."""

    name: str
    labels: frozenset[str]
    place: tuple[float, float, float, float]
    size: tuple[float, float, float]
    solids: tuple[Solid, ...]


@dataclass(slots=True, eq=False)
class Driver:
    """A driver `along` a lane [m], `left` of its middle [m], with its `speed` [m/s]."""

    body: Body
    motion: AlongLane
    lane: Lane
    along: float
    left: float
    yaw: float  # against the lane, at the start
    start: float  # `along` at the start [m]
    speed: float = 0.0
    waited: float = 0.0  # s since it came to stand
    barred: float = math.inf  # the furthest place of its front along the lane [m]
    beside: bool = False  # whether it has been beside a vehicle that it overtakes
    returns: bool = False  # to its lane, or to its `side` of it
    side: float = 0.0  # its goal left of the middle [m]
    drift: float = 0.0  # m to the left for each along

    def wish(self, time: float) -> float:
        """The speed that it wants at a `time` [s] if the way is free [m/s]."""
        if time < self.motion.start:
            return 0.0
        said = [speed for when, speed in self.motion.later if when <= time]
        return min(said[-1] if said else self.usual(), self.lane.limit(self.along))

    def halt(self) -> float:
        """The furthest place of its front along its lane before its halt [m]; infinite without one."""
        if self.motion.halt is None or self.waited > _HALTS:
            return math.inf
        (along,), _ = self.lane.line.along_across(np.array([self.motion.halt]))
        line = float(along) + self.body.size[0] / 2 + self.motion.gap / 2
        return line if self.along + self.body.size[0] / 2 < line else math.inf

    def usual(self) -> float:
        """The speed [m/s] of its motion, or else that of its road and kind."""
        if self.motion.speed is not None:
            return self.motion.speed
        label = next((label for label in _PACES if label in self.body.labels), "")
        share, most = _PACES.get(label, (1.0, math.inf))
        low, high = _SPREAD
        return min(self.lane.speed * share * (low + (high - low) * crc32(self.body.name.encode()) / 2**32), most)


def driver_of(body: Body, motion: AlongLane, lanes: Sequence[Lane]) -> Driver | None:
    """The body as a driver in the lane that it stands in and heads along, or None if there is no such lane.

    It turns if no lane goes straight on. Of several lanes that coincide at that place it takes any."""
    x, y, _, yaw = body.place
    best, least = None, (True, True, math.inf, 0)
    for lane in lanes:
        (along,), (left,) = (values.tolist() for values in lane.line.along_across(np.array([[x, y]])))
        off = math.remainder(yaw - float(lane.line.heading(np.array([along]))[0]), math.tau)
        aside = lane.width / 2 * (_BESIDE if motion.overtakes else 1)
        inside = 0.0 < along < lane.line.length and abs(left) < aside and abs(off) < _TURN
        rank = lane.closed, lane.turn != motion.turn, round(abs(left), 2), crc32(f"{body.name} {lane.id}".encode())
        if inside and lane.turn in (motion.turn, motion.turn or lane.turn) and (best is None or rank < least):
            best, least = Driver(body, motion, lane, along, left, off, along), rank
    return best
