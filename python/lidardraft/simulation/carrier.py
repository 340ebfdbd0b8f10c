"""The vehicle that carries a sensor: it hides the ground around itself, and a sensor over its roof sees it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from lidardraft.errors import LayoutError, SensorError, check_type
from lidardraft.scene.beam_tables import PANDAR64_HIDDEN, PANDAR64_LOST
from lidardraft.scene.effects import observe, sub_rays
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.pose import upright
from lidardraft.scene.range_image import RangeImage, images_of
from lidardraft.scene.raycast import Raycaster, raycast
from lidardraft.scene.sensor import PRESETS, Blocked, Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather
from lidardraft.simulation.detail.detail import detail

Spot = tuple[float, float, float, float]  # x, y, z [m] and yaw [rad] of an upright body
_NEAREST = 1e-3  # m: surfaces too near to be measured still occlude others
# The body of cars, and their length, width and height [m] as makers publish them: typical is a Volkswagen Passat, whose
# roof ends over the rear axle, so that the ground is hidden for 5 m behind; nuScenes' Renault Zoe; PandaSet's Chrysler
# Pacifica.
_CAR = ("saloon", (4.77, 1.82, 1.47))
_CARS = {"hdl32e": ("hatchback", (4.08, 1.73, 1.56)), "pandar64": ("minivan", (5.18, 2.02, 1.78))}
# Fitted by benches/fit_sensor.py: sectors hidden by car and equipment on its roof, and those without any return of
# them.
_FITTED = {"pandar64": (PANDAR64_HIDDEN, PANDAR64_LOST)}
_ALIKE = 0.2  # m between the height of a mount and that of a preset, at which the fitted sectors hold


@dataclass(frozen=True, slots=True, eq=False)
class Carried:
    """A sensor on its vehicle. `sensor` is blocked wherever that is in the way; `seeing` is open to its own returns.
    `vehicle` is None if its shape is unknown, and `notes` say if nothing is carried."""

    sensor: Sensor
    seeing: Sensor
    vehicle: Layout | None = None
    notes: tuple[str, ...] = ()


def with_vehicle(sensor: Sensor, vehicle: Layout | None = None, spot: Spot | None = None) -> Sensor:
    """The sensor with `blocked` set to the rays that meet `vehicle`, which is in the layout frame: the car stands over
    the origin. `spot` is the place of the sensor on it, by default its mount over the origin.

    `vehicle` is by default the typical car of the preset: its shape or, if recordings of one were fitted, the views
    that these lose. A sensor that is blocked already keeps its own. `detail(Layout((box,)))` makes a vehicle with a
    roof, a bonnet and windows from a box of class car. Raises `SensorError` if there is no typical car, `LayoutError`
    if the vehicle hides everything.
    """
    if vehicle is None:
        found = carried(sensor, True, spot)
        if found.notes:
            raise SensorError(found.notes[0])
        return found.sensor
    pose = sensor.pose() if spot is None else upright(spot[:3], spot[3])
    near = replace(sensor, min_range=_NEAREST, blocked=(), model=None)
    hidden = raycast(vehicle, near, pose).valid
    if hidden.all():
        x, y, z = pose[:3, 3].tolist()
        raise LayoutError(f"the vehicle hides every ray of {sensor.name} at ({x:g}, {y:g}, {z:g}) m; move one of them")
    step = sensor.azimuth_span / sensor.columns
    offsets = sensor.azimuth_offsets or (0.0,) * len(hidden)
    blocked = []
    for row, offset in zip(hidden, offsets, strict=True):
        changes = np.flatnonzero(np.diff(np.pad(row.astype(np.int8), 1)))
        starts, ends = sensor.azimuth_start + offset - step * changes.reshape(-1, 2)[:, ::-1].T
        blocked.append(tuple(zip(starts.tolist(), ends.tolist(), strict=True)))
    return replace(sensor, blocked=tuple(blocked))


def carried(sensor: Sensor, carrier: bool | Layout, spot: Spot | None = None) -> Carried:
    """The sensor at a `spot` of its `carrier`: a vehicle as in `with_vehicle`, the typical car (True) or none."""
    check_type("carrier", carrier, bool, Layout)
    if isinstance(carrier, Layout):
        if not carrier.primitives:
            raise LayoutError("carrier is an empty layout; it must have shapes, or be False for no vehicle")
        return Carried(with_vehicle(sensor, carrier, spot), sensor, carrier)
    if not carrier or sensor.blocked:
        return Carried(sensor, sensor)
    return _on_typical_car(sensor, spot or (0.0, 0.0, sensor.mount_height, 0.0))


@lru_cache(maxsize=32)
def _on_typical_car(sensor: Sensor, spot: Spot) -> Carried:
    if not sensor.is_preset:
        return Carried(sensor, sensor, notes=(f"{sensor.name} has no known vehicle: none is carried",))
    body, size = _CARS.get(sensor.name, _CAR)
    length, width, height = size
    if abs(spot[0]) < length / 2 and abs(spot[1]) < width / 2 and spot[2] <= height:
        said = f"{sensor.name} stands {spot[2]:g} m over the road, within its typical car of {height:g} m"
        return Carried(sensor, sensor, notes=(f"{said}: none is carried",))
    box = Primitive(shape="box", center=(0.0, 0.0, height / 2), size=size, label="car", id=f"{body}_1")
    car = detail(Layout((box,)))
    usual = (0.0, 0.0, PRESETS[sensor.name].mount_height, 0.0)
    if sensor.name in _FITTED and np.abs(np.subtract(spot, usual)).max() <= _ALIKE:
        hidden, lost = (replace(sensor, blocked=_blocked(sensor, table)) for table in _FITTED[sensor.name])
        return Carried(hidden, lost, car)
    return Carried(with_vehicle(sensor, car, spot), sensor, car)


def _blocked(sensor: Sensor, table: dict[int, tuple[tuple[float, float], ...]]) -> Blocked:
    rows = (table.get(row, ()) for row in range(len(sensor.elevations)))
    return tuple(tuple((math.radians(start), math.radians(end)) for start, end in row) for row in rows)


@dataclass(frozen=True, slots=True, eq=False)
class OwnReturns:
    """The clean returns of the vehicle, by all sub-rays of a sensor, and their surfaces. `hidden` bool [H, W] are the
    pixels that the vehicle is in the way of, `pose` is vehicle_from_sensor."""

    clean: RangeImage
    surfaces: Surfaces
    seeing: Sensor
    hidden: np.ndarray
    pose: np.ndarray

    @classmethod
    def of(cls, found: Carried, model: SensorModel, weather: Weather, spot: Spot | None) -> OwnReturns:
        """Raises `SensorError` without a vehicle, or if its shape is unknown."""
        if found.vehicle is None:
            raise SensorError(f"own_returns of {found.sensor.name} need the shape of its vehicle; give it as `carrier`")
        pose = found.sensor.pose() if spot is None else upright(spot[:3], spot[3])
        near = replace(found.seeing, min_range=_NEAREST)
        caster = Raycaster(found.vehicle, by_id=True)
        clean = caster.scan(sub_rays(near, model), pose, primitive=True, incidence=True)
        surfaces = Surfaces.from_layout(found.vehicle, wetness=weather.wetness, by_id=True)
        return cls(clean, surfaces, found.seeing, found.sensor.blocked_pixels, pose)

    def over(
        self,
        image: RangeImage,
        model: SensorModel,
        weather: Weather,
        seed: int | np.random.Generator,
        threads: int | None,
    ) -> RangeImage:
        """A scan with the returns of the vehicle: instance 0, and no primitive of the layout."""
        near = replace(self.seeing, min_range=_NEAREST)
        own = observe(
            self.clean, self.surfaces, seed=seed, sensor=near, model=model, weather=weather, poses=self.pose,
            threads=threads,
        )  # fmt: skip
        own.instance[...] = 0
        if own.primitive is not None:
            own.primitive[...] = -1
        seen = self.hidden & (own.depth >= self.seeing.min_range)
        for name, whole in images_of(image).items():
            np.copyto(whole, getattr(own, name), where=seen)
        return RangeImage.unchecked(self.seeing, **images_of(image))
