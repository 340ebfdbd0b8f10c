"""The header of numpy's .npy format, from files of others: checked before memory is taken for what it claims."""

from __future__ import annotations

import io
import math
from typing import IO, Any

import numpy as np

from lidardraft.errors import FormatError

_READERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
_LONGEST = 20_000  # bytes; numpy refuses more than 10,000 of its own accord, but only once they are read
_MOST_AXES, _MOST_BYTES = 32, 2**62  # of an array: numpy's least limit, and what its indices reach


def read_npy_header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """The shape, whether it is in Fortran's order, and the type of the array that begins in a file; leaves the file
    where its values begin. Raises `FormatError` where numpy would not write such a header."""
    start, head = file.tell(), io.BytesIO(file.read(_LONGEST))
    try:
        version = np.lib.format.read_magic(head)
        if version not in _READERS:
            raise FormatError(f"it is in version {version[0]}.{version[1]} of numpy's format; 1.0 and 2.0 are read")
        shape, fortran, dtype = _READERS[version](head)
    except FormatError:
        raise
    except Exception:  # numpy's parser raises whatever it meets
        raise FormatError("not a whole .npy file") from None
    if len(shape) > _MOST_AXES or any(type(extent) is not int or extent < 0 for extent in shape):
        raise FormatError(f"its shape is {shape!s:.80}; it must have up to {_MOST_AXES} whole numbers of 0 or more")
    if math.prod(extent or 1 for extent in shape) * max(dtype.itemsize, 1) > _MOST_BYTES:
        raise FormatError(f"its shape is {shape!s:.80}; no array has so many values")
    file.seek(start + head.tell())
    return shape, fortran, dtype
