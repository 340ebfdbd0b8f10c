"""One array of numbers in an .npy file, whose header is checked before memory is taken for it."""

from __future__ import annotations

import io
import math
import os

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_bytes, regular_size
from lidardraft.scene.npy_header import read_npy_header

_MAX_BYTES = 2**29


def read_npy(path: str | os.PathLike[str]) -> np.ndarray:
    """The array of a file; raises `FormatError` where it is broken, or holds what are no numbers."""
    with named(path):
        if (size := regular_size(path)) > _MAX_BYTES:
            raise FormatError(f"it has {size} bytes; arrays of up to {_MAX_BYTES} are read")
        data = read_bytes(path)
        file = io.BytesIO(data)
        shape, fortran, dtype = read_npy_header(file)
        if dtype.kind not in "fiub":
            raise FormatError(f"it holds {dtype} {shape}; it must hold numbers")
        need = math.prod(shape) * dtype.itemsize
        if len(data) - file.tell() != need:
            raise FormatError(f"it is truncated: {len(data) - file.tell()} bytes follow, {need} are needed for {shape}")
        return np.frombuffer(data, dtype, offset=file.tell()).reshape(shape, order="F" if fortran else "C").copy()
