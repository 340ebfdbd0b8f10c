"""Sequences: scans of a layout in which the ego vehicle and objects move, frame by frame.

A body that moves while it is swept is cast in its own frame, in which it rests and the sensor moves once more: each
column sees it exactly where it is at that moment. What stands is cast at once, and the nearer return counts.
"""

from __future__ import annotations

import dataclasses
import itertools
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
from lidardraft.scene.edit import moved_part
from lidardraft.scene.effects import sub_rays
from lidardraft.scene.layout import Layout, Primitive, box_around, object_of
from lidardraft.scene.pose import upright
from lidardraft.scene.range_image import RangeImage, images_of
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.scanner import Scanner
from lidardraft.scene.scenario import Scenario, Track
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.weather import Weather, weather_of
from lidardraft.simulation.roads import with_known_roads
from lidardraft.simulation.simulate import prepared
from lidardraft.simulation.tracks import tracks_of

_SECTORS = 32  # of a sweep, of which a body is cast in those that it may be seen in
_FLASH = 1e-3  # s over which rates are taken where a sweep takes no time
_MARGIN = 0.5  # m around a body: lasers do not start in the middle of the sensor
_LONGEST = 1000.0  # s, of which the traffic is known within a minute


@dataclass(frozen=True, slots=True, eq=False)
class _Mover:
    """A body that moves: its caster, with the index of its first primitive in all of them, where it stands in the
    layout, its track, and the radius of a circle around it [m]."""

    name: str
    caster: Raycaster
    first: int
    home: tuple[float, float, float, float]
    track: Track
    radius: float


