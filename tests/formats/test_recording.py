"""Recordings out of files, and files that are none."""

import struct
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.drafting.text.layout import layout_from_text
from lidardraft.errors import FormatError
from lidardraft.formats.kitti import write_bin
from lidardraft.formats.recording import read_points, read_recording, recording_of, returns
from lidardraft.formats.semantickitti import write_label

WALL = Primitive(shape="cylinder", center=(5, 0, 50), size=(60, 60, 100), label="building", id="hall")
SENSOR = Sensor(name="mine", elevations=(0.0, -0.05, -0.1, -0.2), columns=360, azimuth_start=2 * np.pi)


@pytest.fixture(scope="module")
def image():
    return raycast(layout_from_text("houses along both sides, two cars ahead", seed=1), SENSOR)


@pytest.fixture
def in_kitti_order(image):
    """Points, rings and labels laser by laser, each once around to the left from straight ahead."""
    points, ring = image.points(), image.beams().astype(int)
    order = np.lexsort((np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi), ring))
    return points[order], ring[order], image.label[image.valid][order]


def write_pcd(path, names, columns, width=0, height=1):
    lines = [f"FIELDS {' '.join(names)}", f"SIZE {'4 ' * len(names)}", f"TYPE {'F ' * len(names)}"]
    count = len(columns[0])
    lines += [f"WIDTH {width or count}", f"HEIGHT {height}", f"POINTS {count}", "DATA binary"]
    path.write_bytes("\n".join(lines).encode() + b"\n" + np.stack(columns, axis=1).astype("<f4").tobytes())


def test_kitti_files_have_their_lasers_in_order_and_labels_beside_them(tmp_path, in_kitti_order):
    points, ring, label = in_kitti_order
    write_bin(tmp_path / "a.bin", points, np.linspace(0, 1, len(points), dtype=np.float32))
    recording = read_recording(tmp_path / "a.bin")
    np.testing.assert_array_equal(recording.points, points)
    np.testing.assert_array_equal(recording.ring, ring)
    assert recording.label is None
    assert recording.intensity.max() == 1.0
    write_label(tmp_path / "a.label", label, np.zeros(len(label), np.uint32))
    np.testing.assert_array_equal(read_recording(tmp_path / "a.bin").label, label)
    (tmp_path / "velodyne").mkdir()
    (tmp_path / "labels").mkdir()
    (tmp_path / "a.bin").rename(tmp_path / "velodyne" / "a.bin")
    (tmp_path / "a.label").rename(tmp_path / "labels" / "a.label")
    np.testing.assert_array_equal(read_recording(tmp_path / "velodyne" / "a.bin").label, label)


@pytest.mark.parametrize("first", range(4))
def test_scans_of_ours_have_their_lasers_in_order_from_behind(tmp_path, first):
    sensor = replace(SENSOR, elevations=SENSOR.elevations[first:], azimuth_start=np.pi)
    image = raycast(
        Layout((Primitive(shape="plane", center=(0, 0, 0), size=(90, 90, 0), label="road", id="r"), WALL)), sensor
    )
    write_bin(tmp_path / "a.bin", image.points(), np.zeros(image.valid.sum(), np.float32))
    np.testing.assert_array_equal(read_recording(tmp_path / "a.bin").ring, image.beams())


@pytest.mark.parametrize("field", ["ring", "channel"])
def test_a_pcd_file_has_rings(tmp_path, image, field):
    points, ring = image.points(), image.beams().astype(float)
    write_pcd(tmp_path / "a.pcd", ["x", "y", "z", "intensity", field], [*points.T, ring * 80, ring])
    recording = read_recording(tmp_path / "a.pcd", intensity_scale=255)
    np.testing.assert_array_equal(recording.ring, ring)
    np.testing.assert_allclose(recording.intensity, ring * 80 / 255, rtol=1e-6)
    assert recording.column is None


def test_an_organised_pcd_file_has_rows_and_columns(tmp_path, image):
    points = np.where(image.valid[..., None], SENSOR.pattern.points(image.depth), np.nan).reshape(-1, 3)
    write_pcd(tmp_path / "a.pcd", ["x", "y", "z"], [*points.T], width=360, height=4)
    recording = read_recording(tmp_path / "a.pcd")
    np.testing.assert_array_equal(recording.ring, image.beams())
    np.testing.assert_array_equal(recording.column, np.nonzero(image.valid)[1])
    assert recording.intensity is None


def test_an_npz_file_says_what_it_has(tmp_path, image):
    points, ring = image.points(), image.beams()
    np.savez(tmp_path / "a.npz", xyz=points.astype(np.float64), ring=ring, intensity=ring.astype(np.uint8))
    recording = read_recording(tmp_path / "a.npz")
    np.testing.assert_allclose(recording.points, points)
    np.testing.assert_array_equal(recording.ring, ring)
    np.testing.assert_allclose(recording.intensity, ring / 255, rtol=1e-6)


