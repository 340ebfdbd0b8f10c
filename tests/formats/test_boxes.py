import dataclasses
import json

import pytest

from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.formats.boxes import read_boxes, write_boxes
from lidardraft.scene.box import Box

CAR = Box("car_1", "car", 1, (10.0, -2.0, -0.98), (4.2, 1.8, 1.5), 0.25)


def test_reading_gives_what_was_written(tmp_path):
    boxes = [CAR, dataclasses.replace(CAR, id="person_2", label="person", instance=2)]
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


def test_no_box_is_a_file_too(tmp_path):
    write_boxes(tmp_path / "boxes.json", [], [])
    assert read_boxes(tmp_path / "boxes.json") == ([], [])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"size": [4.2, -1.0, 1.5]}, r"box 0: car_1: size is \[4.2, -1.0, 1.5\]; no extent may be negative"),
        ({"center": [0.0, 1.0]}, r"box 0: car_1: center is \[0.0, 1.0\]; it must be 3 finite numbers"),
        (
            {"center": [0.0, 1.0, float("nan")]},
            r"box 0: car_1: center is \[0.0, 1.0, nan\]; it must be 3 finite numbers",
        ),
        ({"yaw": float("inf")}, r"box 0: car_1: yaw is inf; it must be a finite number of radians"),
        ({"label": "cow"}, r"box 0: car_1: label is 'cow'; it must be one of"),
        ({"num_points": -1}, r"box 0: num_points is -1; it must be a whole number >= 0"),
        ({"instance": 0.5}, r"box 0: car_1: instance is 0.5; it must be a whole number >= 0"),
        ({"label": ["car"]}, r"box 0: car_1: label is \['car'\]; it must be one of"),
        ({"yaw": 10**400}, r"box 0: car_1: yaw is 10*; it must be a finite number of radians"),
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
        ("{", r"boxes.json: not JSON"),
        ("[]", r"boxes.json: \[\] is no JSON object"),
        ('{"frame": "sensor", "boxes": {}}', r"boxes.json: boxes is {}; it must be a list"),
        ('{"frame": "sensor"}', r"boxes.json: 'boxes' is missing"),
        ('{"frame": "world", "boxes": []}', r"frame is 'world'; it must be 'sensor'"),
        ('{"frame": "sensor", "boxes": [3]}', r"box 0: 3 is no JSON object"),
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


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FormatError, match=r"none.json: No such file or directory"):
        read_boxes(tmp_path / "none.json")