class SequenceSimulator:
    """A layout, or that of a sentence in its street, made ready to be scanned while it moves as `scenario` says.

    It gives `frames` scans one after the other, of sweeps of which `hz` begin in a second. `speed` [m/s] is that of the
    ego vehicle where the scenario does not say how it moves; by default that of the road. `seed` decides the world: the
    layout of a sentence, details, brightness, and how far rays get into foliage; noise and drop are drawn anew for each
    frame. The rest is as in `Simulator`. `tracks` are those of all that moves.

    Raises `LayoutError` where the scenario cannot be (`tracks_of`), `SensorError` on an `hz` at which sweeps overlap.
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
        threads: int | None = None,
    ) -> None:
        _check_rate(sensor, frames, hz)
        self.frames, self.hz, self.seed = frames, hz, check_seed(seed)
        layout, scene, self._assumed = prepared(layout, seed, detail)
        self.layout = with_known_roads(layout)
        self.tracks = tracks_of(self.layout, scenario or Scenario(), (frames - 1) / hz + sensor.sweep_time, speed)
        still = list[Primitive]()
        parts: dict[str, list[Primitive]] = {name: [] for name in self.tracks.actors}
        for primitive in scene:
            parts.get(object_of(primitive), still).append(primitive)
        # those that stand come first, so that their casts name them by their numbers in the whole
        whole = Layout((*still, *(p for some in parts.values() for p in some)))
        weather = weather or weather_of(self.layout.intent.weather)
        self._scanner = Scanner.from_layout(whole, sensor, model=model, weather=weather, by_id=True, threads=threads)
        self._still = dataclasses.replace(self._scanner, caster=Raycaster(Layout(tuple(still)), by_id=True))
        self._movers, first = list[_Mover](), len(still)
        for name, some in parts.items():
            self._movers.append(self._mover(name, some, first))
            first += len(some)
        self._sectors = _sectors(sub_rays(sensor, self._scanner.model))

    def _mover(self, name: str, parts: list[Primitive], first: int) -> _Mover:
        box = box_around([p for p in self.layout if object_of(p) == name])
        caster, radius = Raycaster(Layout(tuple(parts)), by_id=True), math.hypot(*box.size) / 2 + _MARGIN
        return _Mover(name, caster, first, (*box.center, box.yaw), self.tracks.actors[name], radius)

    def __iter__(self) -> Iterator[Scan]:
        return (self.frame(number) for number in range(self.frames))

    def time(self, number: int) -> float:
        """When the middle of the sweep of a frame is [s]; the first sweep begins at 0."""
        return number / self.hz + self._scanner.sensor.sweep_time / 2

    def pose(self, number: int) -> np.ndarray:
        """world_from_sensor [4, 4] in the middle of the sweep of a frame."""
        x, y, z, yaw = self.tracks.ego.at(np.array([self.time(number)]))[0].tolist()
        return upright((x, y, z + self._scanner.sensor.mount_height), yaw)

    def frame(self, number: int) -> Scan:
        """The scan of frame `number`, whose noise has the seed `seed` + `number`; its layout is that in the middle of
        the sweep."""
        (speed, turn), moved = self._ego_rate(number), self._moved(number)
        return Scan(
            image=self._scanner.observe(self.cast(number), self.seed + number),
            layout=self._layout({mover.name: tuple(place.tolist()) for mover, place, _ in moved}),
            pose=self.pose(number),
            seed=self.seed + number,
            speed=speed,
            turn=turn,
            time=self.time(number),
            velocities={mover.name: tuple(rate[:3].tolist()) for mover, _, rate in moved},
            assumed=self._assumed,
        )

    def cast(self, number: int) -> RangeImage:
        """The clean returns of all sub-rays (`Scanner.cast`) in the sweep of a frame."""
        (speed, turn), pose = self._ego_rate(number), self.pose(number)
        poses = self._scanner.sensor.poses_in_motion(pose, speed * pose[:3, 0], (0.0, 0.0, turn))
        clean = self._still.cast(poses, self.seed)
        for mover, place, rate in self._moved(number):
            self._add(clean, mover, place, rate, poses, abs(turn) * self._scanner.sensor.sweep_time / 2)
        return clean

    def _ego_rate(self, number: int) -> tuple[float, float]:
        """How fast the ego vehicle drives ahead [m/s] and turns [rad/s] in the sweep of a frame."""
        rate = self.tracks.ego.rate(self.time(number), self._span)
        return float(rate[:3] @ self.pose(number)[:3, 0]), float(rate[3])

    def _moved(self, number: int) -> list[tuple[_Mover, np.ndarray, np.ndarray]]:
        """All that moves, with its place in the middle of the sweep of a frame, and its rate in it."""
        time = self.time(number)
        at = np.array([time])
        return [(mover, mover.track.at(at)[0], mover.track.rate(time, self._span)) for mover in self._movers]

    @property
    def _span(self) -> float:
        return max(self._scanner.sensor.sweep_time, _FLASH)

    def _add(
        self, clean: RangeImage, mover: _Mover, place: np.ndarray, rate: np.ndarray, poses: np.ndarray, turned: float
    ) -> None:
        """Add a body, at `place` in the middle of the sweep, to the cast of what stands, where it is nearer; `turned`
        is how far the sensor looks aside from there [rad] when the sweep begins and ends."""
        sensor, pose = self._scanner.sensor, poses[len(poses) // 2]
        off, travelled = place[:2] - pose[:2, 3], float(np.hypot(*(poses[-1, :2, 3] - poses[0, :2, 3])))
        reach = mover.radius + travelled + float(np.hypot(*rate[:2])) * sensor.sweep_time
        distance = math.hypot(*off)
        if distance - reach > sensor.max_range:
            return
        half = math.pi if distance <= reach else math.asin(reach / distance)
        bearing = math.atan2(off[1], off[0]) - math.atan2(pose[1, 0], pose[0, 0])
        for sector in self._sectors:
            if abs(math.remainder(sector.middle - bearing, math.tau)) > half + sector.half + turned:
                continue
            columns = slice(sector.first, sector.first + sector.rays.columns)
            since = sensor.column_times()[columns] - sensor.sweep_time / 2
            seen = _in_frame(mover.home, place + since[:, None] * rate, poses[columns])
            cast = mover.caster.scan(
                sector.rays, poses=seen, primitive=True, incidence=True, seed=self.seed, threads=self._scanner.threads
            )
            assert cast.primitive is not None
            cast.primitive[...] += mover.first
            before = clean.depth[:, columns]
            nearer = (cast.depth > 0) & ((before == 0) | (cast.depth < before))
            for name, whole in images_of(clean).items():
                np.copyto(whole[:, columns], getattr(cast, name), where=nearer)

    def _layout(self, places: dict[str, tuple[float, float, float, float]]) -> Layout:
        """The layout with all that moves at its place, x, y, z and yaw."""
        homes = {mover.name: mover.home for mover in self._movers}
        primitives = list(self.layout)
        for number, primitive in enumerate(primitives):
            if (name := object_of(primitive)) in places:
                home, (*by, turn) = homes[name], np.subtract(places[name], homes[name]).tolist()
                primitives[number] = moved_part(primitive, home[:2], (by[0], by[1], by[2]), turn)
        return dataclasses.replace(self.layout, primitives=tuple(primitives))

    def save_tracks(self, folder: str | os.PathLike[str]) -> None:
        """Write poses.txt, world_from_sensor of each frame as a row of 12 numbers, times.txt [s], and tracks.json, a
        scenario of way-points that moves everything so again."""
        numbers = range(self.frames)
        poses = "".join(" ".join(f"{n:.9g}" for n in self.pose(number)[:3].flat) + "\n" for number in numbers)
        times = "".join(f"{self.time(number):.6f}\n" for number in numbers)
        for name, text in zip(TRACK_FILES, (poses, times, self.tracks.scenario().to_json()), strict=True):
            write_text(Path(folder) / name, text)


@dataclass(frozen=True, slots=True, eq=False)
class _Sector:
    """Some columns of a sweep: the `rays` of them, the number of the `first`, and where they look [rad]: the `middle`,
    and how far to either side at most."""

    rays: Sensor
    first: int
    middle: float
    half: float


def _sectors(rays: Sensor) -> list[_Sector]:
    step, aside = rays.azimuth_span / rays.columns, max(map(abs, rays.azimuth_offsets), default=0.0)
    ends = np.linspace(0, rays.columns, min(_SECTORS, rays.columns) + 1).astype(int).tolist()
    found = []
    for first, end in itertools.pairwise(ends):
        start, span = rays.azimuth_start - first * step, (end - first) * step
        some = dataclasses.replace(rays, columns=end - first, azimuth_start=start, azimuth_span=span)
        found.append(_Sector(some, first, start - span / 2, span / 2 + aside + step))
    return found


def _in_frame(home: tuple[float, float, float, float], places: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """The poses [N, 4, 4] as a body that is at `places` [N, 4] sees them, for whom it is at home."""
    cos, sin = np.cos(places[:, 3]), np.sin(places[:, 3])
    back = np.zeros((len(places), 4, 4))
    back[:, 0, 0], back[:, 0, 1], back[:, 1, 0], back[:, 1, 1], back[:, 2, 2], back[:, 3, 3] = cos, sin, -sin, cos, 1, 1
    back[:, :3, 3] = -np.einsum("nij,nj->ni", back[:, :3, :3], places[:, :3])
    seen: np.ndarray = upright(home[:3], home[3]) @ back @ poses
    return seen


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
