"""Curves of intensity that cannot be; what they do is tested with the other effects."""

from dataclasses import replace

import pytest

from lidardraft import Sensor
from lidardraft.errors import SensorError
from lidardraft.scene.intensity_curve import IntensityCurve
from lidardraft.scene.sensor_model import SensorModel


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"responses": (0.1, 0.2)}, "readings of a beam of the intensity curve has 1 values; it needs 2"),
        ({"responses": (), "readings": ((),)}, "responses of the intensity curve has 0 values; it needs 1"),
        ({"responses": (0.2, 0.1), "readings": ((0, 1),)}, "a response of the curve is 0.1; it must be greater than"),
        ({"responses": (0.0,)}, "a response of the curve is 0; it must be finite and greater than 0"),
        ({"readings": ((1.5,),)}, "a reading of the curve is 1.5; it must be 0 to 1"),
        ({"readings": "a"}, "readings of the intensity curve is 'a'; it must be a list of lists"),
        ({"readings": (0.5,)}, "readings of the intensity curve is 0.5; it must be a list of finite numbers"),
        ({"responses": (float("nan"),)}, r"responses of the intensity curve is \(nan,\); it must be a list of finite"),
        (
            {"distances": (1.0,), "distance_gains": ((),)},
            "distance_gains of a beam of the intensity curve has 0 values; it needs 1",
        ),
        ({"distance_gains": (1.0,)}, "distance_gains of the intensity curve is 1.0; it must be a list of finite"),
        (
            {"distances": (2, 1), "distance_gains": ((1, 1),)},
            "a distance of the curve is 1; it must be greater than the",
        ),
        (
            {"distances": (2,), "distance_gains": ((0,),)},
            "a gain of the curve is 0; it must be finite and greater than 0",
        ),
        ({"cutoffs": (-1.0,)}, "a cut-off of the curve is -1; it must be finite and 0 or more"),
    ],
)
def test_a_curve_that_cannot_be(wrong, message):
    with pytest.raises(SensorError, match=message):
        SensorModel(intensity_curve=IntensityCurve(**{"responses": (0.1,), "readings": ((0.5,),)} | wrong))


def test_a_curve_goes_with_the_beams_of_its_sensor():
    sensor = Sensor(name="mine", elevations=(0.1, 0.0, -0.1), columns=8)
    curve = IntensityCurve(responses=(0.1,), readings=((0.5,), (0.6,)))
    with pytest.raises(SensorError, match="mine: readings of the intensity curve has 2 values; it needs 3"):
        replace(sensor, model=SensorModel(intensity_curve=curve))
