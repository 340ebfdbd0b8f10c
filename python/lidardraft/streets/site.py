"""The site of a street: its road and ground, the things put there so far, and what is still free."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.buildings import BALCONY, EAVES, STOREY
from lidardraft.streets.furniture import LAMP_ARM
from lidardraft.streets.ground import Ground
from lidardraft.streets.plants import trunk_diameter
from lidardraft.streets.thing import Thing

_HEADROOM = 2.2  # m over the public way that stays free of private things
_RIDDEN = ("cyclist", "motorcyclist")
# what gets no instance
_STUFF = (
    *("house", "block", "shed", "tree", "bush", "hedge", "lamp", "pole", "sign", "traffic_light"),
    *("fence", "garden_wall", "bin", "bench"),
)


class Site:
    """Places things in the road's frame so that none goes through another.

    A thing's space is one or two upright boxes: a tree has its trunk's and its crown's, and a car can stand under it.
    """

    def __init__(self, road: Road, ground: Ground) -> None:
        self.road, self.ground = road, ground
        self.things: list[Thing] = []
        self._names: Counter[str] = Counter()
        self._instances = 0
        self._taken = np.zeros((0, 8))
        self._way = self._public_way()

    def place(
        self,
        kind: str,
        along: float,
        across: float,
        size: tuple[float, float, float],
        *,
        turn: float = 0.0,
        stem: float = 0.0,
        margin: float = 0.15,
        private: bool = False,
    ) -> bool:
        """Put a thing there, turned by `turn` against the road, if `margin` [m] around it is free; whether it was put.

        A `private` thing keeps off the road and the sidewalks.
        """
        x, y, heading = self.road.at(along, across)
        number = self._names[kind] + 1
        thing = Thing(
            kind=kind,
            id=f"{kind}_{number}",
            x=x,
            y=y,
            z=self.ground.height(along, across),
            level=self.ground.level(along, across),
            yaw=math.remainder(heading + turn, 2 * math.pi),
            size=size,
            stem=stem,
            instance=0 if kind in _STUFF else self._instances + 1,
        )
        spaces = thing_spaces(thing)
        if any(overlaps(space, self._taken, margin).any() for space in spaces):
            return False
        if private and any(overlaps(space, self._way, 0.0).any() for space in spaces):
            return False
        if thing.instance:
            self._instances += 2 if kind in _RIDDEN else 1
        self._names[kind] = number
        self._taken = np.concatenate([self._taken, spaces])
        self.things.append(thing)
        return True

    def is_free(self, x: float, y: float, yaw: float, size: tuple[float, float, float]) -> bool:
        """Whether an upright box on the ground there touches nothing."""
        return not overlaps(_space(x, y, yaw, size, 0.0, size[2]), self._taken, 0.0).any()

    def _public_way(self) -> np.ndarray:
        road = self.road
        spaces = []
        step = 6.0
        for along in np.arange(-road.reach, road.reach, step) + step / 2:
            x, y, yaw = road.at(float(along), 0.0)
            spaces.append(_space(x, y, yaw, (step, 2 * road.verge, 0.0), -2.0, _HEADROOM))
        if road.junction is not None:
            for arm in road.arms:
                across = (road.verge + road.reach) / 2 * (1 if arm == "left" else -1)
                x, y, yaw = road.at(road.junction, across)
                spaces.append(_space(x, y, yaw, (2 * road.verge, road.reach, 0.0), -2.0, _HEADROOM))
        return np.array(spaces)


def thing_spaces(thing: Thing) -> np.ndarray:
    """The upright boxes [n, 8] a thing fills: x, y, cos, sin, half length, half width, bottom, top."""
    length, width, height = thing.size
    boxes = [(length, width, 0.0, height)]
    if thing.kind == "tree":
        girth = trunk_diameter(thing)
        boxes = [(girth, girth, 0.0, thing.stem), (length, width, thing.stem, height)]
    elif thing.kind == "house":
        boxes.append((length + 2 * EAVES, width + 2 * EAVES, thing.stem - 0.2, height))
    elif thing.kind == "block":
        boxes.append((length, width + 2 * BALCONY, 0.9 * STOREY, height))
    elif thing.kind == "lamp":
        boxes.append((0.3, 2 * LAMP_ARM, height - 0.3, height))
    return np.array([_space(thing.x, thing.y, thing.yaw, (box[0], box[1], 0.0), box[2], box[3]) for box in boxes])


def overlaps(space: np.ndarray, others: np.ndarray, margin: float) -> np.ndarray:
    """Which of the upright boxes [n, 8] come within `margin` [m] of one: separating axes, intervals in height."""
    apart = (others[:, 6] >= space[7]) | (others[:, 7] <= space[6])
    dx, dy = others[:, 0] - space[0], others[:, 1] - space[1]
    # cosine and sine of the angle between the two boxes
    c = np.abs(others[:, 2] * space[2] + others[:, 3] * space[3])
    s = np.abs(others[:, 3] * space[2] - others[:, 2] * space[3])
    for cos, sin, mine in ((space[2], space[3], True), (others[:, 2], others[:, 3], False)):
        forward, left = np.abs(cos * dx + sin * dy), np.abs(cos * dy - sin * dx)
        a, b = (space[4:6], (others[:, 4], others[:, 5])) if mine else ((others[:, 4], others[:, 5]), space[4:6])
        apart |= forward >= a[0] + c * b[0] + s * b[1] + margin
        apart |= left >= a[1] + s * b[0] + c * b[1] + margin
    near: np.ndarray = ~apart
    return near


def _space(x: float, y: float, yaw: float, size: tuple[float, float, float], bottom: float, top: float) -> np.ndarray:
    return np.array([x, y, math.cos(yaw), math.sin(yaw), size[0] / 2, size[1] / 2, bottom, top])
