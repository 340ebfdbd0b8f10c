import dataclasses
import math

from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_limits import SensorLimits

SENSOR = Sensor(name="small", elevations=(0.1, 0.0, -0.1), columns=100, mount_height=1.5)


def test_a_sensor_is_within_its_own_limits() -> None:
    limits = SensorLimits.from_sensor(SENSOR)
    assert limits.difference(SENSOR) is None
    assert SensorLimits.from_dict(limits.to_dict()) == limits


def test_what_is_outside_is_said_with_the_limits() -> None:
    limits = SensorLimits(beams=(2, 4), columns=(50, 200), elevation=(-10.0, 10.0), mount_height=(1.0, 2.0))
    assert limits.difference(SENSOR) is None
    for change, words in (
        ({"columns": 300}, "columns of 50 to 200, and small has 300"),
        ({"mount_height": 2.5}, "mount height of 1 to 2, and small has 2.5"),
        ({"elevations": (0.2, 0.0)}, "elevation of -10 to 10, and small has 0 to 11.46"),
        ({"elevations": (0.1,)}, "beams of 2 to 4, and small has 1"),
    ):
        assert limits.difference(dataclasses.replace(SENSOR, **change)) == words


def test_columns_are_those_of_a_full_turn() -> None:
    sector = dataclasses.replace(SENSOR, azimuth_start=math.pi / 4, azimuth_span=math.pi / 2)
    limits = SensorLimits(beams=(3, 3), columns=(390, 410), elevation=(-10.0, 10.0), mount_height=(1.0, 2.0))
    assert limits.difference(sector) is None
