"""Point cloud files of the Point Cloud Library: PCD 0.7, text, binary and compressed.

A header of lines names the fields; then come lines of numbers, records, or columns packed with LZF (Lehmann's
LibLZF, which PCL uses). `_` fields are padding.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path

import numpy as np

from lidardraft.errors import FormatError

_KEYS = ("FIELDS", "SIZE", "TYPE", "COUNT", "POINTS", "DATA")
_KINDS = {"F": "f", "I": "i", "U": "u"}
_PADDING = "_"


def read_pcd(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """The columns of a file by name, each [N], or [N, count] where a field has several values.

    Raises `FormatError` on a missing or truncated file and on a header that is no PCD header.
    """
    name = os.fspath(path)
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FormatError(f"{name}: {error.strerror}") from None
    return pcd_columns(name, data)


def pcd_columns(name: str, data: bytes) -> dict[str, np.ndarray]:
    """As `read_pcd`, of the bytes of a file; `name` is for the messages."""
    header, body = _header(name, data)
    try:
        record = np.dtype(
            [
                (f"{index}{field}", f"<{_KINDS[kind]}{int(size)}", (int(count),))
                for index, (field, size, kind, count) in enumerate(
                    zip(header["FIELDS"], header["SIZE"], header["TYPE"], header["COUNT"], strict=True)
                )
            ]
        )
        points = int(header["POINTS"][0])
    except (KeyError, ValueError, TypeError, IndexError) as error:
        raise FormatError(f"{name}: the header is broken: {error}") from None
    form = header["DATA"][0] if header["DATA"] else ""
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


def _header(name: str, data: bytes) -> tuple[dict[str, list[str]], bytes]:
    header: dict[str, list[str]] = {}
    start = 0
    while "DATA" not in header:
        end = data.find(b"\n", start)
        if end < 0 or end - start > 100_000:
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
    words = body.split()
    widths = [record[field].shape[0] for field in record.names or ()]
    if len(words) < points * sum(widths):
        raise FormatError(f"{name} has {len(words)} numbers; {points} points of {sum(widths)} need more")
    try:
        values = np.array(words[: points * sum(widths)], dtype=np.float64).reshape(points, sum(widths))
    except ValueError as error:
        raise FormatError(f"{name}: {error}") from None
    pieces = np.split(values, np.cumsum(widths)[:-1], axis=1)
    return [piece.astype(record[index].base) for index, piece in enumerate(pieces)]


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
        columns.append(np.frombuffer(flat[start : start + size], record[field].base).reshape(points, -1).copy())
        start += size
    return columns


def _unpacked(name: str, packed: bytes, size: int) -> bytes:
    """LZF: a byte below 32 starts a run of literals; else its top three bits are a length, the rest a way back."""
    out = bytearray()
    at, end = 0, len(packed)
    try:
        while at < end:
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
