"""Edits of a world by name and place, each of which can be undone: `Editor`."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from lidardraft.errors import check_that
from lidardraft.scan import Scan
from lidardraft.scene.box import Box
from lidardraft.scene.layout import AROUND, Layout, Primitive, box_around, object_of
from lidardraft.scene.pose import in_frame, place_around, point_at
from lidardraft.scene.scenario import AlongLane
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.weather import Weather
from lidardraft.studio.document import Document
from lidardraft.world.rig import Mount, Rig
from lidardraft.world.state import EGO_NAME, WorldState
from lidardraft.world.world import World

_LANE_NEAR = 2.5  # m from the middle of a lane: nearer things snap to it
_QUICK_PIXELS = 40_000  # of a quick scan
_APART = 1.0  # m between a thing and its duplicate


class Editor:
    """One world and its document. An edit that raises leaves both unchanged; only one thread at a time may use it."""

    def __init__(
        self, source: Layout | WorldState, sensors: Sequence[Sensor], *, seed: int = 0, weather: Weather | None = None
    ) -> None:
        self.world = _world(source, tuple(sensors), weather, seed)
        self._quick: World | None = None
        self.document = Document((self.world.state(),), tuple(sensors), weather)

    def begin(self, source: Layout | WorldState, seed: int) -> None:
        """Replace the scene by another one; undo brings it back."""
        world = _world(source, self.document.sensors, self.document.weather, seed)
        document = self.document.edited(world.state())
        self.world, self.document = world, dataclasses.replace(document, played=(), position=0)

    def equip(self, sensors: Sequence[Sensor], weather: Weather | None) -> None:
        """Keep the scene, with other sensors, in other weather."""
        self.world, self._quick = _world(self.world.state(), tuple(sensors), weather, 0), None
        self.document = dataclasses.replace(self.document, sensors=tuple(sensors), weather=weather)

    def scans(self) -> tuple[Scan, ...]:
        """The scans of the world by its sensors now."""
        return tuple(self.world.scans().values())

    def quick_scans(self) -> tuple[Scan, ...]:
        """The scans by the same sensors with fewer columns, in a fraction of the time."""
        if self._quick is None:
            sensors = tuple(map(_thinned, self.document.sensors))
            self._quick = _world(self.world.state(), sensors, self.document.weather, 0)
        self._quick.restore(self.world.state())
        return tuple(self._quick.scans().values())

    @property
    def names(self) -> tuple[str, ...]:
        """The ids of all objects: the requested ones, then the ego vehicle, then the surroundings."""
        ids = self.world.ids
        asked = [name for name in ids if not name.startswith(AROUND)]
        return (*asked, EGO_NAME, *(name for name in ids if name.startswith(AROUND)))

    def parts(self, name: str) -> list[Primitive]:
        """The shapes of an object in its current pose."""
        return [part for part in self.world.layout() if object_of(part) == name]

    def box(self, name: str) -> Box:
        """The box around an object in its current pose."""
        if name == EGO_NAME:
            (x, y, yaw), size = self.world.ego.pose, self.world.ego.size
            return Box(EGO_NAME, "car", 0, (x, y, size[2] / 2), size, yaw)
        box, (x, y, yaw) = box_around(self.parts(name)), self.world[name].pose
        return dataclasses.replace(box, id=name, center=(x, y, box.center[2]), yaw=yaw)

    def commit(self) -> None:
        """Make the current world the next state of the document."""
        self.document = self.document.edited(self.world.state())

    @contextmanager
    def _edit(self) -> Iterator[None]:
        before = self.world.state()
        try:
            yield
        except Exception:
            self.world.restore(before)
            raise
        self.commit()

    def move(self, name: str, x: float, y: float, yaw: float, *, snaps: bool = False) -> None:
        """Place an object at x, y [m] on the ground, with its current speed; `commit` ends a drag. `snaps` moves it to
        the middle of a near lane, along it."""
        roads = self.world.layout().roads if snaps else None
        if roads is not None and any(lane.kind == "driving" for lane in roads.lanes):
            lane, along, left = roads.nearest_lane(x, y, yaw=yaw)
            if abs(left) < _LANE_NEAR:
                (x, y, *_), yaw = lane.line.at(along), lane.line.heading(along)
        self.world.move(name, (x, y), yaw=yaw, speed=self.world[name].speed)

    def add(self, kind: str, x: float, y: float) -> str:
        """Add an object of a kind at x, y [m]; returns its id."""
        with self._edit():
            return self.world.add(kind, at=(x, y), speed=0.0)

    def duplicate(self, name: str) -> str:
        """Add a copy of an object beside it; returns the id of the copy."""
        parts, box = self.parts(name), self.box(name)
        stem = re.sub(r"_\d+$", "", name.removeprefix(AROUND))
        new = next(one for k in itertools.count(2) if (one := f"{stem}_{k}") not in self.world)
        parts = [dataclasses.replace(part, id=new + part.id[len(name) :]) for part in parts]
        at = point_at((*box.center[:2], box.yaw), 0.0, box.size[1] + _APART)
        with self._edit():
            return self.world.add(parts, at=at, speed=0.0)

    def remove(self, name: str) -> None:
        """Remove an object."""
        with self._edit():
            self.world.remove(_exactly(name))

    def resize(self, name: str, size: tuple[float, float, float]) -> None:
        """Give an object another length, width and height [m], on the ground at its place."""
        check_that(min(size) > 0.0, f"{name}: size", size, "three lengths over 0 m")
        box = self.box(name)
        factors = tuple(new / old for new, old in zip(size, box.size, strict=True))
        self._replace(name, [_scaled(part, box, factors) for part in self.parts(name)])

    def become(self, name: str, kind: str) -> None:
        """Replace an object by one of another kind, with the same id."""
        self._replace(name, kind)

    def _replace(self, name: str, what: str | list[Primitive]) -> None:
        (x, y, yaw), speed = self.world[name].pose, self.world[name].speed
        with self._edit():
            self.world.remove(_exactly(name))
            is_kind = isinstance(what, str)
            self.world.add(what, at=(x, y), yaw=yaw if is_kind else 0.0, speed=speed, id=name if is_kind else None)

    def set_speed(self, name: str, speed: float) -> None:
        """Set the speed of an object [m/s], along its lane if it is in one."""
        with self._edit():
            self.world[name].speed = speed

    def set_own_speed(self, speed: float) -> None:
        """Set the speed at which the ego vehicle arrives [m/s]."""
        x, y, yaw = self.world.ego.pose
        with self._edit():
            self.world.move(EGO_NAME, (x, y), yaw=yaw, speed=speed)

    def drive(self, name: str) -> None:
        """Make an object drive along its lane, by itself."""
        with self._edit():
            self.world[name].motion = AlongLane()

    def go(self, by: int) -> None:
        """Undo or redo `by` edits."""
        document = self.document.moved(by)
        self.world.restore(document.state)
        self.document = document

    def step(self, seconds: float) -> None:
        """Advance time; the state is on the time line at once, and becomes an edit with `commit`."""
        before = self.world.state()
        self.world.step(seconds)
        self.document = self.document.stepped(before, self.world.state())

    def show(self, position: int) -> None:
        """Go to a state of the time line."""
        document = self.document.at(position)
        if document.played:
            self.world.restore(document.played[document.position])
            self.document = document


def _thinned(sensor: Sensor) -> Sensor:
    every = math.ceil(math.prod(sensor.shape) / _QUICK_PIXELS)
    return dataclasses.replace(sensor, columns=max(sensor.columns // every, 1))


def _exactly(name: str) -> str:
    """The pattern that matches an id alone."""
    return re.sub(r"([*?\[])", r"[\1]", name)


def _world(source: Layout | WorldState, sensors: tuple[Sensor, ...], weather: Weather | None, seed: int) -> World:
    if isinstance(source, WorldState):
        seed = 0
    if len(sensors) == 1:
        return World(source, sensors[0], seed=seed, weather=weather)
    mounts = {
        f"{sensor.name} ({k})" if k else sensor.name: Mount(sensor, (0.0, 0.0, sensor.mount_height, 0.0))
        for k, sensor in enumerate(sensors)
    }
    return World(source, Rig(mounts), seed=seed, weather=weather)


def _scaled(part: Primitive, box: Box, factors: Sequence[float]) -> Primitive:
    """A part of the object in the box, with the whole enlarged by the factors along the axes of the box."""
    x, y, turn = in_frame((*part.center[:2], part.yaw), place_around((*box.center[:2], box.yaw)))
    along, across, up = factors
    x, y = point_at((*box.center[:2], box.yaw), x * along, y * across)
    cos, sin = math.cos(turn) ** 2, math.sin(turn) ** 2  # the closest extents for a part that is rotated in the box
    size = (
        part.size[0] * (cos * along + sin * across),
        part.size[1] * (sin * along + cos * across),
        part.size[2] * up,
    )
    z = box.center[2] + (part.center[2] - box.center[2]) * up
    return dataclasses.replace(part, center=(x, y, z), size=size)
