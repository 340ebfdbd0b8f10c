"""Headers that numpy's parser trusts, or fails on in ways of its own."""

import io
import struct
import tracemalloc

import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.scene.npy_header import read_npy_header


def header(text: str, version: int = 1) -> io.BytesIO:
    data = text.encode() + b"\n"
    return io.BytesIO(
        b"\x93NUMPY" + bytes([version, 0]) + struct.pack("<H" if version == 1 else "<I", len(data)) + data
    )


def of_shape(shape: str) -> str:
    return f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}}}"


@pytest.mark.parametrize("version", [(1, 0), (2, 0)])
def test_what_numpy_writes_is_read_to_where_the_values_begin(version: tuple[int, int]) -> None:
    array = np.asfortranarray(np.arange(12, dtype=">i2").reshape(3, 4))
    file = io.BytesIO(b"before")
    file.seek(0, io.SEEK_END)
    np.lib.format.write_array(file, array, version)
    file.seek(6)
    assert read_npy_header(file) == ((3, 4), True, array.dtype)
    assert file.read() == array.tobytes(order="F")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("(" * 9000, "not a whole .npy file"),
        ("{'descr': " + "[" * 3000 + "]" * 3000 + "}", "not a whole .npy file"),
        ("__import__('os').getcwd()", "not a whole .npy file"),
        (of_shape("(True,)"), "its shape is"),
        (of_shape("(-1,)"), "its shape is"),
        (of_shape("(1,) * 3"), "not a whole .npy file"),
        (of_shape(str((1,) * 100)), "its shape is"),
        (of_shape(str((0, 10**30))), "no array has so many values"),
        (of_shape(str((2**62, 2**62))), "no array has so many values"),
    ],
)
def test_a_header_that_numpy_would_not_write(text: str, said: str) -> None:
    with pytest.raises(FormatError, match=said) as caught:
        read_npy_header(header(text))
    assert len(str(caught.value)) < 200


def test_a_long_header_is_not_read() -> None:
    file = header(" " * 10_000_000, version=2)
    tracemalloc.start()
    with pytest.raises(FormatError, match=r"not a whole \.npy file"):
        read_npy_header(file)
    assert tracemalloc.get_traced_memory()[1] < 1_000_000
    tracemalloc.stop()
