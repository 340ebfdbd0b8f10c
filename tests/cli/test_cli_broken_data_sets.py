"""`lidardraft pairs --dataset` on data sets of one scan in which a file is broken, cut or of something else."""

import gzip
import itertools
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Scan, Sensor, simulate
from lidardraft.cli import main as cli
from lidardraft.formats.kitti import write_bin
from lidardraft.formats.nuscenes import write_pcd_bin
from lidardraft.formats.semantickitti import write_label
from small_recordings import pandas_pickle, pandaset

NOISE = np.random.default_rng(0).bytes(1001)  # test_readers.py breaks files in more ways
DRIVE = "2013_05_28_drive_0000_sync"


def semantickitti(root: Path, scan: Scan) -> None:
    for part in ("velodyne", "labels"):
        (root / "sequences/00" / part).mkdir(parents=True)
    write_bin(root / "sequences/00/velodyne/000000.bin", scan.points(), scan.intensities())
    write_label(root / "sequences/00/labels/000000.label", scan.labels(), scan.instances())


def kitti(root: Path, scan: Scan) -> None:
    for part in ("velodyne", "label_2", "calib"):
        (root / "training" / part).mkdir(parents=True)
    write_bin(root / "training/velodyne/000000.bin", scan.points(), scan.intensities())
    (root / "training/label_2/000000.txt").write_text("Car 0 0 0 0 0 0 0 1.6 1.8 4.5 -3.0 1.6 10.0 -1.57\n")
    turn = "R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
    (root / "training/calib/000000.txt").write_text(turn)


def kitti360(root: Path, scan: Scan) -> None:
    scans = root / "data_3d_raw" / DRIVE / "velodyne_points" / "data"
    for folder in (scans, root / "calibration", root / "data_poses" / DRIVE, root / "data_3d_bboxes/train"):
        folder.mkdir(parents=True)
    write_bin(scans / "0000000000.bin", scan.points(), scan.intensities())
    (root / "calibration/calib_cam_to_velo.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n")
    (root / f"data_poses/{DRIVE}/cam0_to_world.txt").write_text("0 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n")
    pose = "<transform><data>4.5 0 0 10 0 1.8 0 3 0 0 1.6 -1 0 0 0 1</data></transform>"
    corners = "<vertices><data>-0.5 -0.5 -0.5 0.5 0.5 0.5</data></vertices>"
    text = f"<a><object1><label>car</label>{pose}{corners}</object1></a>"
    (root / f"data_3d_bboxes/train/{DRIVE}.xml").write_text(text)


def nuscenes(root: Path, scan: Scan) -> None:
    for part in ("v1.0-mini", "samples/LIDAR_TOP", "lidarseg"):
        (root / part).mkdir(parents=True)
    count = len(scan.points())
    write_pcd_bin(root / "samples/LIDAR_TOP/a.pcd.bin", scan.points(), scan.intensities(), np.zeros(count))
    (root / "lidarseg/l.bin").write_bytes(bytes([24]) * count)
    rows = {"sample_data": {"token": "s", "filename": "samples/LIDAR_TOP/a.pcd.bin"},
            "lidarseg": {"sample_data_token": "s", "filename": "lidarseg/l.bin"}}  # fmt: skip
    for name, row in rows.items():
        (root / f"v1.0-mini/{name}.json").write_text(json.dumps([row]))


def of_pandaset(root: Path, scan: Scan) -> None:
    sweep, points = pandaset(root), scan.points().astype(np.float64)
    count = len(points)
    world = dict(zip("xyz", (points[:, [1, 0, 2]] * (-1, 1, 1) + (5, 7, 1.87)).T, strict=True))
    rest = {"i": 255 * scan.intensities().astype(float), "t": np.full(count, 9.9), "d": np.zeros(count, int)}
    sweep.write_bytes(gzip.compress(pandas_pickle(**world, **rest), 1))
    labels = sweep.parents[1] / "annotations/semseg" / sweep.name
    labels.write_bytes(gzip.compress(pandas_pickle(**{"class": np.full(count, 7)})))


SETS = {
    "semantickitti": semantickitti,
    "kitti": kitti,
    "kitti360": kitti360,
    "nuscenes": nuscenes,
    "pandaset": of_pandaset,
}


@pytest.mark.parametrize("name", SETS)
def test_each_file_of_a_data_set_broken_in_each_way(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    road = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road")
    car = Primitive(shape="box", center=(10, 3, 0.8), size=(4.5, 1.8, 1.6), label="car", id="car", instance=1)
    good = Path("good")
    SETS[name](good, simulate(Layout((road, car)), Sensor.load("small.json"), seed=0))
    argv = ["pairs", "--dataset", name, "--sensor", "small.json", "-o"]
    assert cli.main([*argv, "out", "good"]) == 0
    refused, files = set(), {path.relative_to(good) for path in good.rglob("*") if path.is_file()}
    for number, (file, way) in enumerate(itertools.product(sorted(files), ("cut", "noise"))):
        root = shutil.copytree(good, f"set_{number}")
        whole = (good / file).read_bytes()
        (root / file).write_bytes(NOISE if way == "noise" else whole[: len(whole) // 2 - 1])
        capsys.readouterr()
        code = cli.main([*argv, f"out_{number}", str(root)])
        said = [line for line in capsys.readouterr().err.splitlines() if "predicts them" not in line]
        assert all(line.startswith("lidardraft: ") and line.isprintable() for line in said), (file, way)
        if code:
            assert file.name in said[0], (file, way, said)
            refused.add(file)
    assert refused == files
