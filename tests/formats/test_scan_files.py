"""Scans and labels of KITTI, SemanticKITTI and nuScenes."""

import os
from pathlib import Path

import hypothesis.extra.numpy as arrays
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from lidardraft.errors import FormatError
from lidardraft.formats.kitti import looks_like_text, read_bin, write_bin
from lidardraft.formats.nuscenes import read_pcd_bin
from lidardraft.formats.semantickitti import CLASS_FROM_RAW, RAW_FROM_CLASS, read_label, write_label
from lidardraft.semantics import BY_NAME, CLASSES, NUM_CLASSES

coordinates = st.floats(-1e4, 1e4, width=32)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    scan=st.integers(1, 20).flatmap(
        lambda n: st.tuples(
            arrays.arrays(np.float32, (n, 3), elements=coordinates),
            arrays.arrays(np.float32, (n,), elements=st.floats(0, 1, width=32)),
        )
    )
)
def test_reading_gives_what_was_written(tmp_path, scan):
    write_bin(tmp_path / "scan.bin", *scan)
    assume(not looks_like_text((tmp_path / "scan.bin").read_bytes()))
    points, intensity = read_bin(tmp_path / "scan.bin")
    np.testing.assert_array_equal(points, scan[0])
    np.testing.assert_array_equal(intensity, scan[1])
    assert points.dtype == intensity.dtype == np.float32


def test_the_bytes_are_kittis(tmp_path):
    write_bin(tmp_path / "scan.bin", np.array([[1.0, 2.0, 3.0]]), np.array([0.5]))
    assert (tmp_path / "scan.bin").read_bytes() == np.array([1, 2, 3, 0.5], dtype="<f4").tobytes()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([[1, 2, 3, 0.5], [1, np.nan, 3, 0.5]], r"scan.bin: point 1 is \[1.0, nan, 3.0, 0.5\]; every value must be"),
        ([[np.inf, 2, 3, 0.5]], r"scan.bin: point 0 is \[inf, 2.0, 3.0, 0.5\]; every value must be finite"),
        ([[1, 2, 3, -0.5]], r"scan.bin: point 0 has intensity -0.5; KITTI has 0 to 1"),
    ],
)
def test_bad_values_are_neither_read_nor_written(tmp_path, values, message):
    scan = np.array(values, dtype="<f4")
    path = tmp_path / "scan.bin"
    with pytest.raises(FormatError, match=message):
        write_bin(path, scan[:, :3], scan[:, 3])
    assert not list(tmp_path.iterdir())
    path.write_bytes(scan.tobytes())
    with pytest.raises(FormatError, match=message):
        read_bin(path)


def test_intensities_over_1_are_neither_read_nor_written(tmp_path):
    scan = np.array([[1, 2, 3, 255]], dtype="<f4")
    with pytest.raises(FormatError, match=r"scan.bin: point 0 has intensity 255.0; KITTI has 0 to 1"):
        write_bin(tmp_path / "scan.bin", scan[:, :3], scan[:, 3])
    scan.tofile(tmp_path / "scan.bin")
    with pytest.raises(FormatError, match=r"scan.bin: intensities have a median of 255 and a maximum of 255, over 1"):
        read_bin(tmp_path / "scan.bin")
    assert read_bin(tmp_path / "scan.bin", 255)[1].tolist() == [1.0]


def test_a_truncated_file_is_named_with_its_bytes(tmp_path):
    path = tmp_path / "scan.bin"
    path.write_bytes(bytes(35))
    with pytest.raises(FormatError, match=r"scan.bin has 35 bytes; a KITTI scan has 16 a point, so it is truncated"):
        read_bin(path)


def test_an_empty_file_is_no_scan(tmp_path):
    write_bin(tmp_path / "scan.bin", np.zeros((0, 3)), np.zeros(0))
    with pytest.raises(FormatError, match=r"scan.bin is empty: a scan without returns"):
        read_bin(tmp_path / "scan.bin")


def test_arrays_of_other_lengths_are_not_written(tmp_path):
    with pytest.raises(FormatError, match=r"points \(2, 3\) and intensity \(1,\) must be \[N, 3\] and \[N\]"):
        write_bin(tmp_path / "scan.bin", np.zeros((2, 3)), np.zeros(1))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("start", "kind"),
    [
        (b"ply\nformat ascii 1.0\n", "PLY"),
        (b"LASF" + bytes(28), "LAS"),
        (b"# .PCD v0.7\n", "PCD"),
        (b"\x93NUMPY", "NumPy"),
        (b"PK\x03\x04", "a zip"),
        (b"\x89PNG\r\n\x1a\n", "PNG"),
        (b"\xff\xd8\xff\xe0\0\x10JFIF", "JPEG"),
        (b"glTF\2", "binary glTF"),
        (b"12.5 3.25 -1.75 0.5\n1.0 2.0 3.0 0.25\n", "text"),
        (b'{"schema": "lidardraft.layout/2"}', "text"),
    ],
)
def test_files_of_points_of_another_kind_are_named(tmp_path, start, kind):
    path = tmp_path / "a.bin"
    path.write_bytes(start.ljust(32, b"\0"))
    with pytest.raises(FormatError, match=f"a.bin is {kind}; a KITTI scan is float32"):
        read_bin(path)


# All ids of semantic-kitti.yaml.
RAW_IDS = [0, 1, 10, 11, 13, 15, 16, 18, 20, 30, 31, 32, 40, 44, 48, 49, 50, 51, 52, 60, 70, 71, 72, 80, 81, 99]
RAW_IDS += range(252, 260)


def test_every_raw_id_has_a_class_and_every_class_a_raw_id():
    assert sorted(CLASS_FROM_RAW) == RAW_IDS
    assert set(CLASS_FROM_RAW.values()) <= set(BY_NAME)
    assert set(RAW_FROM_CLASS) == set(BY_NAME)
    assert set(RAW_FROM_CLASS.values()) <= set(RAW_IDS)


