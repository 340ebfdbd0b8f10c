"""What the vehicle hides is missing in every cast and every scan of its sensor, and nothing else is."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lidardraft import Layout, Primitive, Raycaster, Sensor, raycast
from lidardraft.errors import SensorError
from lidardraft.scene.effects import observe
from lidardraft.scene.range_image import IMAGES
from lidardraft.scene.sensor_model import SensorModel, sub_rays
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.scene.weather import Weather

OPEN = Sensor(name="roof", elevations=(0.1, -0.1, -0.3), columns=360, azimuth_offsets=(0.2, 0.0, 0.0))
# ahead to the left; across the seam behind
HALF = replace(OPEN, blocked=((), ((0.0, 0.5),), ((3.0, 3.3), (-0.5, 0.25))))
ROOM = Layout(primitives=(Primitive(shape="cylinder", center=(0, 0, 0), size=(30, 30, 40), label="wall", id="ring"),))


def hidden(sensor: Sensor) -> np.ndarray:
    """Where a cast without a mask returns and one with it does not."""
    return raycast(ROOM, replace(sensor, blocked=())).valid & ~raycast(ROOM, sensor).valid


def test_intervals_are_azimuths_and_may_cross_the_seam():
    points = raycast(ROOM, OPEN).points().reshape(3, 360, 3)
    azimuth = np.arctan2(points[..., 1], points[..., 0])
    expected = np.zeros((3, 360), dtype=bool)
    expected[1] = (azimuth[1] >= 0) & (azimuth[1] < 0.5)
    expected[2] = (azimuth[2] >= 3.0) | (azimuth[2] < 3.3 - 2 * math.pi) | ((azimuth[2] >= -0.5) & (azimuth[2] < 0.25))
    np.testing.assert_array_equal(hidden(HALF), expected)


@given(st.floats(-7, 7), st.floats(0.01, 2 * math.pi), st.integers(1, 200))
def test_as_much_is_hidden_as_the_interval_is_wide(start, width, columns):
    sensor = Sensor(name="one", elevations=(0.0,), columns=columns, blocked=[[[start, start + width]]])
    assert abs(sensor.blocked_pixels.sum() - columns * width / (2 * math.pi)) <= 1


def test_every_way_to_cast_has_the_mask_and_leaves_the_rest_as_it_is():
    images = {"primitive": True, "incidence": True, "normal": True}
    bare, caster, pose = raycast(ROOM, OPEN, **images), Raycaster(ROOM), HALF.pose()
    kept = bare.keep(~HALF.blocked_pixels)
    assert 0 < HALF.blocked_pixels.sum() < 0.5 * HALF.blocked_pixels.size
    table = ShapeTable.from_primitives(ROOM.primitives).scan(HALF, pose)
    for image in (caster.scan(HALF, **images), caster.scan_batch(HALF, np.stack([pose, pose]), **images)[1], table):
        for name in IMAGES:
            if getattr(image, name) is not None:
                np.testing.assert_array_equal(getattr(image, name), getattr(kept, name))


@pytest.mark.parametrize("weather", [Weather(), Weather(visibility=40.0)])
def test_nothing_comes_back_from_a_blocked_beam(weather):
    for model in (SensorModel(), SensorModel.ideal()):
        clean = raycast(ROOM, sub_rays(HALF, model), primitive=True, incidence=True)
        scan = observe(clean, ROOM, seed=0, sensor=HALF, model=model, weather=weather)
        assert not scan.valid[HALF.blocked_pixels].any()
        assert not scan.intensity[HALF.blocked_pixels].any()
        assert scan.valid[~HALF.blocked_pixels].mean() > 0.9


def test_casts_of_others_do_not_know_the_vehicle_and_get_the_mask_too():
    theirs = raycast(ROOM, OPEN, primitive=True, incidence=True)
    scan = observe(replace(theirs, sensor=HALF), ROOM, seed=0, model=SensorModel.ideal())
    np.testing.assert_array_equal(scan.valid, ~HALF.blocked_pixels)


def test_a_file_carries_it_and_an_open_sensor_has_none():
    assert Sensor.from_json(HALF.to_json()) == HALF
    assert "blocked" not in json.loads(OPEN.to_json())
    assert replace(OPEN, blocked=((), (), ())) == OPEN
    assert not OPEN.blocked_pixels.any()


@pytest.mark.parametrize(
    ("blocked", "message"),
    [
        ([[]], r"roof: blocked is \[\[\]\]; it must be a list of intervals for each of 3 beams"),
        ("all", "roof: blocked is 'all'; it must be"),
        ([[], 3, []], "roof: blocked of beam 1 is 3; it must be a list of intervals"),
        ([[], [], [[0.0, 7.0]]], r"roof: blocked of beam 2 has \[0.0, 7.0\]; it must be a start and an end"),
        ([[], [], [[1.0, 0.0]]], r"blocked of beam 2 has \[1.0, 0.0\]; it must be a start and an end"),
        ([[], [], [[0.0, math.nan]]], "blocked of beam 2 has "),
        ([[], [], [[0.0]]], r"blocked of beam 2 has \[0.0\]"),
    ],
    ids=str,
)
def test_a_mask_that_cannot_be(blocked, message):
    with pytest.raises(SensorError, match=message):
        replace(OPEN, blocked=blocked)
