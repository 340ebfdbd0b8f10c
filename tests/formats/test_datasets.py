"""Whole data sets: their files, and on real samples of them what boxes and labels say of the points."""

import gzip
import json
import math
import os
import pickle
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.formats.datasets import RecordedFile, dataset_files
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.nuscenes import labelled_sweeps
from lidardraft.formats.pickled_table import read_pickled_table
from lidardraft.formats.recording import read_points
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, CLASSES
from lidardraft.training.recorded_pairs import LabelledCloud, beside_beams
from small_recordings import pandas_pickle, pandaset

DATA = Path(os.environ.get("LIDARDRAFT_DATA", "nowhere"))
NUMBERS_OF_BOXES = (
    "yaw",
    "cuboids.sensor_id",
    *(f"{name}.{axis}" for name in ("position", "dimensions") for axis in "xyz"),
)
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


@pytest.mark.parametrize(("good", "bad"), [("0 -1 0 0", "0 -2 0 0"), ("0 -1 0 0", "0 0 0 0"), ("-0.08", "1e30")])
def test_boxes_are_not_moved_by_what_is_no_rigid_pose(tmp_path: Path, good: str, bad: str) -> None:
    label, calib = labelled(tmp_path, f"{CAR} -1.570796")
    calib.write_text(CALIBRATION.replace(good, bad))
    with pytest.raises(FormatError, match=r"calib.txt: R0_rect or Tr_velo_to_cam is not a rotation"):
        read_label_2(label, calib)


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
    file.scan.parent.mkdir(parents=True)
    file.scan.write_bytes(np.ones((4, 5), "<f4").tobytes())
    lidarseg = tmp_path / "lidarseg/v1.0-mini/l_lidarseg.bin"
    lidarseg.parent.mkdir(parents=True)
    lidarseg.write_bytes(bytes([24, 17, 2, 31]))
    labels = read_points(file.scan)[1]["label"]
    assert labels.tolist() == [BY_NAME[name].id for name in ("road", "car", "person", "none")]
    lidarseg.write_bytes(bytes([24, 17, 2]))
    with pytest.raises(FormatError, match=r"l_lidarseg.bin has 3 labels; the sweep has 4 points"):
        read_points(file.scan)
    lidarseg.write_bytes(bytes([24, 17, 2, 32]))
    with pytest.raises(FormatError, match=r"l_lidarseg.bin has class 32; lidarseg has 0 to 31"):
        read_points(file.scan)


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


def test_a_sweep_of_pandaset_comes_in_the_frame_of_its_sensor(tmp_path: Path) -> None:
    sweep = pandaset(tmp_path)
    (file,) = dataset_files("pandaset", tmp_path)
    assert file.scan == sweep
    points, fields = read_points(sweep)
    (car,) = file.boxes()
    assert points.shape == (2, 3)  # the third is the PandarGT's
    # the vehicle looks along y from (5, 7, 0); its sensor stands 0.82 m ahead, 1.86 m up, and looks up by 0.9 degrees
    ahead, up = 10 - 0.82, 1 - 1.86
    np.testing.assert_allclose(points[0], (ahead + 0.0157 * up, 0, up - 0.0157 * ahead), atol=2e-3)
    np.testing.assert_allclose(points[1] - points[0], (0, -3, 0), atol=1e-6)
    np.testing.assert_allclose(car.center, points[0] - (0, 0, 0.25), atol=5e-3)
    assert (car.size, car.yaw) == ((4.2, 1.8, 1.5), pytest.approx(0.5, abs=1e-3))  # a yaw of 0 is along y
    np.testing.assert_allclose(fields["intensity"], (0, 0.2), atol=1e-6)
    assert [CLASSES[label].name for label in fields["label"]] == ["car", "road"]
    elevation = np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))
    beams = np.array(Sensor.preset("pandar64").elevations)
    np.testing.assert_array_equal(fields["ring"], np.abs(elevation[:, None] - beams).argmin(axis=1))
    car_alone = np.zeros(2, np.uint8)
    file.mark_boxes(points, car_alone, np.zeros(2, np.uint32))
    assert car_alone.tolist() == [BY_NAME["car"].id, 0]


def test_points_of_a_vehicle_that_drives_are_brought_to_the_middle_of_the_sweep(tmp_path: Path) -> None:
    sweep = pandaset(tmp_path)
    heading = {"w": -1, "x": 0, "y": 0, "z": 0}  # as w = 1
    poses = [
        {"position": {"x": 5, "y": 6, "z": 0}, "heading": heading},
        *json.loads((sweep.parent / "poses.json").read_text()),
    ]
    (sweep.parent / "poses.json").write_text(json.dumps(poses))  # 1 m in 0.1 s
    (sweep.parent / "timestamps.json").write_text("[9.9, 10.0]")
    moved = sweep.replace(sweep.with_name("01.pkl.gz"))
    points, fields = read_points(moved)
    np.testing.assert_allclose(points[0, 0], 10.5 - 0.82, atol=0.02)  # of the pose in the middle
    fired = math.atan2(1 - 1.86, 11 - 0.82) - math.radians(0.9)  # at 9.9 s, when it was 11 m off
    beams = np.array(Sensor.preset("pandar64").elevations)
    assert (
        fields["ring"][0] == np.abs(beams - fired).argmin() != np.abs(beams - math.atan2(*points[0, [2, 0]])).argmin()
    )
    with pytest.raises(FormatError, match=r"07.pkl.gz: the drive has poses of sweeps 0 to 1, none of 07"):
        read_points(moved.replace(moved.with_name("07.pkl.gz")))


