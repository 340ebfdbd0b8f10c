"""Boxes become layouts, and files of boxes become boxes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lidardraft import Box, Layout, layout_from_boxes
from lidardraft.cli.main import main
from lidardraft.errors import FormatError, LayoutError
from lidardraft.formats.box_files import read_box_file
from lidardraft.scene.check import check


def box(id: str, label: str = "car", instance: int = 0, **fields: Any) -> Box:
    place = {"center": (9.0, 2.0, -1.0), "size": (4.0, 2.0, 1.5), "yaw": 0.3}
    return Box(id=id, label=label, instance=instance, **{**place, **fields})


def test_boxes_stand_where_they_were_on_a_road_under_all_of_them() -> None:
    boxes = [box("car_1", instance=4), box("house", "building", center=(-70.0, 12.0, -0.95))]
    layout = layout_from_boxes(boxes, sensor_height=1.7)
    car = layout["car_1"]
    assert (car.instance, car.center, car.size, car.yaw) == (4, (9.0, 2.0, 0.7), (4.0, 2.0, 1.5), 0.3)
    assert layout["house"].instance == 0
    assert layout["ground"].label == "road"
    assert layout["ground"].size[0] > 140
    assert [primitive.id for primitive in layout if primitive.open] == ["ground"]
    assert check(layout) == []


def test_things_have_instances_of_their_own() -> None:
    given = [box("a", instance=2), box("b", instance=2), box("c"), box("d", "person", 1), box("e", "wall", 7)]
    assert [primitive.instance for primitive in layout_from_boxes(given)][1:] == [2, 3, 4, 1, 0]


def test_a_box_may_be_called_as_the_ground_is() -> None:
    layout = layout_from_boxes([box("ground"), box("ground_")])
    assert [primitive.id for primitive in layout] == ["ground__", "ground", "ground_"]


@pytest.mark.parametrize(
    ("boxes", "said"),
    [
        ([], "there are 0 boxes"),
        ([box("a", label="none")], "a: label is 'none'"),
        ([box("a", size=(1.0, 0.0, 1.0))], "a: size is"),
        ([box("a"), box("a")], "a: two primitives have this id"),
    ],
)
def test_boxes_that_make_no_layout(boxes: list[Box], said: str) -> None:
    with pytest.raises(LayoutError, match=said.replace("[", r"\[")):
        layout_from_boxes(boxes)
    with pytest.raises(LayoutError, match="sensor_height is nan"):
        layout_from_boxes([box("a")], sensor_height=float("nan"))


CALIBRATION = {
    "P2": "721.5 0 609.5 44.8 0 721.5 172.8 0.2 0 0 1 0.0027",
    "R0_rect": "1 0 0 0 1 0 0 0 1",
    "Tr_velo_to_cam": "0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27",
}


OLD = {"R0_rect": "R_rect", "Tr_velo_to_cam": "Tr_velo_cam"}


OBJECT = "{} 0.00 0 -10 0 0 50 50 1.5 1.8 4.2 -3.0 1.65 12.0 -1.5707963267948966"


def kitti(folder: Path, part: str, lines: list[str]) -> Path:
    """A label file and its calibration, as the benchmark of `part` has them."""
    tracks = part == "label_02"
    for name, text in (
        (part, "\n".join(lines)),
        (
            "calib",
            "\n".join(f"{OLD.get(key, key) if tracks else key + ':'} {value}" for key, value in CALIBRATION.items()),
        ),
    ):
        (folder / name).mkdir()
        (folder / name / "0000.txt").write_text(text + "\n")
    return folder / part / "0000.txt"


@pytest.mark.parametrize("frame", [None, 0, 1, 3])
def test_tracking_labels_of_kitti(tmp_path: Path, frame: int | None) -> None:
    lines = [
        f"{at} {track} " + OBJECT.format(name)
        for at, track, name in ((0, 4, "Car"), (0, -1, "DontCare"), (1, 4, "Van"), (1, 5, "Tram"))
    ]
    path = kitti(tmp_path, "label_02", lines)
    if frame == 3:
        with pytest.raises(FormatError, match=r"0000\.txt: there is no frame 3 in these labels of frames 0 to 1"):
            read_box_file(path, frame=frame)
        return
    if frame is None:
        with pytest.warns(
            UserWarning, match=r"0000\.txt: KITTI's tracking labels of frames 0 to 1; 0 is read \(--frame N"
        ):
            boxes = read_box_file(path)
    else:
        boxes = read_box_file(path, frame=frame)
    assert [box.label for box in boxes] == (["car", "train"] if frame == 1 else ["car"])
    assert np.allclose([boxes[0].center, boxes[0].size], [(12.27, 3.0, -0.98), (4.2, 1.8, 1.5)])
    assert boxes[0].yaw == pytest.approx(0)


def test_the_frame_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = kitti(tmp_path, "label_02", [f"{at} 0 " + OBJECT.format("Car" if at else "Van") for at in (0, 7)])
    draft = ["draft", "--boxes", str(path), "--surroundings", "bare", "--no-preview", "-o", str(tmp_path / "out.json")]
    assert main(draft) == 0
    assert "of frames 0 to 7; 0 is read (--frame N reads another)" in capsys.readouterr().err
    assert main([*draft, "--frame", "7"]) == 0
    assert Layout.load(tmp_path / "out.json")["car_1"].center == pytest.approx((12.27, 3.0, 0.75), abs=1e-6)


def test_a_frame_of_what_has_none(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"0000\.txt has no frames; --frame goes with KITTI's tracking labels"):
        read_box_file(kitti(tmp_path, "label_2", [OBJECT.format("Car")]), frame=2)


def test_other_types_and_objects_without_a_size(tmp_path: Path) -> None:
    flat = "Car 0.00 0 -10 0 0 50 50 {} {} {} -1000 -1000 -1000 -10"
    lines = [OBJECT.format(name) for name in ("Car", "Bus", "pedestrian", "Boat", "Boat", "DontCare")]
    lines += [
        flat.format(-1, -1, -1),
        flat.format(0, 0, 0),
        "Car 0.00 0 -10 0 0 50 50",
        OBJECT.format("Truck") + " 0.93",
    ]
    with pytest.warns(UserWarning, match=r"0000\.txt: objects are left out: 2 Boat, 3 without a size in 3D$"):
        boxes = read_box_file(kitti(tmp_path, "label_2", lines))
    assert [box.label for box in boxes] == ["car", "bus", "person", "truck"]


@pytest.mark.parametrize(
    ("name", "text", "tool"),
    [
        ("a.json", json.dumps({"key": "x", "objects": [], "figures": [{"geometry": {}}]}), "Supervisely"),
        ("a.json", json.dumps({"folder": "pcd", "objects": [{"name": "car", "centroid": {"x": 1}}]}), "labelCloud"),
        ("a.json", json.dumps([{"obj_id": "1", "psr": {}}]), "SUSTech"),
        (
            "tracklet_labels.xml",
            '<?xml version="1.0"?><boost_serialization><tracklets class_id="0"/>',
            "KITTI tracklets",
        ),
    ],
)
def test_box_files_of_tools_are_named(tmp_path: Path, name: str, text: str, tool: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(
        FormatError, match=rf"{name}: a file of {tool}, .* a line each of x y z length width .* as \.txt$"
    ):
        read_box_file(tmp_path / name)


def test_yaws_in_degrees_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("12 3.5 -0.98 4.2 1.8 1.5 -3.1 Car\n20 3.5 -0.98 4.2 1.8 1.5 90 Car\n")
    with pytest.raises(FormatError, match=r"a\.txt: line 2: yaw is 90; it must be radians, .*; are these degrees\?"):
        read_box_file(path)
    path.write_text("12 3.5 -0.98 4.2 1.8 1.5 -6.28 Car\n")
    assert [box.yaw for box in read_box_file(path)] == [-6.28]
