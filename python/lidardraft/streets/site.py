"""The site of a street: its road and ground, the things put there so far, and what is still free."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from typing import NamedTuple

import numpy as np

from lidardraft.scene.road import Patch, Road
from lidardraft.streets.ground import Ground
from lidardraft.streets.space import Grid, Space, box_space, spaces_of
from lidardraft.streets.thing import Thing

_HEADROOM = 2.2  # m over the public way that stays free of private things
_RIDDEN = ("cyclist", "motorcyclist")
_BUILDINGS = ("house", "block", "shed")
_PLINTH = 0.7  # m that a building's ground floor may lie over the lowest ground under it
# what gets no instance
_STUFF = frozenset(
    (
        *("house", "block", "shed", "tree", "bush", "hedge", "lamp", "pole", "sign", "traffic_light"),
        *("fence", "garden_wall", "bin", "bench", "shelter", "cone", "barrier", "mesh_fence", "grass"),
        *("gantry", "wall", "billboard", "letterbox", "hydrant", "cabinet"),
    )
)


class _Placed(NamedTuple):
    kind: str
    number: int
    instance: int
    along: float
    across: float
    x: float
    y: float
    yaw: float
    turn: float
    size: tuple[float, float, float]
    stem: float


class Site:
    """Places things in the road's frame so that none goes through another."""

    def __init__(self, road: Road, ground: Ground) -> None:
        self.road, self.ground = road, ground
        self.stops: list[tuple[float, float]] = []  # along and side of bus stops
        self._placed: list[_Placed] = []
        self._things: list[Thing] = []
        self._names: Counter[str] = Counter()
        self._instances = 0
        self._taken, self._way = Grid(), Grid()
        for space in self._public_way():
            self._way.add(space)

    @property
    def things(self) -> list[Thing]:
        """What was put there, on the ground, in the order in which it was put."""
        if len(self._things) < len(self._placed):
            self._things += self._settled(self._placed[len(self._things) :])
        return self._things

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
        if not self.ground.reaches(along, across):
            return False
        x, y, heading = self.road.at(along, across)
        yaw = math.remainder(heading + turn, 2 * math.pi)
        spaces = spaces_of(kind, x, y, yaw, size, stem)
        for space in spaces:
            if self._taken.touches(space, margin) or (private and self._way.touches(space)):
                return False
        for space in spaces:
            self._taken.add(space)
        self._names[kind] += 1
        instance = 0 if kind in _STUFF else self._instances + 1
        if instance:
            self._instances += 2 if kind in _RIDDEN else 1
        self._placed.append(_Placed(kind, self._names[kind], instance, along, across, x, y, yaw, turn, size, stem))
        return True

    def pave(self, drive: Patch) -> None:
        """Add a drive, which private things keep off from now on."""
        self.ground.pave(drive)
        self._way.add(self._patch_space(drive))

    def is_free(self, x: float, y: float, yaw: float, size: tuple[float, float, float]) -> bool:
        """Whether an upright box on the ground there touches nothing."""
        return not self._taken.touches(box_space(x, y, yaw, size[:2], 0.0, size[2]))

    def is_private(self, x: float, y: float, yaw: float, size: tuple[float, float, float]) -> bool:
        """Whether an upright box on the ground there keeps off the road and the sidewalks."""
        return not self._way.touches(box_space(x, y, yaw, size[:2], 0.0, size[2]))

    def _settled(self, placed: list[_Placed]) -> list[Thing]:
        """The things at their heights."""
        along, across = np.array([(p.along, p.across) for p in placed]).T
        heights = self.ground.heights(along, across)
        over = {**dict.fromkeys(_BUILDINGS, _PLINTH), "grass": 0.0}
        sunk = np.array([index for index, p in enumerate(placed) if p.kind in over], dtype=np.intp)
        if len(sunk):
            lowest = self._lowest([placed[index] for index in sunk])
            lowest += [over[placed[index].kind] for index in sunk]
            heights[sunk] = np.minimum(heights[sunk], lowest)
        levels = self.ground.levels(along, across)
        return [
            Thing(
                kind=p.kind,
                id=f"{p.kind}_{p.number}",
                x=p.x,
                y=p.y,
                z=z,
                level=level,
                yaw=p.yaw,
                size=p.size,
                stem=p.stem,
                instance=p.instance,
            )
            for p, z, level in zip(placed, heights.tolist(), levels.tolist(), strict=True)
        ]

    def _lowest(self, buildings: list[_Placed]) -> np.ndarray:
        """The lowest ground under the corners of each."""
        half = np.array([p.size[:2] for p in buildings])[:, None] * np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) / 2
        turn = np.array([p.turn for p in buildings])[:, None]
        along = (
            np.array([p.along for p in buildings])[:, None] + half[..., 0] * np.cos(turn) - half[..., 1] * np.sin(turn)
        )
        across = (
            np.array([p.across for p in buildings])[:, None] + half[..., 0] * np.sin(turn) + half[..., 1] * np.cos(turn)
        )
        lowest: np.ndarray = self.ground.heights(along.ravel(), across.ravel()).reshape(-1, 4).min(axis=1)
        return lowest

    def _public_way(self) -> list[Space]:
        road = self.road
        spaces = []
        pieces = math.ceil(2 * road.reach / 6.0)
        step = 2 * road.reach / pieces
        for number in range(pieces):
            x, y, yaw = road.at((number + 0.5) * step - road.reach, 0.0)
            # the outer edge of a bend is longer
            length = step * (1 + abs(road.curvature) * road.verge)
            spaces.append(box_space(x, y, yaw, (length, 2 * road.verge), -2.0, _HEADROOM))
        if road.junction is not None:
            for arm in road.arms:
                across = (road.verge + road.reach) / 2 * (1 if arm == "left" else -1)
                x, y, yaw = road.at(road.junction, across)
                spaces.append(box_space(x, y, yaw, (2 * road.verge, road.reach), -2.0, _HEADROOM))
            if road.circle is not None:
                x, y, yaw = road.at(road.junction, 0.0)
                outer = road.circle + road.sidewalk
                # bars that together cover the disc
                turns = [math.radians(15 * number) for number in range(7)]
                for low, high in itertools.pairwise(turns):
                    size = (2 * math.cos(low) * outer, 2 * math.sin(high) * outer)
                    spaces.append(box_space(x, y, yaw, size, -2.0, _HEADROOM))
        spaces += [self._patch_space(patch) for patch in road.patches]
        return spaces

    def _patch_space(self, patch: Patch) -> Space:
        length, width = patch.along[1] - patch.along[0], patch.across[1] - patch.across[0]
        x, y, yaw = self.road.at(sum(patch.along) / 2, sum(patch.across) / 2)
        return box_space(x, y, yaw, (length, width), -2.0, _HEADROOM)


def thing_spaces(thing: Thing) -> np.ndarray:
    """The upright boxes [n, 8] a thing fills: x, y, cos, sin, half length, half width, bottom, top over the ground."""
    return np.array(spaces_of(thing.kind, thing.x, thing.y, thing.yaw, thing.size, thing.stem))
