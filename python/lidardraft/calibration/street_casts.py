"""Streets cast once and observed with several sensor models, to compare with recordings."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.bodies import Bodies
from lidardraft.scene.effects import sub_rays
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.simulation.sweeps import Sweeper
from lidardraft.streets.pairs import sample_viewpoint
from lidardraft.streets.street import StreetConfig, make_street

_BRIGHTEST = 1e4  # times a white surface: responses are read without a limit


@dataclass(frozen=True, eq=False)
class StreetCasts:
    """Clean casts by one sensor, one of each street, with the surfaces and poses to observe them."""

    sensor: Sensor
    surfaces: tuple[Surfaces, ...]
    poses: tuple[np.ndarray, ...]
    casts: tuple[RangeImage, ...]

    @classmethod
    def from_sensor(cls, sensor: Sensor, model: SensorModel, num: int, *, seed: int) -> StreetCasts:
        """The casts of the first `num` streets of a seed."""
        surfaces, places, casts = [], [], []
        sweeper = Sweeper.of(sensor, model, None)
        config = StreetConfig(sensor=sensor, poses_per_street=1)
        for number in range(num):
            street = make_street(seed=seed, config=config, number=number)
            ego, pose, _ = sample_viewpoint(street, sensor, number)
            places.append(ego.pose @ sensor.poses_in_motion(pose, (ego.speed, 0.0, 0.0)))
            bodies = Bodies.of(street.scene, by_id=False)
            surfaces.append(bodies.surfaces)
            casts.append(sweeper.cast(bodies, (), places[-1], number))
        return cls(sensor, tuple(surfaces), tuple(places), tuple(casts))

    def observed(self, model: SensorModel, range_sigma: float) -> list[Sweep]:
        """The sweeps that a sensor with this model reports; its sub-rays must be those of the casts."""
        sweeper, found = Sweeper.of(replace(self.sensor, range_sigma=range_sigma), model, None), []
        for number, (surfaces, poses, cast) in enumerate(zip(self.surfaces, self.poses, self.casts, strict=True)):
            clean = RangeImage.unchecked(**vars(cast) | {"sensor": sweeper.rays})
            found.append(Sweep.from_image(sweeper.observe(clean, surfaces, poses, number)))
        return found

    def responses(self, model: SensorModel, range_sigma: float) -> list[Sweep]:
        """As `observed`, with the response of each return as its intensity: 1 is a white surface facing the sensor."""
        linear = replace(
            model,
            intensity_curve=None,
            full_scale=_BRIGHTEST,
            knee=1.0,
            levels=0,
            least_reading=0.0,
            compensation_range=math.inf,
        )
        return [
            replace(sweep, intensity=sweep.intensity * np.float32(_BRIGHTEST))
            for sweep in self.observed(linear, range_sigma)
            if sweep.intensity is not None
        ]


def with_rays_that_fit(sensor: Sensor, model: SensorModel) -> SensorModel:
    """The model, with one ray a beam if the sensor's beams are too close for several."""
    try:
        sub_rays(sensor, model)
    except SensorError:
        return replace(model, rays_per_beam=1)
    return model
