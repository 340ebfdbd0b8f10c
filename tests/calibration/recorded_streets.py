"""Recordings whose sensor is known: scans of streets by our own simulation."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from lidardraft import Sensor
from lidardraft.calibration.street_casts import StreetCasts
from lidardraft.formats.recording import Recording, recording_of
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor_model import SensorModel

SENSOR = Sensor(
    name="truth",
    elevations=tuple(np.deg2rad(np.linspace(3.0, -22.0, 12)).tolist()),
    origin_heights=(0.1,) * 6 + (0.0,) * 6,
    columns=512,
    range_sigma=0.008,
    max_range=90.0,
    mount_height=1.8,
    model=SensorModel(tilt_spread=0.0, gain_spread=0.0, offset_spread=0.0, detection_threshold=0.1 / 70.0**2),
)
_OF_RAYS = ("rays_per_beam", "divergence_h", "divergence_v", "tilt_spread", "unit")  # of a model


def sweeps(sensor: Sensor, num: int, seed: int) -> list[Sweep]:
    """Scans of streets of a seed by the sensor, whose model is its own, with the columns where they look to."""
    assert sensor.model is not None
    rays = {name: getattr(sensor.model, name) for name in _OF_RAYS}
    exact = replace(sensor, range_sigma=0.0, model=SensorModel(**rays))
    return _casts(exact.to_json(), num, seed).observed(sensor.model, sensor.range_sigma)


@lru_cache(maxsize=8)
def _casts(sensor: str, num: int, seed: int) -> StreetCasts:
    """The casts for all models whose rays go the same ways; sensors are compared as files."""
    by = Sensor.from_json(sensor)
    assert by.model is not None
    return StreetCasts.from_sensor(by, by.model, num, seed=seed)


def recordings(sensor: Sensor, num: int = 6, seed: int = 11, *, columns: bool = True) -> list[Recording]:
    """Those scans as recordings: rings counted from the lowest laser, points in no order."""
    found = []
    for number, sweep in enumerate(sweeps(sensor, num, seed)):
        row, column = np.nonzero(sweep.valid)
        mixed = np.random.default_rng(number).permutation(len(row))
        fields = {"ring": len(sweep.points) - 1 - row, "intensity": sweep.intensity[sweep.valid], "column": column}
        if not columns:
            del fields["column"]
        points = sweep.points[sweep.valid][mixed]
        found.append(recording_of(f"scan {number}", points, **{name: v[mixed] for name, v in fields.items()}))
    return found


def with_model(**numbers: object) -> Sensor:
    """The sensor with another number or two in its model."""
    assert SENSOR.model is not None
    return replace(SENSOR, model=replace(SENSOR.model, **numbers))
