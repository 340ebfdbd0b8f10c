"""Arrays in .npz files, read header first: what a file claims to hold is checked before memory is taken for it."""

from __future__ import annotations

import math
import os
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Any

import numpy as np

from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.files import named, regular_size
from lidardraft.scene.npy_header import read_npy_header

_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # what numpy writes; others take seconds to unpack
_LARGEST = 2**27  # bytes of an array, ten times those of the largest scan; a small file may claim any number
_LONGEST_TEXT = 2**24  # bytes; the JSON of a sensor of 128 beams has 60,000 in numpy's four a character
# What zipfile and numpy raise on a file that is truncated, corrupt, encrypted or of another kind.
_BROKEN = (OSError, EOFError, LookupError, TypeError, ValueError, RuntimeError, zipfile.BadZipFile, zlib.error)


@contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[zipfile.ZipFile]:
    """The archive of an .npz file; errors of the block name the file, and are `FormatError` where it is broken."""
    regular_size(path)
    with named(path):
        try:
            with zipfile.ZipFile(path) as archive:
                yield archive
        except LidarDraftError:
            raise
        except _BROKEN as error:
            said = error.strerror if isinstance(error, OSError) else None
            raise FormatError(said or f"not a whole .npz file: {error}") from None


def holds(archive: zipfile.ZipFile, name: str) -> bool:
    """Whether there is an array of that name."""
    return f"{name}.npy" in archive.namelist()


def read_array(archive: zipfile.ZipFile, name: str, dtype: np.dtype[Any], shape: tuple[int, ...]) -> np.ndarray:
    """The array of that name; raises `FormatError` where it is missing, truncated, or of another type or shape."""
    if (size := math.prod(shape) * dtype.itemsize) > _LARGEST:
        raise FormatError(f"{name} has {size} bytes; arrays of up to {_LARGEST} are read")
    with _array_file(archive, name) as file:
        found_shape, fortran, found = _header(name, file)
        if found != dtype or found_shape != shape:
            raise FormatError(f"{name} is {found} {found_shape}; it must be {dtype} {shape}")
        data = file.read(math.prod(shape) * dtype.itemsize)
    if len(data) != math.prod(shape) * dtype.itemsize:
        raise FormatError(f"{name} is truncated: it has {len(data)} of {math.prod(shape) * dtype.itemsize} bytes")
    return np.frombuffer(data, dtype).reshape(shape, order="F" if fortran else "C").copy()


def read_numbers(archive: zipfile.ZipFile, name: str, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """The array of that name, of any type of numbers, and of any shape if none is given; raises `FormatError` as
    `read_array` does."""
    with _array_file(archive, name) as file:
        found, _, dtype = _header(name, file)
    if dtype.kind not in "fiub":
        raise FormatError(f"{name} is {dtype}; it must hold numbers")
    if math.prod(found) * dtype.itemsize > archive.getinfo(f"{name}.npy").file_size:
        raise FormatError(f"{name} is truncated: its header says {found}")
    shape = found if shape is None else shape
    return read_array(archive, name, dtype, shape)


def read_text(archive: zipfile.ZipFile, name: str) -> str:
    """The text of that name, stored as an array of one string; raises `FormatError` as `read_array` does."""
    with _array_file(archive, name) as file:
        shape, _, dtype = _header(name, file)
    if not dtype.str.startswith("<U") or shape != () or dtype.itemsize > _LONGEST_TEXT:
        raise FormatError(f"{name} is {dtype} {shape}; it must be one text of up to {_LONGEST_TEXT} bytes")
    return read_array(archive, name, dtype, ()).tobytes().decode("utf-32-le").rstrip("\0")


@contextmanager
def _array_file(archive: zipfile.ZipFile, name: str) -> Iterator[IO[bytes]]:
    if not holds(archive, name):
        raise FormatError(f"{name!r} is missing")
    if archive.getinfo(f"{name}.npy").compress_type not in _COMPRESSIONS:
        raise FormatError(f"{name} is packed in a way that numpy does not use")
    with archive.open(f"{name}.npy") as file:
        yield file


def _header(name: str, file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    with named(name):
        return read_npy_header(file)
