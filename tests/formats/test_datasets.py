"""Whole data sets: their files, and on real samples of them what boxes and labels say of the points."""

import json
import math
import os
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.formats.datasets import RecordedFile, dataset_files
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.nuscenes import labelled_sweeps, read_lidarseg
from lidardraft.semantics import BY_NAME

DATA = Path(os.environ.get("LIDARDRAFT_DATA", "nowhere"))
CALIBRATION = "R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27\n"
CAR = "Car 0.00 0 1.85 387.63 181.54 423.81 203.12 1.5 1.8 4.0 -3.0 1.6 14.0"


def labelled(folder: Path, *lines: str) -> tuple[Path, Path]:
    files = folder / "label.txt", folder / "calib.txt"
    for file, text in zip(files, ("".join(f"{line}\n" for line in lines), CALIBRATION), strict=True):
        file.write_text(text)
    return files


def test_points_in_boxes_have_their_class_but_not_the_road_below(tmp_path: Path) -> None:
    points = np.array([[14.27, 3, -1], [14.27, 3, -1.65], [16, 3, -1], [16.5, 3, -1], [14.27, 4, -1]], np.float32)
    label, instance = np.ones(5, np.uint8), np.zeros(5, np.uint32)
    file = RecordedFile(Path("0.bin"), boxes=partial(read_label_2, *labelled(tmp_path, f"{CAR} -1.570796")))
    file.mark_boxes(points, label, instance)
    car = BY_NAME["car"].id
    assert label.tolist() == [car, 1, car, 1, 1]
    assert instance.tolist() == [1, 0, 1, 0, 0]


def test_boxes_of_kitti_need_their_calibration(tmp_path: Path) -> None:
    file, _ = labelled(tmp_path, f"{CAR} -1.570796")
    with pytest.raises(FormatError, match=r"label.txt needs its calibration: .*calib/label.txt: No such file"):
        read_label_2(file)


def test_semantickitti_has_splits(tmp_path: Path) -> None:
    for number in ("00", "08", "11"):
        (tmp_path / "sequences" / number / "velodyne").mkdir(parents=True)
        (tmp_path / "sequences" / number / "velodyne" / "000000.bin").write_bytes(b"")
    for split, numbers in (("train", ["00"]), ("val", ["08"]), ("all", ["00", "08"])):  # 11 to 21 have no labels
        files = dataset_files("semantickitti", tmp_path, split)
        assert [file.scan.parts[-3] for file in files] == numbers


def tables(root: Path, sweep: str = "samples/LIDAR_TOP/a.pcd.bin") -> None:
    """Tables of nuScenes of one labelled key frame, and of a sweep without labels."""
    (root / "v1.0-mini").mkdir(parents=True, exist_ok=True)
    rows = [{"token": "s1", "filename": sweep}, {"token": "s2", "filename": "sweeps/LIDAR_TOP/b.pcd.bin"}]
    (root / "v1.0-mini" / "sample_data.json").write_text(json.dumps(rows))
    labels = [{"token": "l", "sample_data_token": "s1", "filename": "lidarseg/v1.0-mini/l_lidarseg.bin"}]
    (root / "v1.0-mini" / "lidarseg.json").write_text(json.dumps(labels))


def test_nuscenes_has_labels_by_its_tables(tmp_path: Path) -> None:
    tables(tmp_path)
    (file,) = dataset_files("nuscenes", tmp_path)
    assert file.scan == tmp_path / "samples/LIDAR_TOP/a.pcd.bin"
    assert file.lidarseg is not None
    file.lidarseg.parent.mkdir(parents=True)
    file.lidarseg.write_bytes(bytes([24, 17, 2, 31]))
    labels = file.labels(4)
    assert labels is not None
    assert labels.tolist() == [BY_NAME[name].id for name in ("road", "car", "person", "none")]
    with pytest.raises(FormatError, match=r"l_lidarseg.bin has 4 labels; the sweep has 5 points"):
        file.labels(5)
    file.lidarseg.write_bytes(bytes([24, 17, 2, 32]))
    with pytest.raises(FormatError, match=r"l_lidarseg.bin has class 32; lidarseg has 0 to 31"):
        read_lidarseg(file.lidarseg, 4)


