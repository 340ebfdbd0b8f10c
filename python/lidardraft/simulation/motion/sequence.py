"""Sequences: scans of a layout in which the ego vehicle and objects move, frame by frame."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lidardraft.errors import SensorError, as_int, check_seed
from lidardraft.files import write_text
from lidardraft.json_fields import is_number
from lidardraft.scan import TRACK_FILES, Scan
from lidardraft.scene.bodies import Bodies
from lidardraft.scene.check import objects
from lidardraft.scene.edit import moved_part
from lidardraft.scene.layout import Layout, box_around, object_of
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.scenario import Scenario, Track
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather, weather_of
from lidardraft.simulation.motion.motions import Ground
from lidardraft.simulation.motion.tracks import tracks_of
from lidardraft.simulation.roads import with_known_roads
from lidardraft.simulation.simulate import prepared
from lidardraft.simulation.sweeps import FLASH, Mover, Spot, Sweeper, radius_of
from lidardraft.simulation.wheels import is_level, on_wheels, sway, wheels_at

_LONGEST = 1000.0  # s, computed within a minute


@dataclass(frozen=True, slots=True, eq=False)
class _Actor:
    """A moving object: its name, its bodies, the index of their first primitive in the scene, its place in the layout,
    its track, and the radius of a circle around it [m]."""

    name: str
    bodies: Bodies
    first: int
    home: Spot
    track: Track
    radius: float


class SequenceSimulator:
    """A layout, or that of a sentence in its street, ready to be scanned while it moves as `scenario` says.

    It gives `frames` scans, of sweeps that begin at `hz` per second. `speed` [m/s] is that of the ego vehicle if the
    scenario leaves it open; by default that of the road. `seed` decides the world: the layout of a sentence, details,
    brightness, and how far rays get into foliage. Noise and drop are drawn anew for each frame. `scene`, if given, is
    scanned in place of the details of `layout`; its shapes have the names of their objects. The rest is as in
    `Simulator`. `tracks` are those of all moving objects.

    Raises `LayoutError` if the scenario is invalid (`tracks_of`), `SensorError` on an `hz` at which sweeps overlap.
    """

    def __init__(
        self,
        layout: Layout | str,
        sensor: Sensor,
        scenario: Scenario | None = None,
        *,
        frames: int = 100,
        hz: float = 10.0,
        speed: float | None = None,
        seed: int = 0,
        model: SensorModel | None = None,
        weather: Weather | None = None,
        detail: bool = True,
        relief: bool = True,
        carrier: bool | Layout = True,
        own_returns: bool = False,
        threads: int | None = None,
        scene: Layout | None = None,
    ) -> None:
        _check_rate(sensor, frames, hz)
        self.frames, self.hz, self.seed = frames, hz, check_seed(seed)
        layout, detailed, assumed = prepared(layout, seed, detail and scene is None, relief)
        scene = scene or detailed
        self.layout = with_known_roads(layout)
        self._ground = Ground(self.layout)
        self.tracks = tracks_of(self.layout, scenario or Scenario(), (frames - 1) / hz + sensor.sweep_time, speed)
        weather = weather or weather_of(self.layout.intent.weather)
        self._sweeper = Sweeper.of(
            sensor, model, weather, threads, apart=True, carrier=carrier, own_returns=own_returns
        )
        self._assumed = (*assumed, *self._sweeper.notes)
        still = list[int]()
        parts: dict[str, list[int]] = {name: [] for name in self.tracks.actors}
        for number, primitive in enumerate(scene):
            parts.get(object_of(primitive), still).append(number)
        # standing objects come first, so that their casts have their indices in the whole
        whole = Bodies.of(scene, self._sweeper.weather.wetness)
        self._still, self._actors = whole.some(still), list[_Actor]()
        given, first = objects(self.layout), len(still)
        for name, some in parts.items():
            box, track = box_around(given[name]), self.tracks.actors[name]
            home = (*box.center, box.yaw)
            self._actors.append(_Actor(name, whole.some(some), first, home, track, radius_of(box.size)))
            first += len(some)
        self._surfaces = Surfaces.joined([self._still.surfaces, *(actor.bodies.surfaces for actor in self._actors)])

    def __iter__(self) -> Iterator[Scan]:
        return (self.frame(number) for number in range(self.frames))

    def time(self, number: int) -> float:
        """The time of the middle of the sweep of a frame [s]; the first sweep begins at 0."""
        return number / self.hz + self._sweeper.sensor.sweep_time / 2

    def pose(self, number: int) -> np.ndarray:
        """world_from_sensor [4, 4] in the middle of the sweep of a frame. The ego vehicle leans as the ground under its
        wheels does, and sways on its springs; on level ground it stays upright."""
        time = self.time(number)
        x, y, z, yaw = self.tracks.ego.at(np.array([time]))[0].tolist()
        heights, label = self._ground.at(np.column_stack(wheels_at((x, y, yaw))))
        heights = np.where(label > 0, heights, z)
        pose = on_wheels((x, y, z), yaw, heights)
        if not is_level(heights):
            speed = math.hypot(*self.tracks.ego.rate(time, self._span)[:2])
            pose @= sway(time, speed, self.seed)
        pose[:3, 3] += self._sweeper.sensor.mount_height * pose[:3, 2]
        return pose

    def frame(self, number: int) -> Scan:
        """The scan of frame `number`; its noise has the seed `seed` + `number`, its layout is that in the middle of
        the sweep."""
        (speed, turn), moved = self._ego_rate(number), self._moved(number)
        return Scan(
            image=self._sweeper.observe(self.cast(number), self._surfaces, self._poses(number), self.seed + number),
            layout=self._layout({actor.name: tuple(place.tolist()) for actor, place, _ in moved}),
            pose=self.pose(number),
            seed=self.seed + number,
            speed=speed,
            turn=turn,
            time=self.time(number),
            velocities={actor.name: tuple(rate[:3].tolist()) for actor, _, rate in moved},
            assumed=self._assumed,
        )

    def cast(self, number: int) -> RangeImage:
        """The clean returns of all sub-rays in the sweep of a frame."""
        sensor = self._sweeper.sensor
        since = (sensor.column_times() - sensor.sweep_time / 2)[:, None]
        movers = [
            Mover(actor.bodies, actor.first, actor.home, actor.radius, place + since * rate)
            for actor, place, rate in self._moved(number)
        ]
        return self._sweeper.cast(self._still, movers, self._poses(number), self.seed)

    def _poses(self, number: int) -> np.ndarray:
        """world_from_sensor of each column of a frame, [W, 4, 4]."""
        (speed, turn), pose = self._ego_rate(number), self.pose(number)
        return self._sweeper.sensor.poses_in_motion(pose, speed * pose[:3, 0], (0.0, 0.0, turn))

    def _ego_rate(self, number: int) -> tuple[float, float]:
        """The ego vehicle's speed ahead [m/s] and yaw rate [rad/s] in the sweep of a frame."""
        rate = self.tracks.ego.rate(self.time(number), self._span)
        return float(rate[:3] @ self.pose(number)[:3, 0]), float(rate[3])

    def _moved(self, number: int) -> list[tuple[_Actor, np.ndarray, np.ndarray]]:
        """All moving objects, with their places in the middle of the sweep of a frame and their rates in it."""
        time = self.time(number)
        at = np.array([time])
        return [(actor, actor.track.at(at)[0], actor.track.rate(time, self._span)) for actor in self._actors]

    @property
    def _span(self) -> float:
        return max(self._sweeper.sensor.sweep_time, FLASH)

    def _layout(self, places: dict[str, tuple[float, float, float, float]]) -> Layout:
        """The layout with all moving objects at their `places`: x, y, z [m] and yaw [rad]."""
        homes = {actor.name: actor.home for actor in self._actors}
        primitives = list(self.layout)
        for number, primitive in enumerate(primitives):
            if (name := object_of(primitive)) in places:
                home, (*by, turn) = homes[name], np.subtract(places[name], homes[name]).tolist()
                primitives[number] = moved_part(primitive, home[:2], (by[0], by[1], by[2]), turn)
        return dataclasses.replace(self.layout, primitives=tuple(primitives))

    def save_tracks(self, folder: str | os.PathLike[str]) -> None:
        """Write poses.txt (world_from_sensor of each frame as a row of 12 numbers), times.txt [s], and tracks.json, a
        scenario of way-points that repeats all motions."""
        numbers = range(self.frames)
        poses = "".join(" ".join(f"{n:.9g}" for n in self.pose(number)[:3].flat) + "\n" for number in numbers)
        times = "".join(f"{self.time(number):.6f}\n" for number in numbers)
        for name, text in zip(TRACK_FILES, (poses, times, self.tracks.scenario().to_json()), strict=True):
            write_text(Path(folder) / name, text)


def _check_rate(sensor: Sensor, frames: int, hz: float) -> None:
    if (as_int(frames) or 0) < 1:
        raise SensorError(f"frames is {frames!r}; it must be a whole number of 1 or more")
    if not is_number(hz) or hz <= 0:
        raise SensorError(f"hz is {hz!r}; it must be a number over 0")
    if hz * sensor.sweep_time > 1 + 1e-9:
        rate = f"{1 / sensor.sweep_time:g}"
        raise SensorError(f"hz is {hz:g}; a sweep of {sensor.name} takes {sensor.sweep_time:g} s: at most {rate}")
    if frames / hz > _LONGEST:
        raise SensorError(f"{frames} frames at {hz:g} Hz are {frames / hz:g} s; a sequence has {_LONGEST:g} s at most")
