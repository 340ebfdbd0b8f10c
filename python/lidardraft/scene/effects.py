"""From clean returns to the returns that a real sensor reports: `observe` applies the effects of a `SensorModel`.

The effects are in the core, `rust/core/sensor_model/effects.rs` and `receiver.rs`: one function for each, in the order
in which light meets them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from lidardraft import _core
from lidardraft.errors import SensorError, check_seed
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import as_array
from lidardraft.scene.range_image import IMAGES, RangeImage, blank_pixels, images_of
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel, beam_fan
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather, first_particle, fog_echo

_TILT_STREAM = 3  # the stream of random numbers for the beam tilts of a unit
_OBSERVED = ("depth", "intensity", "incidence", "instance", "primitive", "label")


def observe(
    image: RangeImage,
    layout: Layout | Surfaces,
    *,
    seed: int | np.random.Generator,
    sensor: Sensor | None = None,
    model: SensorModel | None = None,
    weather: Weather | None = None,
    poses: np.ndarray | None = None,
    threads: int | None = None,
) -> RangeImage:
    """The scan that `sensor` reports from a clean cast of `layout`, with intensity, primitive and incidence.

    `image` is a cast of `sub_rays(sensor, model)` with primitive and incidence. It may also be a cast of the sensor
    itself, with one ray a beam; then `sensor` may be left out. `model` is by default `sensor.assumed_model`. If a
    layout is scanned often, pass `Surfaces.from_layout(layout)`, made once, instead of it; it includes the wetness of
    the ground.

    `poses` are those of the cast: world_from_sensor [4, 4], or [W, 4, 4] with one for each column. The response of a
    surface varies with the place in the world, which by default is the sensor's frame. `threads` is the largest number
    of threads, by default the number of cores; the scan is the same for any number.

    Raises `SensorError` for an image of another sensor or without primitive and incidence.
    """
    rng = seed if isinstance(seed, np.random.Generator) else np.random.Generator(np.random.SFC64(check_seed(seed)))
    weather = weather or Weather()
    model = model or (sensor or image.sensor).assumed_model
    if sensor is None:
        sensor, model = image.sensor, _one_ray(model)
    else:
        rays = sub_rays(sensor, model)
        if image.sensor is not rays and image.sensor != rays:
            raise SensorError(f"the image is of {image.sensor.name}; sub_rays of {sensor.name} are {rays.name}")
    if image.primitive is None or image.incidence is None:
        raise SensorError("the image lacks primitive or incidence; cast it with primitive=True, incidence=True")
    poses = np.eye(4) if poses is None else poses
    poses = as_array("poses", poses, *("W" * (np.ndim(poses) - 2)), 4, 4).reshape(1, -1, 4, 4)
    scan = RangeImage.unchecked(sensor, **{name: np.empty(sensor.shape, IMAGES[name]) for name in _OBSERVED})
    _core.observe(
        image,
        layout if isinstance(layout, Surfaces) else Surfaces.from_layout(layout, wetness=weather.wetness),
        rays=image.sensor.pattern,
        poses=poses,
        pattern=sensor.pattern,
        range_sigma=sensor.range_sigma,
        model=model.core,
        extinction=weather.extinction,
        backscatter=_backscatter(weather, sensor, model, rng) if weather.scatters else [],
        scan=scan,
        seed=int(rng.bit_generator.random_raw()) >> 1,
        threads=threads or 0,
    )
    if sensor.blocked:  # fog echoes without a hit, and other casts ignore the vehicle
        blank_pixels(images_of(scan), sensor.blocked_pixels)
    return scan


@lru_cache(maxsize=32)
def sub_rays(sensor: Sensor, model: SensorModel) -> Sensor:
    """The sensor whose beams are the sub-rays of `sensor`: row h * S + s is sub-ray s of beam h.

    Cast this sensor, and pass the image to `observe` with `sensor`. Sub-rays spread in azimuth, not across the beam, so
    that beams share their columns: at elevation e they are cos(e) closer. They follow the beams of the unit, which
    differ a little from the table by which `observe` places the returns. Raises `SensorError` if the beams of `sensor`
    are so close that their sub-rays would cross.
    """
    if model.rays_per_beam == 1 and not model.tilt_spread:
        return sensor
    fan = beam_fan(model)
    beams = len(sensor.elevations)
    elevations = np.add.outer(sensor.elevations, fan[:, 1])
    elevations = (elevations + beam_tilts(sensor, model)[:, None]).ravel()
    if (np.diff(elevations) >= 0).any():
        closest = -np.diff(sensor.elevations).max()
        raise SensorError(
            f"{sensor.name}: beams {1e3 * closest:.2f} mrad apart overlap at a divergence of "
            f"{1e3 * model.divergence_v:.2f} mrad; rays_per_beam must be 1"
        )
    offsets = np.add.outer(sensor.azimuth_offsets or np.zeros(beams), fan[:, 0]).ravel()
    tables = ("blocked", "origin_forwards", "origin_lefts", "origin_heights")
    repeated: dict[str, Any] = {
        table: tuple(value for value in getattr(sensor, table) for _ in fan) for table in tables
    }
    return replace(
        sensor,
        name=f"{sensor.name} x {model.rays_per_beam}",
        model=None,
        elevations=tuple(elevations.tolist()),
        azimuth_offsets=tuple(offsets.tolist()),
        **repeated,
    )


def beam_tilts(sensor: Sensor, model: SensorModel) -> np.ndarray:
    """The angle [rad] by which each beam of this unit points higher than its sensor's table states: f64 [H].

    `tilt_spread` holds for beams a degree or more apart; the tilts of closer beams shrink in proportion.
    """
    steps = -np.diff(sensor.elevations)
    step = np.minimum(np.append(steps, np.inf), np.append(np.inf, steps))
    sampled = np.random.default_rng([model.unit, _TILT_STREAM]).standard_normal(len(step))
    tilts: np.ndarray = np.clip(sampled, -2.5, 2.5) * model.tilt_spread * np.minimum(step / math.radians(1.0), 1.0)
    return tilts


@lru_cache(maxsize=32)
def _one_ray(model: SensorModel) -> SensorModel:
    return replace(model, rays_per_beam=1)


def _backscatter(
    weather: Weather, sensor: Sensor, model: SensorModel, rng: np.random.Generator
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Range and response, f32 [H, W], of the fog and of the first raindrop or snowflake in each beam."""
    width = (model.divergence_h, model.divergence_v)
    return [
        fog_echo(weather, model.pulse_length, sensor.shape, rng),
        first_particle(weather, width, sensor.shape, rng),
    ]