DRIVE = "2013_05_28_drive_0003_sync"
TURNED = np.array([(0, -1, 0, 5), (1, 0, 0, -7), (0, 0, 1, 2), (0, 0, 0, 1)], float)  # world_from_velodyne
# camera 0 looks ahead: x right, y down, z ahead
VELODYNE_FROM_CAMERA = np.array([(0, 0, 1, 0.8), (-1, 0, 0, 0.1), (0, -1, 0, -0.1), (0, 0, 0, 1)], float)


def numbers(values: np.ndarray) -> str:
    return " ".join(map(str, np.ravel(values).tolist()))


def kitti360_object(label: str, pose: np.ndarray, size: tuple[float, ...], more: str = "") -> str:
    """An object as data_3d_bboxes has it: a unit cube that is scaled, turned and moved."""
    cube = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    transform = pose @ np.diag([*size, 1.0])
    return (
        f"<object1><label>{label}</label>"
        f"<transform type_id='opencv-matrix'><data>{numbers(transform)}</data></transform>"
        f"<vertices type_id='opencv-matrix'><data>{numbers(np.array(cube))}</data></vertices>{more}</object1>"
    )


def kitti360(root: Path, *objects: str) -> RecordedFile:
    """A drive of two scans, of which the first has a pose."""
    for folder in ("calibration", f"data_poses/{DRIVE}", "data_3d_bboxes/train"):
        (root / folder).mkdir(parents=True, exist_ok=True)
    (root / "calibration/calib_cam_to_velo.txt").write_text(numbers(VELODYNE_FROM_CAMERA[:3]))
    rows = f"0 {numbers(TURNED @ VELODYNE_FROM_CAMERA)}\n"
    (root / f"data_poses/{DRIVE}/cam0_to_world.txt").write_text(rows)
    scans = root / "data_3d_raw" / DRIVE / "velodyne_points" / "data"
    scans.mkdir(parents=True, exist_ok=True)
    for number in range(2):
        (scans / f"{number:010d}.bin").write_bytes(b"")
    text = f"<?xml version='1.0'?><opencv_storage>{''.join(objects)}</opencv_storage>"
    (root / f"data_3d_bboxes/train/{DRIVE}.xml").write_text(text)
    return dataset_files("kitti360", root, "lidm-val")[0]


def test_boxes_of_kitti360_come_in_the_frame_of_each_scan(tmp_path: Path) -> None:
    in_scan = np.eye(4)
    in_scan[:3, :3] = [(0.8, -0.6, 0), (0.6, 0.8, 0), (0, 0, 1)]
    in_scan[:3, 3] = 12.0, 3.0, -0.9
    placed = TURNED @ in_scan
    moving = "<dynamic>1</dynamic><timestamp>{}</timestamp>"
    file = kitti360(
        tmp_path,
        kitti360_object("building", placed, (9.0, 9.0, 9.0)),
        kitti360_object("car", placed, (4.2, 1.8, 1.5)),
        kitti360_object("person", placed, (0.5, 0.6, 1.7), moving.format(0)),
        kitti360_object("bus", placed, (9.0, 2.5, 3.0), moving.format(1)),
        kitti360_object("traffic sign", placed, (0.1, 0.6, 0.6)),
    )
    car, person, sign = file.boxes()
    assert (car.label, person.label, sign.label) == ("car", "person", "traffic-sign")
    np.testing.assert_allclose(car.center, (12.0, 3.0, -0.9), atol=1e-9)
    np.testing.assert_allclose(car.size, (4.2, 1.8, 1.5), atol=1e-9)
    assert math.cos(car.yaw - math.atan2(0.6, 0.8)) ** 2 == pytest.approx(1.0)
    assert (sign.instance, len({car.instance, person.instance, 0})) == (0, 3)
    later = dataset_files("kitti360", tmp_path)[1]
    assert later.boxes() == []  # it has no pose


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        (f"data_3d_bboxes/train/{DRIVE}.xml", "<a><b>", "xml: no element found|xml: mismatched|xml: unclosed"),
        (f"data_3d_bboxes/train/{DRIVE}.xml", "<a><b><label>car</label></b></a>", r"object 1 \(car\) has no transform"),
        (f"data_3d_bboxes/train/{DRIVE}.xml", "<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>", "xml: .*Entit"),
        (f"data_poses/{DRIVE}/cam0_to_world.txt", "0 1 2", "line 1 must be 17 finite numbers"),
        ("calibration/calib_cam_to_velo.txt", "a b", "could not convert"),
    ],
)
def test_broken_files_of_kitti360(tmp_path: Path, name: str, text: str, message: str) -> None:
    file = kitti360(tmp_path)
    (tmp_path / name).write_text(text)
    with pytest.raises(FormatError, match=message):
        file.boxes()


