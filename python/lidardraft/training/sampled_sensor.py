"""Random sensors, so that one network learns to serve all."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from lidardraft.diffusion.sensor_limits import SensorLimits
from lidardraft.scene.sensor import PRESETS, Sensor

ROWS = (16, 20, 24, 32, 40, 48, 64, 80, 96, 128)
COLUMNS = (512, 768, 1024, 1200, 1440, 1800, 2048)
MOUNTS = (1.0, 3.0)  # m
ELEVATIONS = (math.radians(-48.0), math.radians(48.0))
SPACING = math.radians(0.16)  # of the closest beams
# A network trained on these sensors works within these limits.
LIMITS = SensorLimits(
    beams=(ROWS[0], ROWS[-1]),
    columns=(COLUMNS[0], COLUMNS[-1]),
    elevation=(math.degrees(ELEVATIONS[0]), math.degrees(ELEVATIONS[1])),
    mount_height=MOUNTS,
)
_PRESET_SHARE = 0.5
_SECTOR_SHARE = 0.1
_LARGEST = 128 * 1024  # pixels


def sample_sensor(rng: np.random.Generator) -> Sensor:
    """A preset with other columns and mount, or a table of beams of no existing sensor; each time another unit."""
    name = str(rng.choice(sorted(PRESETS)))
    preset = PRESETS[name]
    elevations = preset.elevations if rng.random() < _PRESET_SHARE else _sample_elevations(rng)
    offsets = preset.azimuth_offsets if elevations is preset.elevations else ()
    columns = int(rng.choice([c for c in COLUMNS if c * len(elevations) <= _LARGEST]))
    span = 2 * math.pi
    if rng.random() < _SECTOR_SHARE:
        span = math.radians(rng.uniform(90, 200))
        columns = round(columns * span / (2 * math.pi) / 8) * 8
    sensor = Sensor(
        name="sampled",
        elevations=elevations,
        azimuth_offsets=offsets,
        columns=columns,
        azimuth_start=span / 2,
        azimuth_span=span,
        min_range=float(rng.uniform(0.3, 1.5)),
        max_range=float(rng.uniform(70, 200)),
        mount_height=float(rng.uniform(*MOUNTS)),
        range_sigma=float(np.exp(rng.uniform(np.log(0.002), np.log(0.03)))),
    )
    return _with_model(sensor, name, rng)


def _sample_elevations(rng: np.random.Generator) -> tuple[float, ...]:
    """Beams in equal steps, in two blocks, or closer together about the horizon, from the highest."""
    rows = int(rng.choice(ROWS))
    high, low = math.radians(rng.uniform(1, 25)), math.radians(rng.uniform(-35, -14))
    density = np.ones(512)
    place = np.linspace(high, low, 512)
    kind = rng.integers(3)
    if kind == 1:
        density[place < rng.uniform(0.7 * low, 0.2 * low)] = rng.uniform(0.4, 0.8)
    elif kind == 2:
        density += rng.uniform(1, 6) * np.exp(-(((place + math.radians(2)) / math.radians(rng.uniform(3, 8))) ** 2))
    share = np.cumsum(density)
    elevations = np.interp(np.linspace(share[0], share[-1], rows), share, place)
    closest = float(np.min(-np.diff(elevations)))
    if closest < SPACING:  # the same beams over a wider span, as far as possible
        middle = (high + low) / 2
        room = min((limit - middle) / (end - middle) for limit, end in zip(ELEVATIONS, (low, high), strict=True))
        elevations = middle + (elevations - middle) * min(SPACING / closest, 2.0, room)
    return tuple(np.clip(elevations, *ELEVATIONS).tolist())  # for values that rounding moves outside


def _with_model(sensor: Sensor, name: str, rng: np.random.Generator) -> Sensor:
    """The sensor with constants around those of a preset: its optics, its noise, its dropped returns and its
    readings."""
    preset = PRESETS[name]
    model = (preset if sensor.elevations == preset.elevations else sensor).assumed_model

    def about(value: float, factor: float) -> float:
        return float(value * np.exp(rng.uniform(-1, 1) * math.log(factor)))

    model = dataclasses.replace(
        model,
        detection_threshold=about(model.detection_threshold, 3.0),
        drop_exponent=float(np.exp(rng.uniform(np.log(1e-4), np.log(0.03)))),
        fading=about(model.fading, 1.3),
        speckle=about(model.speckle, 2.0),
        jitter=about(model.jitter, 2.0),
        unit=int(rng.integers(1 << 30)),
        gain_spread=about(model.gain_spread, 2.0),
        full_scale=about(model.full_scale, 1.5),
    )
    return dataclasses.replace(sensor, model=model)
