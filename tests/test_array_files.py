"""Arrays of .npz files: what a header claims is checked before memory is taken for it."""

import io
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

from lidardraft import array_files
from lidardraft.errors import FormatError, SensorError
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor

SENSOR = Sensor(name="few", elevations=(0.1, -0.1), columns=8)
DEPTH = np.arange(16, dtype=np.float32).reshape(2, 8)


def archive(path: Path, **members: bytes) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            file.writestr(f"{name}.npy", data)
    return path


def npy(array: np.ndarray, version: tuple[int, int] | None = None) -> bytes:
    data = io.BytesIO()
    np.lib.format.write_array(data, array, version)
    return data.getvalue()


def claims(shape: tuple[int, ...], dtype: str, data: bytes = b"") -> bytes:
    """A header for what is not there."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"shape": shape, "fortran_order": False, "descr": dtype})
    return file.getvalue() + data


@pytest.mark.parametrize("array", [DEPTH, np.asfortranarray(DEPTH), DEPTH[:, ::-1]], ids=["C", "Fortran", "strided"])
@pytest.mark.parametrize("version", [None, (2, 0)])
def test_an_array_comes_back(tmp_path: Path, array: np.ndarray, version: tuple[int, int] | None) -> None:
    with array_files.opened(archive(tmp_path / "a.npz", depth=npy(array, version))) as file:
        read = array_files.read_array(file, "depth", np.dtype(np.float32), (2, 8))
    np.testing.assert_array_equal(read, array)
    read[:] = 0.0  # it is the caller's


@pytest.mark.parametrize(
    ("member", "message"),
    [
        (claims((10**6, 10**6), "<f4"), r"depth: not a whole .npy file: "),
        (claims((2, 8), "<f8", bytes(128)), r"depth is float64 \(2, 8\); it must be float32 \(2, 8\)"),
        (claims((2, 8), "|O"), r"depth: not a whole .npy file: Object arrays cannot be loaded"),
        (claims((2, 8), "<f4", bytes(63)), r"depth: not a whole .npy file: EOF"),
        (b"", r"depth: not a whole .npy file"),
        (b"\x93NUMPY\x01\x00\xff\xff{", r"depth: not a whole .npy file"),
        (b"\x93NUMPY\x02\x00\xff\xff\xff\xff{", r"depth: not a whole .npy file"),
    ],
    ids=["huge", "type", "objects", "truncated", "empty", "header", "long header"],
)
def test_an_array_that_is_another_is_refused(tmp_path: Path, member: bytes, message: str) -> None:
    path = archive(tmp_path / "a.npz", depth=member)
    with pytest.raises(FormatError, match=r"a.npz: " + message), array_files.opened(path) as file:
        array_files.read_array(file, "depth", np.dtype(np.float32), (2, 8))


@pytest.mark.parametrize(
    ("member", "message"),
    [
        (npy(np.zeros(3)), r"sensor is float64 \(3,\); it must be one text"),
        (claims((), "<U100000000"), r"sensor: not a whole .npy file: "),
        (claims((10**12,), "<U1"), r"sensor: not a whole .npy file: "),
    ],
    ids=["numbers", "long", "many"],
)
def test_a_text_that_is_none_is_refused(tmp_path: Path, member: bytes, message: str) -> None:
    path = archive(tmp_path / "a.npz", sensor=member)
    with pytest.raises(FormatError, match=r"a.npz: " + message), array_files.opened(path) as file:
        array_files.read_text(file, "sensor")


def test_a_range_image_that_claims_too_much_takes_no_memory(tmp_path: Path) -> None:
    sensor = npy(np.array(SENSOR.to_json()))
    zeros = claims((4 * 10**7,), "<f4", bytes(16 * 10**7))  # small once it is compressed
    path = archive(tmp_path / "a.npz", sensor=sensor, depth=zeros, label=b"", instance=b"")
    del zeros
    tracemalloc.start()
    with pytest.raises(FormatError, match=r"a.npz: depth has 160000128 bytes; arrays of up to 134217728 are read"):
        RangeImage.load(path)
    assert tracemalloc.get_traced_memory()[1] < 10**7
    tracemalloc.stop()


def test_a_range_image_of_wrong_values_is_named(tmp_path: Path) -> None:
    image = RangeImage.empty(SENSOR)
    image.label[0, 0] = 200
    image.save(tmp_path / "a.npz")
    with pytest.raises(SensorError, match=r"a.npz: label holds 200; class ids are 0 to 20"):
        RangeImage.load(tmp_path / "a.npz")


def test_what_numpy_does_not_pack_is_not_unpacked(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("depth.npy", npy(DEPTH))
    with pytest.raises(FormatError, match="packed in a way"), array_files.opened(tmp_path / "a.npz") as file:
        array_files.read_numbers(file, "depth")
