import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.formats.npy import read_npy


@pytest.mark.parametrize(
    "array", [np.arange(6.0).reshape(2, 3), np.asfortranarray(np.arange(6).reshape(2, 3)), np.ones(0)]
)
def test_arrays_are_read_as_they_were_saved(tmp_path, array):
    np.save(tmp_path / "a.npy", array)
    found = read_npy(tmp_path / "a.npy")
    np.testing.assert_array_equal(found, array)
    assert found.dtype == array.dtype


def test_a_header_that_claims_more_than_there_is_takes_no_memory(tmp_path):
    with open(tmp_path / "a.npy", "wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (4_000_000_000,)})
        file.write(bytes(16))
    with pytest.raises(FormatError, match=r"a.npy: it is truncated: 16 bytes follow, 16000000000 are needed"):
        read_npy(tmp_path / "a.npy")


@pytest.mark.parametrize("array", [np.array([None]), np.array(["a"]), np.zeros(2, dtype=[("x", "f4")])])
def test_what_are_no_numbers_is_refused(tmp_path, array):
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    with pytest.raises(FormatError, match=r"a.npy: it holds .*; it must hold numbers"):
        read_npy(tmp_path / "a.npy")


def test_a_truncated_file_is_named(tmp_path):
    np.save(tmp_path / "a.npy", np.ones((9, 9)))
    whole = (tmp_path / "a.npy").read_bytes()
    for length in (0, 5, 60, 200):
        (tmp_path / "b.npy").write_bytes(whole[:length])
        with pytest.raises(FormatError, match=r"b.npy: (not a whole .npy file|it is truncated)"):
            read_npy(tmp_path / "b.npy")