@pytest.mark.parametrize(
    ("raw", "name"),
    [
        (1, "none"),
        (44, "road"),
        (60, "road"),
        (49, "terrain"),
        (252, "car"),
        (254, "person"),
        (257, "bus"),
        (259, "truck"),
    ],
)
def test_lossy_ids(tmp_path, raw, name):
    (tmp_path / "a.label").write_bytes(np.array([raw | 7 << 16], dtype="<u4").tobytes())
    label, instance = read_label(tmp_path / "a.label", 1)
    assert (CLASSES[label[0]].name, instance[0]) == (name, 7)


def test_round_trip_of_all_classes_but_the_two_that_are_lost(tmp_path):
    label = np.arange(NUM_CLASSES, dtype=np.uint8)
    instance = np.linspace(0, 65535, NUM_CLASSES).astype(np.uint32)
    write_label(tmp_path / "a.label", label, instance)
    read, numbers = read_label(tmp_path / "a.label", NUM_CLASSES)
    lost = {"wall": "fence", "traffic-light": "other"}
    assert [CLASSES[i].name for i in read] == [lost.get(row.name, row.name) for row in CLASSES]
    np.testing.assert_array_equal(numbers, instance)


def test_a_file_of_another_length(tmp_path):
    write_label(tmp_path / "a.label", np.zeros(3, dtype=np.uint8), np.zeros(3, dtype=np.uint32))
    with pytest.raises(FormatError, match=r"a.label has 12 bytes, 3 labels; the scan has 4 points"):
        read_label(tmp_path / "a.label", 4)


def test_an_unknown_class_is_named(tmp_path):
    (tmp_path / "a.label").write_bytes(np.array([40, 77 | 1 << 16], dtype="<u4").tobytes())
    with pytest.raises(FormatError, match=r"a.label: point 1 has class 77, which SemanticKITTI does not have"):
        read_label(tmp_path / "a.label", 2)


@pytest.mark.parametrize(
    ("label", "instance", "message"),
    [
        ([1, NUM_CLASSES], [0, 0], rf"point 1 has class {NUM_CLASSES}; it must be 0 to {NUM_CLASSES - 1}"),
        ([1, 1], [0, 65536], r"point 1 has instance 65536; it must be 0 to 65535"),
        ([1, 1], [0], r"label \(2,\) and instance \(1,\) must both be \[N\]"),
    ],
)
def test_what_a_label_cannot_hold_is_not_written(tmp_path, label, instance, message):
    with pytest.raises(FormatError, match=message):
        write_label(tmp_path / "a.label", np.array(label, dtype=np.uint8), np.array(instance, dtype=np.uint32))
    assert not list(tmp_path.iterdir())


DATA = os.environ.get("LIDARDRAFT_DATA", "")
SWEEPS = sorted(Path(DATA, "nuscenes").rglob("*LIDAR_TOP*.pcd.bin")) if DATA else []


def write_sweep(path: Path, sweep: list[list[float]]) -> Path:
    np.array(sweep, "<f4").tofile(path)
    return path


def test_axes_intensities_and_rings(tmp_path: Path) -> None:
    """What is to the right in nuScenes has a negative y in our frame, and what is ahead a positive x."""
    path = write_sweep(tmp_path / "a.pcd.bin", [[2, 10, -1.5, 255, 0], [-3, 0, 0, 51, 31]])
    points, intensity, ring = read_pcd_bin(path)
    np.testing.assert_array_equal(points, [[10, -2, -1.5], [0, 3, 0]])
    np.testing.assert_allclose(intensity, [1, 0.2])
    np.testing.assert_array_equal(ring, [0, 31])
    assert (points.dtype, intensity.dtype, ring.dtype) == (np.float32, np.float32, np.int64)


@pytest.mark.parametrize(
    ("sweep", "said"),
    [
        ([[np.nan, 0, 0, 0, 0]], r"point 0 is \[nan, .*every value must be finite"),
        ([[1, 0, 0, 0, 0], [1, 0, 0, 256, 0]], r"point 1 is .*intensity, must be 0 to 255"),
        ([[1, 0, 0, 0, 0.5]], "the ring, must be a whole number from 0 to 511"),
        ([[1, 0, 0, 0, -1]], "the ring, must be a whole number from 0 to 511"),
        ([[1, 0, 0, 0]], "a.pcd.bin has 16 bytes; a nuScenes sweep has 20 a point"),
        ([[]], "a.pcd.bin is empty: a scan without returns"),
    ],
)
def test_what_is_no_sweep(tmp_path: Path, sweep: list[list[float]], said: str) -> None:
    with pytest.raises(FormatError, match=said):
        read_pcd_bin(write_sweep(tmp_path / "a.pcd.bin", sweep))


@pytest.mark.skipif(not SWEEPS, reason="LIDARDRAFT_DATA has no sweep of nuScenes")
def test_a_recorded_sweep_has_the_beams_of_an_hdl32e_and_a_car_that_is_long_ahead() -> None:
    from lidardraft import Sensor

    points, _, ring = read_pcd_bin(SWEEPS[0])
    distance = np.hypot(points[:, 0], points[:, 1])
    elevation = np.arctan2(points[:, 2], distance)
    found = [np.median(elevation[(ring == k) & (distance > 2)]) for k in range(31, -1, -1)]
    np.testing.assert_allclose(found, Sensor.preset("hdl32e").elevations, atol=np.deg2rad(0.4))
    roof = points[(distance > 0.5) & (distance < 3) & (points[:, 2] > -1)]
    assert np.ptp(roof[:, 0]) > np.ptp(roof[:, 1])
