"""Sweeps of a sensor over standing and moving bodies: **the** engine of single scans, of sequences and of worlds.

A moving body is cast in its own frame, in which it rests and the sensor moves instead: each column sees it exactly in
its place at that moment. Standing bodies are cast together, and the nearer return counts.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lidardraft.errors import check_type
from lidardraft.scene.bodies import Bodies
from lidardraft.scene.effects import observe, sub_rays
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import upright
from lidardraft.scene.range_image import RangeImage, images_of
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather
from lidardraft.simulation.carrier import OwnReturns, carried
from lidardraft.simulation.carrier import Spot as Spot

FLASH = 1e-3  # s over which rates are taken if a sweep takes no time
_SECTORS = 32  # of a sweep: a body is cast in those that may see it
_MARGIN = 0.5  # m around a body: lasers do not start in the middle of the sensor


@dataclass(frozen=True, slots=True, eq=False)
class Mover:
    """A body that moves in a sweep: the index of its first primitive in the surfaces, its place when it was compiled,
    the radius of a circle around it [m], and its places in the world, f64 [W, 4], one for each column."""

    bodies: Bodies
    first: int
    home: Spot
    radius: float
    places: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class _Sector:
    """Some columns of a sweep, from `first` to before `end`, and their azimuths [rad]: the `middle`, and the largest
    distance from it, `half`."""

    first: int
    end: int
    middle: float
    half: float


@dataclass(frozen=True, eq=False)
class Sweeper:
    """A unit of a sensor in a weather. `threads` is the most threads of a scan; scans are the same for any.

    The vehicle that carries the sensor blocks it; `own` are its returns, if they are kept, and `notes` say if it is
    unknown. Sectors that may see a body are cast together or, as always in sequences, `apart`: the last bits of ranges
    depend on that.
    """

    sensor: Sensor
    model: SensorModel
    weather: Weather
    threads: int | None = None
    apart: bool = False
    own: OwnReturns | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        sensor: Sensor,
        model: SensorModel | None,
        weather: Weather | None,
        threads: int | None = None,
        apart: bool = False,
        *,
        carrier: bool | Layout = False,
        own_returns: bool = False,
        spot: Spot | None = None,
    ) -> Sweeper:
        """With a model, by default `sensor.assumed_model`, a weather, by default a clear and dry day, and a `carrier`
        as in `Simulator`, by default none, on which the sensor is at a `spot`, by default its mount."""
        check_type("weather", weather := Weather() if weather is None else weather, Weather)
        check_type("own_returns", own_returns, bool)
        found, model = carried(sensor, carrier, spot), model or sensor.assumed_model
        own = OwnReturns.of(found, model, weather, spot) if own_returns else None
        return cls(found.sensor, model, weather, threads, apart, own, found.notes)

    @cached_property
    def rays(self) -> Sensor:
        """The sensor of all sub-rays."""
        return sub_rays(self.sensor, self.model)

    @cached_property
    def _sectors(self) -> list[_Sector]:
        rays = self.rays
        step, aside = rays.azimuth_span / rays.columns, max(map(abs, rays.azimuth_offsets), default=0.0)
        ends = np.linspace(0, rays.columns, min(_SECTORS, rays.columns) + 1).astype(int).tolist()
        found = []
        for first, end in itertools.pairwise(ends):
            span = (end - first) * step
            found.append(_Sector(first, end, rays.azimuth_start - first * step - span / 2, span / 2 + aside + step))
        return found

    @cached_property
    def _columns(self) -> dict[tuple[int, int], Sensor]:
        return {(0, self.rays.columns): self.rays}

    def _between(self, first: int, end: int) -> Sensor:
        """The sensor of the columns from `first` to before `end`."""
        if (first, end) not in self._columns:
            step = self.rays.azimuth_span / self.rays.columns
            start, span = self.rays.azimuth_start - first * step, (end - first) * step
            some = dataclasses.replace(self.rays, columns=end - first, azimuth_start=start, azimuth_span=span)
            self._columns[first, end] = some
        return self._columns[first, end]

    def cast(self, still: Bodies, movers: Iterable[Mover], poses: np.ndarray, seed: int) -> RangeImage:
        """The clean returns of all sub-rays from world_from_sensor `poses`: one [4, 4], or one for each column
        [W, 4, 4], which movers need."""
        clean = still.scan(self.rays, poses, seed, self.threads)
        if not (movers := tuple(movers)):
            return clean
        looks, middle = np.unwrap(np.arctan2(poses[:, 1, 0], poses[:, 0, 0])), len(poses) // 2
        turned = float(np.abs(looks - looks[middle]).max())
        strayed = float(np.hypot(*(poses[:, :2, 3] - poses[middle, :2, 3]).T).max())
        for mover in movers:
            for columns in self._seen(mover, poses[middle], float(looks[middle]), turned, strayed):
                self._add(clean, mover, poses, seed, columns)
        return clean

    def scan(self, still: Bodies, poses: np.ndarray, seed: int) -> RangeImage:
        """The image that the sensor reports of standing bodies from these poses."""
        return self.observe(self.cast(still, (), poses, seed), still.surfaces, poses, seed)

    def observe(
        self, clean: RangeImage, surfaces: Surfaces, poses: np.ndarray, seed: int | np.random.Generator
    ) -> RangeImage:
        """The image that the sensor reports of a `clean` one that `cast` returned from these `poses`."""
        image = observe(
            clean,
            surfaces,
            seed=seed,
            sensor=self.sensor,
            model=self.model,
            weather=self.weather,
            poses=poses,
            threads=self.threads,
        )
        return image if self.own is None else self.own.over(image, self.model, self.weather, seed, self.threads)

    def _seen(self, mover: Mover, pose: np.ndarray, looks: float, turned: float, strayed: float) -> Iterator[slice]:
        """The columns that may see a body. The sensor is at `pose` in the middle of the sweep; it turns by up to
        `turned` [rad] from its heading `looks` there, and moves up to `strayed` [m] away."""
        place = mover.places[len(mover.places) // 2]
        off = place[:2] - pose[:2, 3]
        reach, distance = mover.radius + strayed + np.hypot(*(mover.places - place)[:, :2].T).max(), math.hypot(*off)
        if distance - reach > self.sensor.max_range:
            return
        reached = turned + (math.pi if distance <= reach else math.asin(reach / distance))
        bearing = math.atan2(off[1], off[0]) - looks

        def may_see(sector: _Sector) -> int:
            seen = abs(math.remainder(sector.middle - bearing, math.tau)) <= reached + sector.half
            return seen * (sector.end if self.apart else 1)

        for seen, some in itertools.groupby(self._sectors, may_see):
            if seen:
                sectors = list(some)
                yield slice(sectors[0].first, sectors[-1].end)

    def _add(self, clean: RangeImage, mover: Mover, poses: np.ndarray, seed: int, columns: slice) -> None:
        """Add a body to the cast of the standing bodies in the pixels in which it is nearer."""
        seen = _in_frame(mover.home, mover.places[columns], poses[columns])
        cast = mover.bodies.scan(self._between(columns.start, columns.stop), seen, seed, self.threads)
        assert cast.primitive is not None
        before = clean.depth[:, columns]
        nearer = (cast.depth > 0) & ((before == 0) | (cast.depth < before))
        if nearer.any():
            cast.primitive[...] += mover.first
            for name, whole in images_of(clean).items():
                np.copyto(whole[:, columns], getattr(cast, name), where=nearer)


def radius_of(size: tuple[float, float, float]) -> float:
    """The radius [m] of the circle that a mover needs around a body of a `size` (length, width, height) [m]."""
    return math.hypot(*size) / 2 + _MARGIN


def _in_frame(home: Spot, places: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """The poses [N, 4, 4] in the frame in which a body at `places` [N, 4] is at `home`."""
    cos, sin = np.cos(places[:, 3]), np.sin(places[:, 3])
    back = np.zeros((len(places), 4, 4))
    back[:, 0, 0], back[:, 0, 1], back[:, 1, 0], back[:, 1, 1], back[:, 2, 2], back[:, 3, 3] = cos, sin, -sin, cos, 1, 1
    back[:, :3, 3] = -np.einsum("nij,nj->ni", back[:, :3, :3], places[:, :3])
    seen: np.ndarray = upright(home[:3], home[3]) @ back @ poses
    return seen
