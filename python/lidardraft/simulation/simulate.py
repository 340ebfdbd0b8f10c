"""Lifelike scans of layouts by physics alone: no weights, and exact labels."""

from __future__ import annotations

import math
import warnings
from functools import partial

import numpy as np

from lidardraft.errors import SensorError, check_seed, check_type
from lidardraft.scan import Scan
from lidardraft.scene.bodies import Bodies
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import finite_array
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.weather import Weather, weather_of
from lidardraft.semantics import GROUND
from lidardraft.simulation.detail.detail import detail as detailed
from lidardraft.simulation.on_relief import both_on_relief, without_relief
from lidardraft.simulation.sweeps import Sweeper

_NO_GROUND = "the layout has no ground (road, sidewalk or terrain): nothing returns from it"


class Simulator:
    """A layout, or that of a sentence with the street around it (`surround`), ready to be scanned by one sensor from
    many poses.

    The scanned `scene` is `layout` in detail, or `layout` itself without `detail`. `model` is by default that of the
    sensor: its preset, or typical values (`Sensor.assumed_model`). `weather` is by default that of the sentence, or
    clear and dry. `seed` decides the layout of a sentence and the details. With `relief`, the ground rises and falls as
    the roads say (`on_relief`); without, it is level. `threads` is the most threads of a scan, by default one a core.
    Scans are the same for any number, and several Python threads may scan at once.

    The vehicle of the sensor, its `carrier`, hides the ground around it. It is the typical car of a preset, or its
    shapes as in `with_vehicle`; False is none. Its own returns are left out; with `own_returns` they are of class car,
    or that of their shape, and instance 0. One of the `notes` says if a sensor has no known vehicle.

    Raises `SensorError` if the beams of the sensor are too close for the model, or own returns need the shape of the
    vehicle; `LayoutError` if the seed or the carrier is invalid. A layout without ground is a `UserWarning`, and one of
    the `notes` of its scans.
    """

    def __init__(
        self,
        layout: Layout | str,
        sensor: Sensor,
        *,
        seed: int = 0,
        model: SensorModel | None = None,
        weather: Weather | None = None,
        detail: bool = True,
        relief: bool = True,
        carrier: bool | Layout = True,
        own_returns: bool = False,
        threads: int | None = None,
    ) -> None:
        check_type("sensor", sensor, Sensor)
        self.layout, self.scene, assumed = prepared(layout, seed, detail, relief)
        weather = weather or weather_of(self.layout.intent.weather)
        self._sweeper = Sweeper.of(sensor, model, weather, threads, carrier=carrier, own_returns=own_returns)
        self._assumed = (*assumed, *self._sweeper.notes)
        self._bodies = Bodies.of(self.scene, self._sweeper.weather.wetness)

    def scan(self, pose: np.ndarray | None = None, *, speed: float = 0.0, seed: int = 0) -> Scan:
        """The scan from world_from_sensor `pose` [4, 4], by default on the sensor's mount over the origin.

        The sensor moves along its x axis with `speed` [m/s] while it sweeps; `pose` is that in the middle of the sweep.
        `seed` decides noise, ray drop and how far rays get into foliage. Labels and instances are those of the surface
        of each return; 0 is that of rain, snow and fog.

        Raises `LayoutError` on a pose that is not rigid, `SensorError` on a speed that is not finite.
        """
        seed = check_seed(seed)
        if not math.isfinite(speed):
            raise SensorError(f"speed is {speed}; it must be a finite number of metres per second")
        sweeper, sensor = self._sweeper, self._sweeper.sensor
        pose = sensor.pose() if pose is None else finite_array("pose", pose, 4, 4)
        poses = sensor.poses_in_motion(pose, speed * pose[:3, 0]) if speed else pose
        image = sweeper.scan(self._bodies, poses, seed)
        return Scan(image=image, layout=self.layout, pose=pose, seed=seed, speed=speed, assumed=self._assumed)


def simulate(
    layout: Layout | str,
    sensor: Sensor,
    *,
    seed: int = 0,
    pose: np.ndarray | None = None,
    speed: float = 0.0,
    model: SensorModel | None = None,
    weather: Weather | None = None,
    detail: bool = True,
    relief: bool = True,
    carrier: bool | Layout = True,
    own_returns: bool = False,
    threads: int | None = None,
) -> Scan:
    """The scan of a layout as it is, or of a sentence with a street around it.

    `simulate("a car", sensor)` is `simulate(surround(layout_from_text("a car")), sensor)`; without `surround` the road
    is bare. It is `Simulator(layout, sensor, ...).scan(pose, ...)`.
    The same arguments give the same scan, for any number of threads; another seed gives another one.
    """
    simulator = Simulator(
        layout,
        sensor,
        seed=seed,
        model=model,
        weather=weather,
        detail=detail,
        relief=relief,
        carrier=carrier,
        own_returns=own_returns,
        threads=threads,
    )
    return simulator.scan(pose, speed=speed, seed=seed)


def prepared(layout: Layout | str, seed: int, detail: bool, relief: bool) -> tuple[Layout, Layout, tuple[str, ...]]:
    """The layout, or that of a sentence in its street, on its relief; its scene to scan; and the notes on assumptions
    of its scans."""
    layout, assumed = level_layout(layout, seed, relief)
    return *both_on_relief(layout, partial(detailed, seed=seed) if detail else Layout.noted), assumed


def level_layout(layout: Layout | str, seed: int, relief: bool) -> tuple[Layout, tuple[str, ...]]:
    """The layout, or that of a sentence in its street, still level, with its `relief` or without; and the notes on
    assumptions of its scans."""
    seed = check_seed(seed)
    check_type("layout", layout, Layout, str)
    check_type("relief", relief, bool)
    layout = _from_text(layout, seed) if isinstance(layout, str) else layout
    assumed = () if any(primitive.label in GROUND for primitive in layout) else (_NO_GROUND,)
    if assumed:
        warnings.warn(_NO_GROUND, stacklevel=4)
    return layout if relief else without_relief(layout), assumed


def _from_text(sentence: str, seed: int) -> Layout:
    from lidardraft.drafting.text.layout import layout_from_text  # given layouts need not wait for the grammar
    from lidardraft.simulation.around.surround import surround

    return surround(layout_from_text(sentence, seed=seed), seed=seed)
