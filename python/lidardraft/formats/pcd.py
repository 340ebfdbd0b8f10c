"""Point cloud files of the Point Cloud Library: PCD 0.7, text, binary and compressed.

A header of lines names the fields; then come lines of numbers, records, or columns packed with LZF (Lehmann's LibLZF,
which PCL uses). Fields `_` are padding.
"""

from __future__ import annotations

import io
import os
import re
import struct
import warnings
from dataclasses import dataclass
from functools import partial

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import MAX_WHOLE, expecting, named, read_bytes, written_whole
from lidardraft.formats.frame import write_each
from lidardraft.formats.kitti import numbers_of

_KEYS = ("FIELDS", "SIZE", "TYPE", "COUNT", "POINTS", "DATA")
_TYPES = {
    **{("F", size): f"<f{size}" for size in ("4", "8")},
    **{(kind, size): f"<{kind.lower()}{size}" for kind in "IU" for size in ("1", "2", "4", "8")},
}
_LONGEST_HEADER = 100_000  # bytes; a real one has a few hundred
_MOST_VALUES = 2**16  # of one point
_LONGEST_TEXT = 2**24  # bytes, half a million points of CARLA; to read them takes a second
_MOST_RUNS = 2_000_000  # pieces of packed points
_PADDING = "_"
_UNIT = 0.01  # the largest deviation from 1 of the length of a quaternion with few digits


@dataclass(frozen=True, slots=True, eq=False)
class PointFile:
    """Columns by name, each [N], or [N, count] for a field with several values; `width` and `height` of an organised
    cloud, 0 if the header lacks them. `viewpoint` [7] is the sensor's pose in the frame of the points, x y z [m] and a
    quaternion w x y z; None if it is the origin."""

    columns: dict[str, np.ndarray]
    width: int
    height: int
    viewpoint: np.ndarray | None = None


def read_pcd(path: str | os.PathLike[str]) -> PointFile:
    """The content of a file; raises `FormatError` if it is missing, truncated or has no PCD header."""
    data = read_bytes(path)
    with named(path):
        return parse_pcd(data)


def parse_pcd(data: bytes) -> PointFile:
    """As `read_pcd`, from the bytes of a file."""
    header, body = _header(data)
    record, points, form = _record(header), _number("POINTS", header["POINTS"]), " ".join(header["DATA"])
    if form == "ascii":
        columns = _columns(text_records(body, record, points))
    elif form == "binary":
        columns = _columns(binary_records(body, record, points))
    elif form == "binary_compressed":
        columns = _compressed(body, record, points)
    else:
        raise FormatError(f"DATA is {form!r}; it must be ascii, binary or binary_compressed")
    named_columns = {
        field: column[:, 0] if column.shape[1] == 1 else column
        for field, column in zip(header["FIELDS"], columns, strict=True)
        if field != _PADDING and column.shape[1]
    }
    width, height = (_whole(header.get(key, [])) or 0 for key in ("WIDTH", "HEIGHT"))
    return PointFile(named_columns, width, height, _viewpoint(header.get("VIEWPOINT", [])))


def write_pcd(path: str | os.PathLike[str], records: np.ndarray) -> None:
    """Write records [N] of float and unsigned fields as a binary file."""
    names = records.dtype.names or ()
    types = [records.dtype[name] for name in names]
    header = {
        "VERSION": ["0.7"],
        "FIELDS": names,
        "SIZE": [str(kind.itemsize) for kind in types],
        "TYPE": [kind.kind.upper() for kind in types],
        "COUNT": ["1"] * len(names),
        "WIDTH": [str(len(records))],
        "HEIGHT": ["1"],
        "VIEWPOINT": ["0 0 0 1 0 0 0"],
        "POINTS": [str(len(records))],
        "DATA": ["binary"],
    }
    text = "".join(f"{key} {' '.join(values)}\n" for key, values in header.items())
    with written_whole(path) as temporary:
        temporary.write_bytes(text.encode() + records.tobytes())


write_pcd_folder = partial(write_each, ".pcd", write_pcd)


def text_records(text: bytes, record: np.dtype, count: int) -> np.ndarray:
    """The first `count` lines of numbers in a text as records [count]; raises `FormatError`."""
    if len(text) > _LONGEST_TEXT:
        raise FormatError(f"{len(text)} bytes of points as text; up to {_LONGEST_TEXT} are read")
    with warnings.catch_warnings(), expecting("a table of numbers"):
        warnings.simplefilter("ignore")  # numpy's, on a text without numbers
        lines = io.BytesIO(re.sub(rb"\.0+(?!\S)", b"", text))  # whole numbers may be written as 6.0
        table: np.ndarray = np.loadtxt(lines, record, comments=None, max_rows=count, ndmin=1, encoding="latin-1")
    if len(table) < count:
        raise FormatError(f"{count} points are announced, but {len(table)} lines of numbers are there")
    return table


