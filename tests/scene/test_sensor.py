import dataclasses
import json
import math
import pickle

import numpy as np
import pytest

from lidardraft.errors import FormatError, LidarDraftError, SensorError
from lidardraft.scene.sensor import PRESETS, Sensor

SMALL = Sensor(name="small", elevations=(0.1, 0.0, -0.1), columns=8)


def test_columns_wrap_where_they_make_a_full_turn():
    assert all(sensor.wraps for sensor in PRESETS.values())
    for span, wraps in ((2 * math.pi, True), (2 * math.pi - 1e-12, True), (2 * math.pi * 7 / 8, False), (1.0, False)):
        assert dataclasses.replace(SMALL, azimuth_span=span).wraps == wraps


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_presets_have_their_name_and_descending_beams(name):
    sensor = Sensor.preset(name)
    assert sensor.name == name
    assert sensor.shape == (len(sensor.elevations), sensor.columns)
    assert (np.diff(sensor.elevations) < 0).all()
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
    with pytest.raises(FormatError, match=r"a.json cannot be written"):
        sensor.save(tmp_path / "nowhere" / "a.json")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", r"mine.json: not JSON"),
        ("[]", r"mine.json: \[\] is no JSON object"),
        ('{"name": "a", "columns": 4}', r"mine.json: 'elevations' is missing"),
        ('{"name": "a", "columns": 4, "elevations": [0], "colour": 1}', r"mine.json: unknown field 'colour'"),
        (
            '{"name": "a", "columns": 4, "elevations": "no"}',
            r"mine.json: a: elevations is 'no'; it must be a list of finite numbers",
        ),
        (
            '{"name": "a", "columns": "many", "elevations": [0]}',
            r"mine.json: a: columns is 'many'; it must be a whole number",
        ),
        (
            '{"name": "a", "columns": 4, "elevations": [0], "range_sigma": "x"}',
            r"mine.json: a: range_sigma is 'x'; it must be a finite number",
        ),
        ('{"name": "a", "columns": 4, "elevations": ["0"]}', r"mine.json: a: elevations is \['0'\]; it must be a list"),
        ('{"name": "a", "columns": 4, "elevations": [1' + "0" * 400 + "]}", r"mine.json: a: elevations is "),
        ('{"name": "a", "columns": 4' + "0" * 5000 + "}", r"mine.json: not JSON: "),
        (
            '{"name": ["a"], "columns": 4, "elevations": [0]}',
            r"mine.json: name is \['a'\]; it must be a string of 1 to 100 printable characters",
        ),
    ],
)
def test_a_file_that_is_no_sensor(tmp_path, text, message):
    (tmp_path / "mine.json").write_text(text)
    with pytest.raises(LidarDraftError, match=message):
        Sensor.load(tmp_path / "mine.json")


def test_a_missing_file_and_an_unknown_name(tmp_path):
    with pytest.raises(FormatError, match=r"none.json: No such file"):
        Sensor.load(tmp_path / "none.json")
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