def test_a_sweep_of_nuscenes_has_rings_from_the_lowest_and_another_frame(tmp_path, image):
    points, ring = image.points(), image.beams()
    sweep = np.stack([-points[:, 1], points[:, 0], points[:, 2], ring * 80, 3 - ring], axis=1)
    sweep.astype("<f4").tofile(tmp_path / "a.pcd.bin")
    recording = read_recording(tmp_path / "a.pcd.bin")
    np.testing.assert_allclose(recording.points, points)
    np.testing.assert_array_equal(recording.ring, 3 - ring)
    np.testing.assert_allclose(recording.intensity, ring * 80 / 255, rtol=1e-6)


def test_points_that_are_no_returns_are_left_out():
    points = np.array([[0, 0, 0], [1, 2, 3], [np.nan, 1, 1], [np.inf, 0, 0], [4, 5, 6]])
    recording = recording_of("a", points, ring=np.arange(5), label=np.arange(5))
    np.testing.assert_array_equal(recording.ring, [1, 4])
    np.testing.assert_array_equal(recording.label, [1, 4])


@pytest.mark.parametrize(
    ("points", "fields", "message"),
    [
        (np.zeros((9, 3)), {}, "the scan is empty: it has no return"),
        (np.full((9, 3), np.nan), {}, "the scan is empty"),
        (np.ones((9, 2)), {}, r"points \(9, 2\) must be \[N, 3\]"),
        (np.ones((9, 3)), {"ring": np.zeros(4)}, "with a value of each field for each"),
        (np.ones((9, 3)), {"ring": np.full(9, -1)}, "rings are -1 to -1; they must be 0 to 511"),
        (np.ones((9, 3)), {"ring": np.zeros(9), "intensity": np.full(9, 300.0)}, "an intensity is not finite or not"),
        (np.ones((9, 3)), {"ring": np.zeros(9), "intensity": np.full(9, np.nan)}, "an intensity is not finite or not"),
        (np.ones((9, 3)), {"label": np.full(9, 42)}, "label holds 42 to 42; classes are 0 to 20"),
        (np.ones((9, 3)), {"label": np.arange(9) - 1}, "label holds -1 to 7; classes are 0 to 20"),
        (np.random.default_rng(0).normal(size=(999, 3)), {}, "the lasers of the points are unknown: no field ring"),
        (np.ones((3, 3)), {}, "the lasers of the points are unknown"),
    ],
)
def test_what_is_no_recording(points, fields, message):
    with pytest.raises(FormatError, match=message):
        recording_of("a", points, **fields)


def test_files_that_are_none(tmp_path, in_kitti_order):
    points, _, _ = in_kitti_order
    with pytest.raises(
        FormatError, match=r"a.xyz: a recorded scan is one of .bin, .pcd.bin, .pcd, .ply, .npz, .npy, .las"
    ):
        read_recording(tmp_path / "a.xyz")
    mixed = np.random.default_rng(0).permutation(points)
    write_bin(tmp_path / "a.bin", mixed, np.zeros(len(mixed), np.float32))
    with pytest.raises(FormatError, match=r"a.bin: the lasers of the points are unknown"):
        read_recording(tmp_path / "a.bin")
    (tmp_path / "a.bin").write_bytes(struct.pack("<4f", np.nan, 0, 0, 0))
    with pytest.raises(FormatError, match=r"a.bin: point 0 is \[nan"):
        read_recording(tmp_path / "a.bin")
    write_pcd(tmp_path / "a.pcd", ["x", "y"], [*points.T[:2]])
    with pytest.raises(FormatError, match=r"a.pcd: there is no field z"):
        read_recording(tmp_path / "a.pcd")
    for arrays, message in (
        ({"points": points}, "'xyz' is missing"),
        ({"xyz": np.array(["a"])}, "xyz is <U1"),
        ({"xyz": points, "ring": points}, "must be"),
    ):
        np.savez(tmp_path / "a.npz", **arrays)
        with pytest.raises(FormatError, match=f"a.npz: .*{message}"):
            read_recording(tmp_path / "a.npz")


def test_fields_and_coordinates_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="a value of each field for each"):
        returns(np.ones((9, 3)), {"label": np.array(1)})
    with pytest.raises(FormatError, match="4194305 points; scans of up to 4194304 are read"):
        returns(np.zeros((2**22 + 1, 3), np.float32), {})
    broken = np.frombuffer(np.full(9, 0x7FA00000, "<u4").tobytes(), np.float32).reshape(3, 3)  # nan that signals
    for far in (np.full((9, 3), 1e308), broken):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(FormatError, match="it has no return"):
                returns(far, {})
    path = tmp_path / "a.pcd"
    path.write_text("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 2 1 1\nPOINTS 1\nDATA ascii\n1 2 3 4\n")
    with pytest.raises(FormatError, match=r"a\.pcd: there is no field x of one value a point"):
        read_points(path)