@pytest.mark.skipif(not (DATA / "kitti360/label_tool").is_dir(), reason="LIDARDRAFT_DATA holds no KITTI-360")
def test_a_real_street_of_kitti360s_tool_has_cars_of_the_size_of_cars(tmp_path: Path) -> None:
    file = kitti360(tmp_path)
    text = (DATA / "kitti360/label_tool/log0.xml").read_text()
    (tmp_path / f"data_3d_bboxes/train/{DRIVE}.xml").write_text(text)
    cars = [box for box in file.boxes() if box.label == "car"]
    assert len(cars) == 5
    sizes = np.array([box.size for box in cars])
    assert ((sizes > (3.0, 1.4, 1.2)) & (sizes < (6.5, 3.5, 3.0))).all()


def test_folders_that_are_no_data_set(tmp_path: Path) -> None:
    for name, message in (
        ("semantickitti", r"there is no sequences/NN/velodyne/\*.bin of semantickitti"),
        ("kitti", r"there is no training/velodyne/\*.bin of kitti"),
        ("kitti360", r"there is no data_3d_raw/DRIVE/velodyne_points/data/\*.bin of kitti360, split all"),
        ("nuscenes", r"holds 0 folders of tables"),
    ):
        with pytest.raises(FormatError, match=message):
            dataset_files(name, tmp_path)
    tables(tmp_path, sweep="../a.pcd.bin")
    with pytest.raises(FormatError, match=r"sample_data.json: row 0 names '../a.pcd.bin', which lies outside"):
        labelled_sweeps(tmp_path)
    (tmp_path / "v1.0-mini" / "sample_data.json").write_text('[{"token": 3}]')
    with pytest.raises(FormatError, match=r"sample_data.json: row 0 has not all of token, filename"):
        labelled_sweeps(tmp_path)


@pytest.mark.skipif(not (DATA / "kitti/object").is_dir(), reason="LIDARDRAFT_DATA holds no objects of KITTI")
def test_boxes_of_real_objects_hold_their_points() -> None:
    files = [
        file
        for file in dataset_files("kitti", DATA / "kitti/object")
        if (DATA / "kitti/object/training/label_2" / f"{file.scan.stem}.txt").exists()
    ]
    assert len(files) >= 3
    held = 0
    for file in files:
        points, _ = read_bin(file.scan)
        label, instance = np.zeros(len(points), np.uint8), np.zeros(len(points), np.uint32)
        file.mark_boxes(points, label, instance)
        for box in file.boxes():
            near = math.dist(box.center, (0, 0, 0)) < 30
            count = np.count_nonzero(instance == box.instance)
            held += count
            assert count > 10 or not near, (file.scan.name, box.id)
            # a box stands on the ground: hardly a point lies just below it
            below = points[:, 2] < box.center[2] - box.size[2] / 2 - 0.3
            around = np.linalg.norm(points[:, :2] - box.center[:2], axis=1) < 0.4 * box.size[0]
            assert np.count_nonzero(below & around) <= max(0.05 * count, 20), (file.scan.name, box.id)
    assert held > 1000
