"""Point cloud files of the Point Cloud Library: PCD 0.7, text, binary and compressed.

A header of lines names the fields; then come lines of numbers, records, or columns packed with LZF (Lehmann's
LibLZF, which PCL uses). `_` fields are padding.
"""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import read_bytes

_KEYS = ("FIELDS", "SIZE", "TYPE", "COUNT", "POINTS", "DATA")
_TYPES = {
    **{("F", size): f"<f{size}" for size in ("4", "8")},
    **{(kind, size): f"<{kind.lower()}{size}" for kind in "IU" for size in ("1", "2", "4", "8")},
}
_LONGEST_HEADER = 100_000  # bytes; a real one has a few hundred
_MOST_VALUES = 2**16  # of one point
_MOST_NUMBERS = 2_000_000  # of a file of text
_MOST_UNPACKED, _MOST_RUNS = 2**27, 2_000_000  # bytes that packed points may become, and pieces that they come in
_PADDING = "_"


@dataclass(frozen=True, slots=True, eq=False)
class PointFile:
    """Columns by name, each [N], or [N, count] where a field has several values; `width` and `height` of an organised
    cloud, 0 where the header does not say."""

    columns: dict[str, np.ndarray]
    width: int
    height: int


def read_pcd(path: str | os.PathLike[str]) -> PointFile:
    """What a file holds; raises `FormatError` where it is missing, truncated or has no PCD header."""
    name, data = os.fspath(path), read_bytes(path)
    header, body = _header(name, data)
    width, height = (
        int(words[0]) if len(words) == 1 and words[0].isdecimal() and len(words[0]) < 10 else 0
        for words in (header.get("WIDTH", []), header.get("HEIGHT", []))
    )
    return PointFile(_columns(name, header, body), width, height)


def pcd_columns(name: str, data: bytes) -> dict[str, np.ndarray]:
    """The columns in the bytes of a file; `name` is for the messages."""
    return _columns(name, *_header(name, data))


def _columns(name: str, header: dict[str, list[str]], body: bytes) -> dict[str, np.ndarray]:
    record, points, form = _record(name, header), _number(name, "POINTS", header["POINTS"]), " ".join(header["DATA"])
    if form == "ascii":
        columns = _ascii(name, body, record, points)
    elif form == "binary":
        columns = _binary(name, body, record, points)
    elif form == "binary_compressed":
        columns = _compressed(name, body, record, points)
    else:
        raise FormatError(f"{name}: DATA is {form!r}; it must be ascii, binary or binary_compressed")
    return {
        field: column[:, 0] if column.shape[1] == 1 else column
        for field, column in zip(header["FIELDS"], columns, strict=True)
        if field != _PADDING
    }


def _record(name: str, header: dict[str, list[str]]) -> np.dtype:
    """One point: each field under its number, for names may be the same (padding)."""
    fields, counts = header["FIELDS"], [_number(name, "COUNT", [count]) for count in header["COUNT"]]
    if not fields or not len(fields) == len(header["SIZE"]) == len(header["TYPE"]) == len(counts):
        raise FormatError(f"{name}: FIELDS, SIZE, TYPE and COUNT must have one value for each field")
    named = [field for field in fields if field != _PADDING]
    if len(set(named)) != len(named):
        raise FormatError(f"{name}: FIELDS names {next(field for field in named if named.count(field) > 1)!r} twice")
    if min(counts) < 1 or sum(counts) > _MOST_VALUES:
        raise FormatError(
            f"{name}: COUNT is {' '.join(header['COUNT'])}; each is 1 or more, all {_MOST_VALUES} at most"
        )
    types = list(zip(header["TYPE"], header["SIZE"], strict=True))
    for kind, size in types:
        if (kind, size) not in _TYPES:
            raise FormatError(f"{name}: TYPE {kind!r} of SIZE {size!r} is unknown; F has 4 or 8 bytes, I and U 1 to 8")
    return np.dtype([(str(k), _TYPES[types[k]], (count,)) for k, count in enumerate(counts)])


def _number(name: str, key: str, words: list[str]) -> int:
    if len(words) != 1 or not words[0].isdecimal() or len(words[0]) > 18:
        raise FormatError(f"{name}: {key} is {' '.join(words)!r}; it must be a whole number >= 0")
    return int(words[0])