def binary_records(body: bytes, record: np.dtype, count: int) -> np.ndarray:
    """The records [count] at the start of some bytes; raises `FormatError`."""
    if len(body) < count * record.itemsize:
        raise FormatError(f"{len(body)} bytes of points; {count} need {count * record.itemsize}")
    return np.frombuffer(body, dtype=record, count=count)


def _record(header: dict[str, list[str]]) -> np.dtype:
    """The type of one point: fields are named by number, as their names may repeat (padding)."""
    fields, counts = header["FIELDS"], [_number("COUNT", [count]) for count in header["COUNT"]]
    if not fields or not len(fields) == len(header["SIZE"]) == len(header["TYPE"]) == len(counts):
        raise FormatError("FIELDS, SIZE, TYPE and COUNT must have one value for each field")
    named_fields = [field for field in fields if field != _PADDING]
    if twice := [field for field in named_fields if named_fields.count(field) > 1]:
        raise FormatError(f"FIELDS names {twice[0]!r} twice")
    if not 0 < sum(counts) <= _MOST_VALUES:  # PCL writes fields of count 0, without bytes
        raise FormatError(f"COUNT is {' '.join(header['COUNT'])}; all are 1 to {_MOST_VALUES}")
    types = list(zip(header["TYPE"], header["SIZE"], strict=True))
    for kind, size in types:
        if (kind, size) not in _TYPES:
            raise FormatError(f"TYPE {kind!r} of SIZE {size!r} is unknown; F has 4 or 8 bytes, I and U 1 to 8")
    return np.dtype([(str(k), _TYPES[types[k]], (count,)) for k, count in enumerate(counts)])


def _viewpoint(words: list[str]) -> np.ndarray | None:
    """The pose of the sensor, None if it is the origin; zeros in place of a quaternion, as some writers leave, mean no
    rotation."""
    with named("VIEWPOINT"):
        pose = np.array(numbers_of(words or ["0"] * 7, 7))
        length = np.linalg.norm(pose[3:])
        if length and abs(length - 1) > _UNIT:
            raise FormatError(f"{' '.join(words)} has a quaternion of length {length:g}; it must be 1")
    pose[3:] = pose[3:] / length if length else (1, 0, 0, 0)
    return pose if pose[[0, 1, 2, 4, 5, 6]].any() else None


def _number(key: str, words: list[str]) -> int:
    if (number := _whole(words)) is None:
        raise FormatError(f"{key} is {' '.join(words)!r}; it must be a whole number >= 0")
    return number


def _whole(words: list[str]) -> int | None:
    return int(words[0]) if len(words) == 1 and words[0].isdecimal() and len(words[0]) < 19 else None


def _header(data: bytes) -> tuple[dict[str, list[str]], bytes]:
    header: dict[str, list[str]] = {}
    start = 0
    while "DATA" not in header:
        end = data.find(b"\n", start, _LONGEST_HEADER)
        if end < 0:
            raise FormatError("no line DATA; this is not a PCD file")
        words = data[start:end].decode("latin-1").split()
        if words and not words[0].startswith("#"):
            header[words[0]] = words[1:]
        start = end + 1
    header.setdefault("COUNT", ["1"] * len(header.get("FIELDS", [])))
    if missing := [key for key in _KEYS if key not in header]:
        raise FormatError(f"the header has no line {missing[0]}")
    return header, data[start:]


def _columns(table: np.ndarray) -> list[np.ndarray]:
    return [table[field].copy() for field in table.dtype.names or ()]


def _compressed(body: bytes, record: np.dtype, points: int) -> list[np.ndarray]:
    if len(body) < 8:
        raise FormatError("the file is truncated before its points")
    packed, full = struct.unpack("<II", body[:8])
    if len(body) - 8 < packed or full < points * record.itemsize:
        raise FormatError(f"{len(body) - 8} packed bytes of {packed}; the file is truncated")
    flat = _unpacked(body[8 : 8 + packed], full)
    columns, start = [], 0
    for field in record.names or ():
        size = record[field].itemsize * points
        column = np.frombuffer(flat[start : start + size], record[field].base)
        columns.append(column.reshape(points, *record[field].shape).copy())
        start += size
    return columns


def _unpacked(packed: bytes, size: int) -> bytes:
    """LZF: a byte below 32 starts a run of literals; else its top three bits are a length, the rest a way back."""
    if size > MAX_WHOLE:
        raise FormatError(f"{size} bytes of packed points; up to {MAX_WHOLE} are read")
    out = bytearray()
    at, end, runs = 0, len(packed), 0
    try:
        while at < end and len(out) <= size:
            if (runs := runs + 1) > _MOST_RUNS:
                raise FormatError(f"points packed in more than {_MOST_RUNS} pieces")
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
            else:  # the copy may overlap its own output
                out += (out[start:] * (length // back + 1))[:length]
    except IndexError:
        raise FormatError("the packed points are broken") from None
    if len(out) != size:
        raise FormatError(f"the packed points are {len(out)} bytes; the header says {size}")
    return bytes(out)
