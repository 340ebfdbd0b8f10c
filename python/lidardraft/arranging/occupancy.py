"""The objects of a street so far, and its free space."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from typing import NamedTuple

import numpy as np

from lidardraft.arranging.ground import Ground
from lidardraft.objects.kinds import kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.road import PavedArea, Road
from lidardraft.scene.solids import Solid, Solids

_HEADROOM = 2.2  # m over the public way without private objects: an estimate
_PUBLIC_DEPTH = 2.0  # m under the road that are public too, for falling ground
_PUBLIC_PIECE = 6.0  # m of the boxes that follow a bend
_BAR = 15  # degrees between the boxes that cover a disc


class _Placement(NamedTuple):
    kind: str
    number: int
    instance: int
    along: float
    across: float
    x: float
    y: float
    yaw: float
    angle: float
    size: tuple[float, float, float]
    clearance: float


class Occupancy:
    """The road and ground of a street and its objects: it places objects so that none intersects another.

    Places are along and across the road [m], angles against it [rad]. Kinds in `denied` are never placed; instances
    count on from `instances`.
    """

    def __init__(self, road: Road, ground: Ground, *, denied: frozenset[str] = frozenset(), instances: int = 0) -> None:
        self.road, self.ground, self.denied = road, ground, denied
        self.stops: list[tuple[float, float]] = []  # along and side of bus stops
        self._placed: list[_Placement] = []
        self._objects: list[PlacedObject] = []
        self._names: Counter[str] = Counter()
        self._instances = instances
        self._occupied, self._public = Solids(), Solids()
        for space in self._public_way():
            self._public.add(space)

    @property
    def objects(self) -> list[PlacedObject]:
        """The placed objects on the ground, in the order of placement."""
        if len(self._objects) < len(self._placed):
            self._objects += self._on_ground(self._placed[len(self._objects) :])
        return self._objects

    def place(
        self,
        kind: str,
        along: float,
        across: float,
        size: tuple[float, float, float],
        *,
        angle: float = 0.0,
        clearance: float = 0.0,
        margin: float = 0.15,
        private: bool = False,
    ) -> bool:
        """Place an object turned by `angle` against the road; returns False unless `margin` [m] around it is free.

        A `private` object keeps off the road and the sidewalks.
        """
        if kind in self.denied or not self.ground.reaches(along, across):
            return False
        x, y, heading = self.road.at(along, across)
        yaw = math.remainder(heading + angle, 2 * math.pi)
        spaces = kind_of(kind).solids((x, y, yaw), size, clearance)
        for space in spaces:
            if any(self._occupied.touching(space, margin)) or (private and any(self._public.touching(space))):
                return False
        for space in spaces:
            self._occupied.add(space)
        self._names[kind] += 1
        count = kind_of(kind).instances
        instance = self._instances + 1 if count else 0
        self._instances += count
        self._placed.append(
            _Placement(kind, self._names[kind], instance, along, across, x, y, yaw, angle, size, clearance)
        )
        return True

    def reserve(self, space: Solid) -> None:
        """Keep a space free from now on."""
        self._occupied.add(space)

    def keep_public(self, space: Solid) -> None:
        """Keep private objects off a space from now on."""
        self._public.add(space)

    def add_driveway(self, area: PavedArea) -> None:
        """Pave a driveway; private objects keep off it from now on."""
        self.ground.add_driveway(area)
        self._public.add(self._paved_space(area))

    def is_free(self, x: float, y: float, yaw: float, size: tuple[float, float, float]) -> bool:
        """Whether an upright box on the ground at x, y, yaw touches no object."""
        return not any(self._occupied.touching(Solid.box(x, y, yaw, size[:2], 0.0, size[2])))

    def is_private(self, x: float, y: float, yaw: float, size: tuple[float, float, float]) -> bool:
        """Whether an upright box on the ground at x, y, yaw keeps off the road and the sidewalks."""
        return not any(self._public.touching(Solid.box(x, y, yaw, size[:2], 0.0, size[2])))

    def _on_ground(self, placed: list[_Placement]) -> list[PlacedObject]:
        """The objects at their heights."""
        places = np.array([(p.along, p.across, p.angle) for p in placed])
        along, across, _ = places.T
        heights = self.ground.heights(along, across)
        drops = np.array([kind_of(p.kind).most_fall for p in placed])
        sunk = np.flatnonzero(np.isfinite(drops))
        if len(sunk):
            lowest = self._lowest_ground(places[sunk], np.array([placed[index].size[:2] for index in sunk]))
            heights[sunk] = np.minimum(heights[sunk], lowest + drops[sunk])
        levels = self.ground.levels(along, across)
        return [
            PlacedObject(
                kind=p.kind, id=f"{p.kind}_{p.number}", x=p.x, y=p.y, z=z, level=level, yaw=p.yaw, size=p.size,
                clearance=p.clearance, instance=p.instance,
            )
            for p, z, level in zip(placed, heights.tolist(), levels.tolist(), strict=True)
        ]  # fmt: skip

    def _lowest_ground(self, places: np.ndarray, sizes: np.ndarray) -> np.ndarray:
        """The lowest ground [n] under the corners of footprints of `sizes` [n, 2] at along, across and angle [n, 3]."""
        half = sizes[:, None] * np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) / 2
        along, across, angle = places.T[..., None]
        cos, sin = np.cos(angle), np.sin(angle)
        along = along + half[..., 0] * cos - half[..., 1] * sin
        across = across + half[..., 0] * sin + half[..., 1] * cos
        lowest: np.ndarray = self.ground.heights(along.ravel(), across.ravel()).reshape(-1, 4).min(axis=1)
        return lowest

    def _public_way(self) -> list[Solid]:
        road = self.road
        spaces = []
        pieces = math.ceil(2 * road.half_length / _PUBLIC_PIECE)
        step = 2 * road.half_length / pieces
        for number in range(pieces):
            x, y, yaw = road.at((number + 0.5) * step - road.half_length, 0.0)
            # the outer edge of a bend is longer
            length = step * (1 + abs(road.curvature) * road.verge)
            spaces.append(Solid.box(x, y, yaw, (length, 2 * road.verge), -_PUBLIC_DEPTH, _HEADROOM))
        if road.junction is not None:
            for side in road.side_roads:
                across = (road.verge + road.half_length) / 2 * side
                x, y, yaw = road.at(road.junction, across)
                spaces.append(Solid.box(x, y, yaw, (2 * road.verge, road.half_length), -_PUBLIC_DEPTH, _HEADROOM))
            if road.roundabout_radius is not None:
                x, y, yaw = road.at(road.junction, 0.0)
                outer = road.roundabout_radius + road.sidewalk
                # bars that together cover the disc
                angles = [math.radians(_BAR * number) for number in range(90 // _BAR + 1)]
                for low, high in itertools.pairwise(angles):
                    size = (2 * math.cos(low) * outer, 2 * math.sin(high) * outer)
                    spaces.append(Solid.box(x, y, yaw, size, -_PUBLIC_DEPTH, _HEADROOM))
        spaces += [self._paved_space(area) for area in road.paved_areas]
        return spaces

    def _paved_space(self, area: PavedArea) -> Solid:
        length, width = area.along[1] - area.along[0], area.across[1] - area.across[0]
        x, y, yaw = self.road.at(sum(area.along) / 2, sum(area.across) / 2)
        return Solid.box(x, y, yaw, (length, width), -_PUBLIC_DEPTH, _HEADROOM)
