import dataclasses
import math

import numpy as np
import pytest

from lidardraft.errors import SensorError
from lidardraft.metrics.adherence import adherence
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME

SENSOR = Sensor(name="four", elevations=(0.1, 0.0), columns=2)


def image(depth, label=None):
    depth = np.array(depth, dtype=np.float32)
    label = (
        np.zeros(depth.shape, np.uint8)
        if label is None
        else np.array([[BY_NAME[n].id for n in row] for row in label], np.uint8)
    )
    return RangeImage(sensor=SENSOR, depth=depth, label=label, instance=np.zeros(depth.shape, np.uint32))


def test_shares_are_counted_over_what_the_ray_hits():
    condition_image = image([[10, 10], [20, 0]], [["car", "road"], ["car", "none"]])
    scan = image([[10, 15], [25, 7]])
    result = adherence(scan, condition_image)
    assert result.objects == 0.5
    assert result.overall == pytest.approx(1 / 3)
    assert result.by_class == {"road": 0.0, "car": 0.5}
    assert result.drop == 0.0


def test_pixels_without_a_return_are_dropped_not_wrong():
    condition_image = image([[10, 10], [20, 0]], [["car", "road"], ["car", "none"]])
    result = adherence(image([[10, 0], [0, 0]]), condition_image)
    assert result.objects == result.overall == 1.0
    assert result.drop == pytest.approx(2 / 3)


def test_nothing_to_count_is_nan():
    result = adherence(image([[0, 0], [0, 0]]), image([[0, 0], [0, 0]]))
    assert math.isnan(result.objects)
    assert math.isnan(result.overall)
    assert math.isnan(result.drop)
    assert result.by_class == {}


def test_a_condition_image_adheres_to_itself_and_not_to_another_layout():
    sensor = Sensor.preset("vlp16")
    car = Primitive(shape="box", center=(8, 0, 0.75), size=(4, 2, 1.5), label="car", id="car", instance=1)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(100, 100, 0), label="road", id="road")
    condition_image = raycast(Layout(primitives=(road, car)), sensor)
    itself = adherence(condition_image, condition_image)
    assert (itself.objects, itself.overall, itself.drop) == (1.0, 1.0, 0.0)
    moved = raycast(Layout(primitives=(road, dataclasses.replace(car, center=(14, 0, 0.75)))), sensor)
    assert adherence(moved, condition_image).by_class["car"] < 0.3


def test_images_of_two_sensors_are_refused():
    wide = Sensor(name="wide", elevations=(0.1, 0.0), columns=3)
    empty = raycast(Layout(), wide)
    with pytest.raises(SensorError, match=r"one scan is \(2, 3\), the other \(2, 2\); both need one sensor"):
        adherence(empty, image([[0, 0], [0, 0]]))
