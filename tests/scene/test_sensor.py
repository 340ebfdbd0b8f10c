"""Sensors: their beams, what their vehicles hide, and their files."""

import dataclasses
import json
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lidardraft import Layout, Primitive, Raycaster, detail, raycast, with_vehicle
from lidardraft.errors import LidarDraftError, SensorError
from lidardraft.scene.effects import observe, sub_rays
from lidardraft.scene.range_image import IMAGES
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.scene.weather import Weather

SMALL = Sensor(name="small", elevations=(0.1, 0.0, -0.1), columns=8)


def test_columns_wrap_where_they_make_a_full_turn():
    assert all(sensor.wraps for sensor in PRESETS.values())
    for span, wraps in ((2 * math.pi, True), (2 * math.pi - 1e-12, True), (2 * math.pi * 7 / 8, False), (1.0, False)):
        assert dataclasses.replace(SMALL, azimuth_span=span).wraps == wraps


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_presets_have_their_name_and_a_file(name):
    assert name in Sensor.presets()
    sensor = Sensor.preset(name)
    assert sensor.name == name
    assert sensor.shape == (len(sensor.elevations), sensor.columns)
    assert Sensor.from_json(sensor.to_json()) == sensor


@pytest.mark.parametrize(
    ("name", "beams", "top", "bottom"),
    [
        ("hdl64e", 64, 2.0, -24.333),
        ("hdl32e", 32, 10.667, -30.667),
        ("vlp16", 16, 15.0, -15.0),
        ("os1-128", 128, 22.5, -22.5),
        ("pandar64", 64, 14.87, -24.909),
        ("vlp32c", 32, 15.0, -25.0),
        ("os0-128", 128, 45.75, -46.26),
        ("os1-32", 32, 12.75, -15.32),
        ("os2-128", 128, 10.76, -11.09),
    ],
)
def test_presets_see_what_their_data_sheets_say(name, beams, top, bottom):
    sensor = Sensor.preset(name)
    assert len(sensor.elevations) == beams
    assert math.degrees(sensor.elevations[0]) == pytest.approx(top)
    assert math.degrees(sensor.elevations[-1]) == pytest.approx(bottom)


def test_the_blocks_of_the_hdl64e_start_at_two_heights():
    heights = Sensor.preset("hdl64e").pattern.origins()[:, 0, 2]
    assert heights[0] == heights[31] > heights[32] == heights[63] > 0


def test_a_makers_azimuths_count_clockwise():
    # channel 9 of the Pandar64 looks 5.208 degrees further on than the head points, to the right
    assert math.degrees(Sensor.preset("pandar64").azimuth_offsets[8]) == pytest.approx(-5.208)


def test_columns_are_pixel_centres_of_falling_azimuth_with_the_seam_behind():
    directions = SMALL.pattern.directions()
    azimuth = np.arctan2(directions[1, :, 1], directions[1, :, 0])
    np.testing.assert_allclose(azimuth, np.pi - (np.arange(8) + 0.5) * 2 * np.pi / 8)
    np.testing.assert_allclose(np.arcsin(directions[:, 0, 2]), SMALL.elevations)


def test_the_pose_stands_on_the_mount_and_looks_along_the_yaw():
    pose = SMALL.pose(3.0, 4.0, math.pi / 2)
    np.testing.assert_allclose(pose @ [1, 0, 0, 1], [3, 5, SMALL.mount_height, 1], atol=1e-12)
    np.testing.assert_allclose(SMALL.pose()[:3, :3], np.eye(3))


def test_a_sensor_of_ones_own_is_a_json_file(tmp_path):
    (tmp_path / "mine.json").write_text(json.dumps({"name": "mine", "elevations": [0.1, -0.1], "columns": 16}))
    sensor = Sensor.load(tmp_path / "mine.json")
    assert sensor == Sensor(name="mine", elevations=(0.1, -0.1), columns=16)
    sensor.save(tmp_path / "saved.json")
    assert Sensor.load(tmp_path / "saved.json") == sensor


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"name": "a", "columns": 4}', r"mine.json: 'elevations' is missing"),
        ('{"name": "a", "columns": 4, "elevations": [0], "colour": 1}', r"mine.json: unknown field 'colour'"),
        ('{"name": "a", "columns": 4, "elevations": "no"}', r"mine.json: a: elevations is 'no'; it must be a list of"),
        ('{"name": "a", "columns": "many", "elevations": [0]}', r"mine.json: a: columns is 'many'; it must be a"),
        ('{"name": "a", "columns": 4, "elevations": [0], "range_sigma": "x"}', r"mine.json: a: range_sigma is 'x'"),
        ('{"name": "a", "columns": 4, "elevations": [1' + "0" * 400 + "]}", r"mine.json: a: elevations is "),
        ('{"name": ["a"], "columns": 4, "elevations": [0]}', r"mine.json: name is \['a'\]; it must be a string of 1"),
    ],
)
def test_a_file_that_is_no_sensor(tmp_path, text, message):
    (tmp_path / "mine.json").write_text(text)
    with pytest.raises(LidarDraftError, match=message):
        Sensor.load(tmp_path / "mine.json")


