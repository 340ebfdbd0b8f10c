"""The functional test of the streets runs, and turns our classes into SemanticKITTI's as it says."""

import math
import sys

import numpy as np
import pytest
import torch

import segment_streets
from lidardraft.errors import LidarDraftError
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig, SphericalGrid
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME
from segment_streets import NAMES, RAW, ClassScores, benchmark_ids, confusion_matrix, table


def named(points, *names):
    ids = benchmark_ids(np.array(points, dtype=np.float32), np.array([BY_NAME[n].id for n in names], dtype=np.uint8))
    return [NAMES[i] for i in ids]


def test_classes_of_the_benchmark():
    ours = ("road", "wall", "bus", "train", "other", "traffic-light", "trunk", "car")
    assert named([(i, 0, 0) for i in range(8)], *ours) == [
        *("road", "fence", "other-vehicle", "other-vehicle", "unlabelled", "unlabelled", "trunk", "car")
    ]
    assert len(NAMES) == 20
    assert NAMES[RAW[60]] == "road"
    assert NAMES[RAW[255]] == "motorcyclist"


def test_a_rider_has_what_is_ridden():
    points = [(0, 0, 0), (0.5, 0, 0), (10, 0, 0), (10.5, 0, 0), (10.6, 0, 0), (10, 0.9, 0), (20, 0, 0), (30, 0, 0)]
    ours = ("rider", "bicycle", "rider", "motorcycle", "motorcycle", "bicycle", "bicycle", "rider")
    assert named(points, *ours) == [
        *("bicyclist", "bicyclist", "motorcyclist", "motorcyclist", "motorcyclist", "motorcyclist"),
        *("bicycle", "bicyclist"),
    ]


def test_the_table_counts_absent_classes_as_nothing():
    truth = np.array([NAMES.index(name) for name in ("car", "car", "road", "parking")])
    found = np.array([NAMES.index(name) for name in ("car", "road", "road", "road")])
    text = table("Two", confusion_matrix(truth, found, 20), 1, 0.5)
    assert "## Two: 1 scans, 4 labelled returns" in text
    assert "| car | 50.0 | 2 | 50% | road 50% |" in text
    assert "| road | 33.3 | 1 | 100% |  |" in text
    assert f"neither there nor found counts 0)** | **{(50 + 100 / 3) / 19:.1f}** | 19 classes" in text
    assert f"the 17 that streets have** | **{(50 + 100 / 3) / 17:.1f}** | 17 classes" in text
    assert f"those with a truth here** | **{(50 + 100 / 3) / 3:.1f}** | 3 classes" in text


def test_it_runs_on_held_out_streets_and_says_what_is_missing(tmp_path, monkeypatch, capsys):
    torch.manual_seed(0)
    config = SegmenterConfig(grid=SphericalGrid(rows=16, columns=64), widths=(8, 8))
    weight_file.save(Segmenter(config), tmp_path / "weights.safetensors", {})
    sensor = Sensor(name="small", elevations=tuple(np.linspace(0.03, -0.4, 16).tolist()), columns=64)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(60, 60, 0), label="road", id="road")
    image = raycast(Layout(primitives=(road,)), sensor)
    list(write_pairs(tmp_path / "pairs", [(Pair(image, image), {})]))
    command = ["segment_streets", str(tmp_path / "weights.safetensors"), "--pairs", str(tmp_path / "pairs")]
    monkeypatch.setattr(sys, "argv", [*command, "--data", "", "--json", str(tmp_path / "matrices.json")])
    assert segment_streets.main() == 0
    printed = capsys.readouterr()
    assert f"## Held-out streets: 1 scans, {image.valid.sum()} labelled returns" in printed.out
    assert "no recorded scans" in printed.err
    assert (tmp_path / "matrices.json").exists()


def test_real_scans_are_read_as_they_are(tmp_path):
    images = tmp_path / "kitti/range_images_00"
    images.mkdir(parents=True)
    image = np.zeros((2, 3, 6))
    image[0, 1] = [3, 4, 0, 0.25, 5, 9]
    np.save(images / "000000.npy", image)
    (scan,) = segment_streets.range_images(tmp_path)
    np.testing.assert_array_equal(scan.points, [[3, 4, 0]])
    assert scan.intensity.tolist() == [0.25]
    assert scan.truth.tolist() == [9]
    (tmp_path / "kitti/odometry_00/labels").mkdir(parents=True)
    (tmp_path / "kitti/odometry_00/velodyne").mkdir()
    np.array([[1, 2, 3, 0.5], [4, 5, 6, 0.25]], "<f4").tofile(tmp_path / "kitti/odometry_00/velodyne/000000.bin")
    np.array([252 | 7 << 16, 99], "<u4").tofile(tmp_path / "kitti/odometry_00/labels/000000.label")
    (scan,) = segment_streets.whole_scans(tmp_path)
    assert [NAMES[i] for i in scan.truth] == ["car", "unlabelled"]
    assert scan.intensity.tolist() == [0.5, 0.25]


@pytest.mark.parametrize("raw", sorted(RAW))
def test_raw_ids_agree_with_the_formats_table(raw):
    from lidardraft.formats.semantickitti import CLASS_FROM_RAW

    ours = CLASS_FROM_RAW[raw]
    theirs = NAMES[RAW[raw]]
    same = {
        **{"parking": "road", "other-ground": "terrain", "bicyclist": "rider", "motorcyclist": "rider"},
        "other-vehicle": ours if ours in ("bus", "train", "truck") else "",
    }
    assert same.get(theirs, theirs) == ours


#                   unlabelled, 1 x 4,      2 x 3,   3 x 1
TRUTH = np.array([0, 0, 1, 1, 1, 1, 2, 2, 2, 3])
FOUND = np.array([1, 2, 1, 1, 1, 2, 2, 2, 0, 1])


def test_a_matrix_by_hand():
    expected = [[0, 1, 1, 0, 0], [0, 3, 1, 0, 0], [1, 0, 2, 0, 0], [0, 1, 0, 0, 0], [0, 0, 0, 0, 0]]
    np.testing.assert_array_equal(confusion_matrix(TRUTH, FOUND, 5), expected)


def test_scores_by_hand():
    scores = ClassScores.from_confusion(confusion_matrix(TRUTH, FOUND, 5))
    # 1: 3 right, 4 true, 4 found among the labelled; 2: 2 right, 3 true, 3 found; what is unlabelled does not count
    np.testing.assert_allclose(scores.iou, [0.0, 3 / 5, 2 / 4, 0.0, np.nan])
    np.testing.assert_array_equal(scores.truth, [0, 4, 3, 1, 0])
    assert scores.mean([1, 2, 3]) == pytest.approx(1.1 / 3)
    assert scores.mean([1, 2, 3, 4]) == pytest.approx(1.1 / 4)  # 4 is neither there nor found
    assert math.isnan(scores.mean([]))


def test_images_that_do_not_fit():
    with pytest.raises(LidarDraftError, match=r"truth is \(10,\) and the labels found are \(9,\)"):
        confusion_matrix(TRUTH, FOUND[:9], 5)
    with pytest.raises(LidarDraftError, match="a truth is 0 or 3; ids are 0 to 2"):
        confusion_matrix(TRUTH, FOUND, 3)
    with pytest.raises(LidarDraftError, match="a label found is -1 or 2"):
        confusion_matrix(TRUTH, FOUND - np.where(FOUND == 0, 1, 0), 5)
