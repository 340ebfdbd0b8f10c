"""A scanner does what its three steps do one by one."""

import numpy as np

from lidardraft import Layout, Primitive, RangeImage, Sensor
from lidardraft.scene.effects import observe
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.scanner import Scanner
from lidardraft.scene.sensor_model import SensorModel, sub_rays
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather

SENSOR = Sensor(name="few", elevations=(0.05, 0.0, -0.05, -0.1), columns=256)
LAYOUT = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road"),
    Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="car_1", instance=1),
))  # fmt: skip
RAIN = Weather(rain=20.0, wetness=1.0)


def same(one: RangeImage, two: RangeImage) -> bool:
    names = ("depth", "label", "instance", "intensity")
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in names)


def test_a_scan_is_a_cast_that_is_observed() -> None:
    model = SensorModel()
    poses = SENSOR.poses_in_motion(velocity=(15.0, 0.0, 0.0))
    for kwargs in ({"pose": SENSOR.pose(x=1.0)}, {"poses": poses}):
        clean = Raycaster(LAYOUT).scan(sub_rays(SENSOR, model), **kwargs, primitive=True, incidence=True, seed=4)
        surfaces = Surfaces.from_layout(LAYOUT, wetness=1.0)
        expected = observe(clean, surfaces, seed=5, sensor=SENSOR, model=model, weather=RAIN)
        for threads in (None, 1, 3):
            scanner = Scanner.from_layout(LAYOUT, SENSOR, weather=RAIN, threads=threads)
            scan = scanner.observe(scanner.cast(next(iter(kwargs.values())), seed=4), 5)
            assert same(scan, expected)
    assert expected.valid.mean() > 0.3


def test_the_model_and_the_weather_are_those_given() -> None:
    plain = Scanner.from_layout(LAYOUT, SENSOR)
    assert plain.model == SensorModel()
    scans = [
        scanner.observe(scanner.cast(SENSOR.pose(), seed=0), 0)
        for scanner in (
            plain,
            Scanner.from_layout(LAYOUT, SENSOR, weather=RAIN),
            Scanner.from_layout(LAYOUT, SENSOR, model=SensorModel.ideal()),
        )
    ]
    assert not same(scans[0], scans[1])
    assert not same(scans[0], scans[2])
