import pickle

import pytest

from lidardraft import Primitive, Sensor
from lidardraft.errors import FormatError, LayoutError, SensorError, one_of


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


def test_control_characters_of_names_and_values_are_escaped() -> None:
    message = str(FormatError("a\x1b[31m\n\u202e\udc80.bin: b\x07"))
    assert message == r"a\x1b[31m\n\u202e\udc80.bin: b\x07"
    assert message.isprintable()


def test_a_message_that_quotes_too_much_is_cut_in_its_middle() -> None:
    message = str(FormatError(f"id is {'x' * 10**6}; it must be short"))
    assert len(message) < 2100
    assert message.startswith("id is xxx")
    assert message.endswith("xxx; it must be short")


def test_errors_can_go_to_another_process() -> None:
    error = pickle.loads(pickle.dumps(FormatError("a\nb")))
    assert str(error) == r"a\nb"