def _header(name: str, data: bytes) -> tuple[dict[str, list[str]], bytes]:
    header: dict[str, list[str]] = {}
    start = 0
    while "DATA" not in header:
        end = data.find(b"\n", start, _LONGEST_HEADER)
        if end < 0:
            raise FormatError(f"{name}: no line DATA; this is no PCD file")
        words = data[start:end].decode("latin-1").split()
        if words and not words[0].startswith("#"):
            header[words[0]] = words[1:]
        start = end + 1
    header.setdefault("COUNT", ["1"] * len(header.get("FIELDS", [])))
    missing = [key for key in _KEYS if key not in header]
    if missing:
        raise FormatError(f"{name}: the header has no line {missing[0]}")
    return header, data[start:]


def _ascii(name: str, body: bytes, record: np.dtype, points: int) -> list[np.ndarray]:
    widths = [record[field].shape[0] for field in record.names or ()]
    if points * sum(widths) > _MOST_NUMBERS:
        raise FormatError(f"{name}: {points} points of {sum(widths)} numbers as text; up to {_MOST_NUMBERS} are read")
    words = body.split(None, points * sum(widths))
    if len(words) < points * sum(widths):
        raise FormatError(f"{name} has {len(words)} numbers; {points} points of {sum(widths)} need more")
    table = np.array(words[: points * sum(widths)], dtype=object).reshape(points, sum(widths))
    pieces = np.split(table, np.cumsum(widths)[:-1], axis=1)
    try:
        return [_parsed(piece, record[index].base) for index, piece in enumerate(pieces)]
    except ValueError as error:
        raise FormatError(f"{name}: {error}") from None


def _parsed(words: np.ndarray, dtype: np.dtype) -> np.ndarray:
    if dtype.kind == "f":
        with np.errstate(over="ignore"):  # what is too large for float32 is infinite there
            return np.array([float(word) for word in words.flat]).reshape(words.shape).astype(dtype)
    numbers, limits = [int(word) for word in words.flat], np.iinfo(dtype)
    if numbers and not limits.min <= min(numbers) <= max(numbers) <= limits.max:
        raise ValueError(f"a number of {min(numbers)} to {max(numbers)} does not fit into {dtype}")
    return np.array(numbers, dtype=dtype).reshape(words.shape)


def _binary(name: str, body: bytes, record: np.dtype, points: int) -> list[np.ndarray]:
    if len(body) < points * record.itemsize:
        raise FormatError(f"{name} has {len(body)} bytes of points; {points} need {points * record.itemsize}")
    table = np.frombuffer(body, dtype=record, count=points)
    return [table[field].copy() for field in record.names or ()]


def _compressed(name: str, body: bytes, record: np.dtype, points: int) -> list[np.ndarray]:
    if len(body) < 8:
        raise FormatError(f"{name} is truncated before its points")
    packed, full = struct.unpack("<II", body[:8])
    if len(body) - 8 < packed or full < points * record.itemsize:
        raise FormatError(f"{name} has {len(body) - 8} packed bytes of {packed}; it is truncated")
    flat = _unpacked(name, body[8 : 8 + packed], full)
    columns, start = [], 0
    for field in record.names or ():
        size = record[field].itemsize * points
        column = np.frombuffer(flat[start : start + size], record[field].base)
        columns.append(column.reshape(points, *record[field].shape).copy())
        start += size
    return columns


def _unpacked(name: str, packed: bytes, size: int) -> bytes:
    """LZF: a byte below 32 starts a run of literals; else its top three bits are a length, the rest a way back."""
    if size > _MOST_UNPACKED:
        raise FormatError(f"{name}: {size} bytes of packed points; up to {_MOST_UNPACKED} are read")
    out = bytearray()
    at, end, runs = 0, len(packed), 0
    try:
        while at < end and len(out) <= size:
            if (runs := runs + 1) > _MOST_RUNS:
                raise FormatError(f"{name}: points packed in more than {_MOST_RUNS} pieces")
            control = packed[at]
            at += 1
            if control < 32:
                out += packed[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += packed[at]
                at += 1
            back = ((control & 31) << 8) + packed[at] + 1
            at += 1
            length += 2
            start = len(out) - back
            if start < 0:
                raise IndexError
            if back >= length:
                out += out[start : start + length]
            else:  # the copy runs into what it writes
                out += (out[start:] * (length // back + 1))[:length]
    except IndexError:
        raise FormatError(f"{name}: the packed points are broken") from None
    if len(out) != size:
        raise FormatError(f"{name}: the packed points are {len(out)} bytes; the header says {size}")
    return bytes(out)
