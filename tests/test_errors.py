import pytest

from lidardraft import Primitive, Sensor
from lidardraft.errors import LayoutError, SensorError, one_of


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("cra", "one of car, bus, traffic-sign; did you mean 'car'?"),
        ("Traffic_Sign", "one of car, bus, traffic-sign; did you mean 'traffic-sign'?"),
        ("zeppelin", "one of car, bus, traffic-sign"),
        (None, "one of car, bus, traffic-sign"),
    ],
)
def test_the_name_that_was_meant_is_suggested(value: object, said: str) -> None:
    assert one_of(("car", "bus", "traffic-sign"), value) == said


def test_sensors_and_classes_are_suggested() -> None:
    with pytest.raises(SensorError, match=r"sensor is 'hdl64'; .*hdl64e, .*did you mean 'hdl64e'\?"):
        Sensor.preset("hdl64")
    with pytest.raises(LayoutError, match=r"label is 'cars'; .*did you mean 'car'\?"):
        Primitive(shape="box", center=(0, 0, 1), size=(1, 1, 1), label="cars", id="car_1")