@pytest.mark.parametrize(
    ("part", "columns", "message"),
    [
        ("annotations/semseg", {"class": np.array([13, 7])}, "has 2 labels; the sweep has 3 points"),
        ("annotations/semseg", {"class": np.array([13, 7, 43])}, "has class 43; PandaSet has 1 to 42"),
        ("annotations/semseg", {"label": np.array([13, 7, 1])}, "there is no column class of finite numbers"),
        ("annotations/semseg", {"class": np.array([13, 7, 0.5])}, "has class 0.5; PandaSet has 1 to 42"),
        ("annotations/cuboids", {"label": np.array(["Ship"], object)}, "there is no column yaw of finite numbers"),
        (
            "annotations/cuboids",
            {"label": np.array(["Ship"], object)} | dict.fromkeys(NUMBERS_OF_BOXES, np.ones(1)),
            "00.pkl.gz: a box is 'Ship'; it must be one of",
        ),
        ("lidar", dict.fromkeys("xyzitd", np.zeros(0)), "has 3 labels; the sweep has 0 points"),
        ("lidar", {"x": np.array(["far"], object)}, "00.pkl.gz: there is no column x of finite numbers"),
    ],
)
def test_tables_of_pandaset_with_other_columns(
    tmp_path: Path, part: str, columns: dict[str, np.ndarray], message: str
) -> None:
    sweep = pandaset(tmp_path)
    (sweep.parents[1] / part / sweep.name).write_bytes(gzip.compress(pandas_pickle(**columns)))
    with pytest.raises(FormatError, match=message):
        (read_points(sweep), dataset_files("pandaset", tmp_path)[0].boxes())


@pytest.mark.skipif(not (DATA / "permissive/pandaset").is_dir(), reason="LIDARDRAFT_DATA holds no PandaSet")
def test_boxes_of_a_real_sweep_of_pandaset_hold_points_of_their_class(tmp_path: Path) -> None:
    sweep = pandaset(tmp_path)
    with np.load(DATA / "permissive/pandaset/002/00.npz") as file:  # x ahead, y left, z up, 1.87 m over that of poses
        world = file["xyz"].astype(np.float64)[:, [1, 0, 2]] * (-1, 1, 1) + (5, 7, 1.87)
        place = file["box_center"].astype(np.float64)[:, [1, 0, 2]] * (-1, 1, 1) + (5, 7, 1.87)
        size, names = file["box_size_lwh"][:, [1, 0, 2]].astype(np.float64), file["box_class"].astype(object)
        points = {"i": file["intensity"].astype(float), "t": np.full(len(world), 9.95), "d": file["device"].astype(int)}
        raw, yaw = file["label"].astype(int), file["box_yaw"].astype(np.float64)
    axes = {f"{name}.{axis}": values[:, k] for name, values in (("position", place), ("dimensions", size))
            for k, axis in enumerate("xyz")}  # fmt: skip
    whose = {"label": names, "yaw": yaw, "cuboids.sensor_id": np.full(len(yaw), -1)}
    for part, columns in (
        ("lidar", points | dict(zip("xyz", world.T, strict=True))),
        ("annotations/cuboids", whose | axes),
        ("annotations/semseg", {"class": raw}),
    ):
        (sweep.parents[1] / part / sweep.name).write_bytes(gzip.compress(pandas_pickle(**columns), 1))
    seen, fields = read_points(sweep)
    marked, instance = np.zeros(len(seen), np.uint8), np.zeros(len(seen), np.uint32)
    dataset_files("pandaset", tmp_path)[0].mark_boxes(seen, marked, instance)
    assert np.count_nonzero(marked) > 10_000
    assert np.mean(marked[marked > 0] == fields["label"][marked > 0]) > 0.97
    scan = LabelledCloud(points=seen, intensity=fields["intensity"], label=fields["label"])
    assert beside_beams(scan, Sensor.preset("pandar64")) < 0.12  # 0.25 where points and beams have no relation


def test_a_pickle_is_read_and_not_run(tmp_path: Path) -> None:
    path = tmp_path / "a.pkl.gz"
    command = f"touch {tmp_path}/pwned"
    program = pickle.dumps(command, 0)[:-1].replace(b"V", b"cos\nsystem\n(V", 1) + b"tR."
    path.write_bytes(gzip.compress(program))
    with pytest.raises(FormatError, match=r"a.pkl.gz: not a table of pandas 0.24 to 1.2"):
        read_pickled_table(path)
    assert os.listdir(tmp_path) == ["a.pkl.gz"]


def test_folders_that_are_no_data_set(tmp_path: Path) -> None:
    for name, message in (
        ("semantickitti", r"there is no sequences/NN/velodyne/\*.bin of semantickitti"),
        ("kitti", r"there is no training/velodyne/\*.bin of kitti"),
        ("kitti360", r"there is no data_3d_raw/DRIVE/velodyne_points/data/\*.bin of kitti360, split all"),
        ("nuscenes", r"holds 0 folders of tables"),
        ("pandaset", r"there is no NNN/lidar/\*.pkl.gz of pandaset"),
    ):
        with pytest.raises(FormatError, match=message):
            dataset_files(name, tmp_path)
    tables(tmp_path, sweep="../a.pcd.bin")
    with pytest.raises(FormatError, match=r"sample_data.json: row 0 names '../a.pcd.bin', which is outside"):
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
