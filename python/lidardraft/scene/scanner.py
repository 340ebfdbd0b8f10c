"""A layout prepared for one sensor: from the layout to the sensor's scans."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.errors import check_type
from lidardraft.scene.effects import observe, sub_rays
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather


@dataclass(frozen=True, slots=True, eq=False)
class Scanner:
    """One unit of a sensor, and the layout that it scans: compiled, with its surfaces in `weather`.

    `threads` is the largest number of threads of a scan, by default the number of cores; the scan is the same for any
    number.
    """

    sensor: Sensor
    model: SensorModel
    caster: Raycaster
    surfaces: Surfaces
    weather: Weather
    threads: int | None = None

    @classmethod
    def from_layout(
        cls,
        layout: Layout,
        sensor: Sensor,
        *,
        model: SensorModel | None = None,
        weather: Weather | None = None,
        by_id: bool = False,
        threads: int | None = None,
    ) -> Scanner:
        """`model` is by default `sensor.assumed_model`, `weather` a clear and dry day. With `by_id` a primitive keeps
        its brightness and its free paths when it is moved, and when others come and go."""
        weather = Weather() if weather is None else weather
        check_type("weather", weather, Weather)
        surfaces = Surfaces.from_layout(layout, wetness=weather.wetness, by_id=by_id)
        model = model or sensor.assumed_model
        return cls(sensor, model, Raycaster(layout, by_id=by_id), surfaces, weather, threads)

    def cast(self, poses: np.ndarray, seed: int) -> RangeImage:
        """The clean returns of all sub-rays from world_from_sensor `poses`: one [4, 4], or one for each column [W, 4,
        4]."""
        rays = sub_rays(self.sensor, self.model)
        pose, poses_of_columns = (poses, None) if np.ndim(poses) == 2 else (None, poses)
        return self.caster.scan(
            rays, pose, poses=poses_of_columns, primitive=True, incidence=True, seed=seed, threads=self.threads
        )

    def observe(self, clean: RangeImage, poses: np.ndarray, seed: int | np.random.Generator) -> RangeImage:
        """The sensor's scan from the clean returns that `cast` made at these `poses`."""
        return observe(
            clean,
            self.surfaces,
            seed=seed,
            sensor=self.sensor,
            model=self.model,
            weather=self.weather,
            poses=poses,
            threads=self.threads,
        )
