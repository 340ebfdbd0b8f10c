"""Boxes of scans, and casts of other renderers."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Sensor
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.formats.boxes import read_boxes, write_boxes
from lidardraft.formats.cast import read_cast
from lidardraft.scene.box import Box

CAR = Box("car_1", "car", 1, (10.0, -2.0, -0.98), (4.2, 1.8, 1.5), 0.25)


def test_reading_gives_what_was_written(tmp_path):
    boxes = [CAR, dataclasses.replace(CAR, id="person_2", label="person", instance=2, yaw=np.float32(0.5))]
    write_boxes(tmp_path / "boxes.json", boxes, [312, 0])
    assert read_boxes(tmp_path / "boxes.json") == (boxes, [312, 0])
    document = json.loads((tmp_path / "boxes.json").read_text())
    assert document["frame"] == "sensor"
    assert document["boxes"][0] == {
        "id": "car_1",
        "label": "car",
        "instance": 1,
        "center": [10.0, -2.0, -0.98],
        "size": [4.2, 1.8, 1.5],
        "yaw": 0.25,
        "num_points": 312,
    }


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"num_points": -1}, r"box 0: num_points is -1; it must be a whole number >= 0"),
        ({"num_points": True}, r"box 0: num_points is True; it must be a whole number >= 0"),
        ({"colour": "red"}, r"box 0: unknown field 'colour'"),
    ],
)
def test_a_bad_box_is_named(tmp_path, change, message):
    row = {**dataclasses.asdict(CAR), "num_points": 1, **change}
    (tmp_path / "boxes.json").write_text(json.dumps({"frame": "sensor", "boxes": [row]}))
    with pytest.raises(LidarDraftError, match=message):
        read_boxes(tmp_path / "boxes.json")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"frame": "sensor", "boxes": {}}', r"boxes.json: boxes is {}; it must be a list"),
        ('{"frame": "sensor"}', r"boxes.json: 'boxes' is missing"),
        ('{"frame": "world", "boxes": []}', r"frame is 'world'; it must be 'sensor'"),
        ('{"frame": "sensor", "boxes": [3]}', r"box 0: 3 is not a JSON object"),
    ],
)
def test_a_file_that_holds_no_boxes(tmp_path, text, message):
    (tmp_path / "boxes.json").write_text(text)
    with pytest.raises(FormatError, match=message):
        read_boxes(tmp_path / "boxes.json")


def test_nothing_is_written_of_bad_boxes(tmp_path):
    with pytest.raises(FormatError, match="2 point counts for 1 boxes"):
        write_boxes(tmp_path / "boxes.json", [CAR], [1, 2])
    with pytest.raises(FormatError, match=r"boxes.json: box 0: num_points is -1; it must be a whole number >= 0"):
        write_boxes(tmp_path / "boxes.json", [CAR], [-1])
    assert not list(tmp_path.iterdir())


SENSOR = Sensor(name="few", elevations=(0.1, 0.0, -0.1), columns=16)
IMAGES = {"depth": np.full((3, 16), 9.0), "label": np.ones((3, 16), np.int64)}


def test_a_cast_of_any_numbers_is_read(tmp_path: Path) -> None:
    instance = np.arange(48, dtype=np.int16).reshape(3, 16)
    np.savez(tmp_path / "a.npz", **IMAGES, instance=instance, rgb=np.zeros((9, 9, 3)))
    sensor, images = read_cast(tmp_path / "a.npz", SENSOR)
    assert sensor == SENSOR
    assert set(images) == {"depth", "label", "instance"}
    np.testing.assert_array_equal(images["instance"], instance)
    np.testing.assert_array_equal(images["depth"], IMAGES["depth"])


def test_the_sensor_of_the_file_is_the_sensor(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", **IMAGES, sensor=np.array(SENSOR.to_json()))
    assert read_cast(tmp_path / "a.npz")[0] == SENSOR
    assert read_cast(tmp_path / "a.npz", Sensor.preset("vlp16"))[0] == SENSOR


@pytest.mark.parametrize(
    ("images", "message"),
    [
        ({"depth": IMAGES["depth"]}, "'label' is missing"),
        (IMAGES | {"label": np.full((3, 16), "car")}, "label is <U3; it must hold numbers"),
        (IMAGES | {"depth": np.zeros((4, 16))}, r"depth has shape \(4, 16\); it must be \(3, 16\)"),
    ],
)
def test_what_is_no_cast_is_named(tmp_path: Path, images: dict[str, np.ndarray], message: str) -> None:
    np.savez(tmp_path / "a.npz", **images)
    with pytest.raises(FormatError, match=f"a.npz: {message}"):
        read_cast(tmp_path / "a.npz", SENSOR)


def test_a_cast_without_a_sensor_needs_one(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", **IMAGES)
    with pytest.raises(FormatError, match=r"a\.npz: it does not name its sensor; give one"):
        read_cast(tmp_path / "a.npz")