def test_an_unknown_name():
    with pytest.raises(
        SensorError, match=r"sensor is 'hdl65e'; it must be one of hdl64e, hdl64e-linear, .*`Sensor.load` reads a file"
    ):
        Sensor.preset("hdl65e")


@pytest.mark.parametrize(
    "change",
    [
        {"elevations": ()},
        {"elevations": (0.0, 0.1)},
        {"elevations": (0.1, math.nan)},
        {"elevations": (2.0, 0.0)},
        {"azimuth_offsets": (0.0,)},
        {"origin_heights": (0.0, 0.0, math.inf)},
        {"origin_forwards": (0.0, math.nan, 0.0)},
        {"origin_lefts": ("left", 0.0, 0.0)},
        {"columns": 0},
        {"columns": True},
        {"columns": 4.0},
        {"columns": 10**30},
        {"mount_height": 1e308},
        {"elevations": "0.1"},
        {"azimuth_span": 0.0},
        {"azimuth_span": 7.0},
        {"azimuth_start": math.nan},
        {"min_range": -1.0},
        {"min_range": 5.0, "max_range": 4.0},
        {"max_range": math.inf},
        {"mount_height": math.nan},
        {"range_sigma": math.inf},
        {"sweep_time": math.inf},
        {"sweep_time": -0.1},
    ],
    ids=str,
)
def test_a_sensor_that_cannot_be(change):
    with pytest.raises(SensorError) as caught:
        dataclasses.replace(SMALL, **change)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("table", ["azimuth_offsets", "origin_forwards", "origin_lefts", "origin_heights"])
def test_a_table_has_a_value_for_each_beam_or_none(table):
    with pytest.raises(SensorError, match=f"small: {table} has 2 values; it needs one for each of 3 beams"):
        dataclasses.replace(SMALL, **{table: (0.0, 0.0)})
    assert dataclasses.replace(SMALL, **{table: (0.0, 0.0, 0.0)}).pattern.shape == SMALL.shape


def test_beams_start_ahead_left_and_above_along_their_own_azimuth():
    sensor = dataclasses.replace(
        SMALL,
        azimuth_offsets=(0.3, 0, 0),
        origin_forwards=(0.1, 0, 0),
        origin_lefts=(0, 0.2, 0),
        origin_heights=(0, 0, 1),
    )
    azimuth = np.pi - (np.arange(8) + 0.5) * 2 * np.pi / 8
    origins = sensor.pattern.origins()
    ahead = 0.1 * np.stack([np.cos(azimuth + 0.3), np.sin(azimuth + 0.3), 0 * azimuth], axis=1)
    left = 0.2 * np.stack([-np.sin(azimuth), np.cos(azimuth), 0 * azimuth], axis=1)
    np.testing.assert_allclose(origins, [ahead, left, np.tile([0, 0, 1], (8, 1))], atol=1e-12)
    depth = np.full(sensor.shape, 5.0, np.float32)
    np.testing.assert_allclose(sensor.pattern.points(depth), origins + 5 * sensor.pattern.directions(), atol=1e-6)
    assert Sensor.from_json(sensor.to_json()) == sensor


def test_a_sensor_written_before_it_had_a_sweep_is_one_of_10_hz():
    text = (
        '{"name": "old", "elevations": [0.1, 0.0], "columns": 8, "azimuth_offsets": [], "origin_heights": [0.0, 0.1], '
        '"azimuth_start": 3.0, "azimuth_span": 6.0, "min_range": 0.5, "max_range": 90.0, "mount_height": 1.7, '
        '"range_sigma": 0.02}'
    )
    sensor = Sensor.from_json(text)
    assert (sensor.sweep_time, sensor.origin_forwards, sensor.origin_lefts) == (0.1, (), ())
    np.testing.assert_array_equal(sensor.pattern.origins()[:, 0], [[0, 0, 0], [0, 0, 0.1]])


def test_a_sensor_can_go_to_another_process():
    other = pickle.loads(pickle.dumps(SMALL))
    assert other == SMALL
    assert other.pattern is not SMALL.pattern


SECTOR = {"azimuth_start": 0.7, "azimuth_span": 1.4, "columns": 400}


@pytest.mark.parametrize("fields", [{}, SECTOR])
@pytest.mark.parametrize("name", ["vlp32c", "vlp16"])
def test_each_column_looks_to_one_azimuth_and_each_pixel_is_there_once(name: str, fields: dict[str, float]) -> None:
    sensor = dataclasses.replace(Sensor.preset(name), **fields)
    rows, columns, inside = sensor.azimuth_grid()
    assert rows.shape == columns.shape == inside.shape
    assert (rows.shape[1] == sensor.columns) == (sensor.wraps or not sensor.azimuth_offsets)
    counts = np.zeros(sensor.shape, int)
    np.add.at(counts, (rows[inside], columns[inside]), 1)
    assert (counts == 1).all()
    step = sensor.azimuth_span / sensor.columns
    offsets = np.array(sensor.azimuth_offsets or [0.0] * len(sensor.elevations))
    azimuth = sensor.azimuth_start - (columns + 0.5) * step + offsets[rows]
    middle = azimuth[np.argmax(inside, axis=0), np.arange(rows.shape[1])]
    apart = np.abs((azimuth - middle + math.pi) % (2 * math.pi) - math.pi)
    assert apart[inside].max() <= step * 1.001


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
