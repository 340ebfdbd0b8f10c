import hypothesis.extra.numpy as arrays
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lidardraft.errors import FormatError
from lidardraft.formats.kitti import read_bin, write_bin

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
        (
            [[1, 2, 3, 0.5], [1, np.nan, 3, 0.5]],
            r"scan.bin: point 1 is \[1.0, nan, 3.0, 0.5\]; every value must be finite",
        ),
        ([[np.inf, 2, 3, 0.5]], r"scan.bin: point 0 is \[inf, 2.0, 3.0, 0.5\]; every value must be finite"),
        ([[1, 2, 3, 255]], r"scan.bin: point 0 has intensity 255.0; KITTI has 0 to 1"),
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


def test_a_truncated_file_is_named_with_its_bytes(tmp_path):
    path = tmp_path / "scan.bin"
    path.write_bytes(bytes(35))
    with pytest.raises(FormatError, match=r"scan.bin has 35 bytes; a KITTI scan has 16 a point, so it is truncated"):
        read_bin(path)


def test_an_empty_file_is_no_scan(tmp_path):
    write_bin(tmp_path / "scan.bin", np.zeros((0, 3)), np.zeros(0))
    with pytest.raises(FormatError, match=r"scan.bin is empty; a scan has at least one point"):
        read_bin(tmp_path / "scan.bin")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FormatError, match=r"none.bin: No such file or directory"):
        read_bin(tmp_path / "none.bin")


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
        (b'{"schema": "lidardraft.layout/1"}', "text"),
    ],
)
def test_files_of_points_of_another_kind_are_named(tmp_path, start, kind):
    path = tmp_path / "a.bin"
    path.write_bytes(start.ljust(32, b"\0"))
    with pytest.raises(FormatError, match=f"a.bin is {kind}; a KITTI scan is float32"):
        read_bin(path)
