"""A vehicle hides what is behind its body, and no more."""

from dataclasses import replace

import numpy as np

from lidardraft import Layout, Primitive, detail, raycast
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.vehicle_shadow import with_vehicle

CAR = Layout(
    (Primitive(shape="box", center=(0.3, 0, 0.75), size=(4.7, 1.8, 1.5), label="car", id="car_1", instance=1),)
)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road")
TURNED = Sensor(
    name="turned", elevations=(-0.1, -0.3, -0.45, -0.9), azimuth_offsets=(0.0, 0.1, -0.1, 0.05), columns=720
)


def test_what_the_vehicle_hides_is_what_its_cast_hits():
    for sensor in (PRESETS["hdl64e"], TURNED, replace(TURNED, azimuth_start=1.0, azimuth_span=2.0)):
        hit = raycast(CAR, replace(sensor, min_range=1e-3), sensor.pose()).valid
        assert hit.any()
        mounted = with_vehicle(sensor, CAR)
        np.testing.assert_array_equal(mounted.blocked_pixels, hit)
        assert Sensor.from_json(mounted.to_json()) == mounted


def test_the_ground_behind_it_does_not_return():
    sensor = with_vehicle(PRESETS["hdl64e"], detail(CAR))
    scan = raycast(Layout((ROAD,)), sensor, sensor.pose())
    assert not scan.valid[sensor.blocked_pixels].any()
    open_rows = np.array(sensor.elevations) < -0.05
    assert scan.valid[open_rows][~sensor.blocked_pixels[open_rows]].all()
    hidden = sensor.blocked_pixels.mean(axis=1)
    assert hidden[0] == 0  # it looks over the roof
    assert 0.1 < hidden[-1] < 0.9  # neither a disc nor nothing


def test_a_body_of_a_car_hides_less_than_its_box():
    box, body = (with_vehicle(PRESETS["hdl64e"], layout).blocked_pixels.sum() for layout in (CAR, detail(CAR)))
    assert 0.2 * box < body < box


def test_a_vehicle_that_hides_nothing_leaves_the_sensor_as_it_is():
    low = Layout((replace(CAR.primitives[0], size=(1.0, 1.0, 0.2), center=(0, 0, 0.1)),))
    assert with_vehicle(PRESETS["hdl64e"], low) == PRESETS["hdl64e"]
