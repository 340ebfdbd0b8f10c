"""Arrays in foreign .npz and .npy files; arrays larger than any scan are refused."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import expecting, named, read_bytes, regular_size

_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # those of numpy; others take seconds to unpack
_LARGEST = 2**27  # bytes of an array, ten times those of the largest scan; a small file may unpack to any size


@contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[zipfile.ZipFile]:
    """The archive of an .npz file; errors of the block name the file, and are `FormatError` if it is broken."""
    regular_size(path)
    with named(path), expecting("a whole .npz file"), zipfile.ZipFile(path) as archive:
        yield archive


def names_in(path: str | os.PathLike[str]) -> list[str]:
    """The names of the arrays in an .npz file; raises `FormatError` if it is broken."""
    with opened(path) as archive:
        return [name.removesuffix(".npy") for name in archive.namelist()]


def holds(archive: zipfile.ZipFile, name: str) -> bool:
    """Whether there is an array of that name."""
    return f"{name}.npy" in archive.namelist()


def read_array(archive: zipfile.ZipFile, name: str, dtype: np.dtype[Any], shape: tuple[int, ...]) -> np.ndarray:
    """The array of that name; raises `FormatError` if it is missing, truncated, or of another type or shape."""
    array = _array(archive, name)
    if array.dtype != dtype or array.shape != shape:
        raise FormatError(f"{name} is {array.dtype} {array.shape}; it must be {dtype} {shape}")
    return array


def read_numbers(archive: zipfile.ZipFile, name: str, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """The array of that name, of any numeric type, and of any shape if `shape` is None; raises `FormatError` as
    `read_array` does."""
    array = _array(archive, name)
    if array.dtype.kind not in "fiub":
        raise FormatError(f"{name} is {array.dtype}; it must hold numbers")
    if shape not in (None, array.shape):
        raise FormatError(f"{name} has shape {array.shape}; it must be {shape}")
    return array


def read_text(archive: zipfile.ZipFile, name: str) -> str:
    """The text of that name, stored as an array of one string; raises `FormatError` as `read_array` does."""
    array = _array(archive, name)
    if array.dtype.kind != "U" or array.shape != ():
        raise FormatError(f"{name} is {array.dtype} {array.shape}; it must be one text")
    return str(array)


def read_npy(path: str | os.PathLike[str]) -> np.ndarray:
    """The array of numbers or records in an .npy file; raises `FormatError` if it is broken or holds anything else."""
    data = read_bytes(path)
    with named(path):
        return parse_npy(data)


def parse_npy(data: bytes) -> np.ndarray:
    """As `read_npy`, from the bytes of a file."""
    array = _parsed(io.BytesIO(data))
    if array.dtype.kind not in "fiubV":
        raise FormatError(f"it holds {array.dtype} {array.shape}; it must hold numbers")
    return array


def _array(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    if not holds(archive, name):
        raise FormatError(f"{name!r} is missing")
    member = archive.getinfo(f"{name}.npy")
    if member.compress_type not in _COMPRESSIONS:
        raise FormatError(f"{name} is packed in a way that numpy does not use")
    if member.file_size > _LARGEST:
        raise FormatError(f"{name} has {member.file_size} bytes; arrays of up to {_LARGEST} are read")
    with archive.open(member) as file, named(name):
        return _parsed(file)


def _parsed(file: IO[bytes]) -> np.ndarray:
    with expecting("a whole .npy file"):
        array: np.ndarray = np.lib.format.read_array(file, allow_pickle=False)
    return array
