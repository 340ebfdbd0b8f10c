"""PLY point clouds (Turk, 1994): text or binary, of either byte order."""

from __future__ import annotations

import os
import re
from functools import partial

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_bytes, written_whole
from lidardraft.formats.frame import write_each
from lidardraft.formats.pcd import binary_records, text_records

_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"float": "f4", "double": "f8"},
    **{f"{kind}{8 * size}": f"{kind[0]}{size}" for kind in ("int", "uint") for size in (1, 2, 4)},
    **{"float32": "f4", "float64": "f8"},
}
_NAMES = {"f4": "float", "u1": "uchar", "u2": "ushort", "u4": "uint"}
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": "<"}
_LONGEST_HEADER = 100_000  # bytes; a real one has a few hundred


def read_ply(path: str | os.PathLike[str]) -> np.ndarray:
    """The vertices of a file as records [N] of its fields. Raises `FormatError` if it is missing, truncated, or does
    not begin with vertices of numbers."""
    data = read_bytes(path)
    with named(path):
        return parse_ply(data)


def parse_ply(data: bytes) -> np.ndarray:
    """As `read_ply`, from the bytes of a file."""
    head, end, body = data[:_LONGEST_HEADER].partition(b"end_header")
    lines = [line.split() for line in head.decode("latin-1").splitlines()]
    form = next((line[1] for line in lines if len(line) == 3 and line[0] == "format"), "")
    if not data.startswith(b"ply") or not end or form not in _ORDERS:
        raise FormatError("no header of a PLY file")
    order, count = _record(lines, _ORDERS[form])
    body = (body + data[_LONGEST_HEADER:]).removeprefix(b"\r").removeprefix(b"\n")
    if form == "ascii":
        return text_records(body, order, count)
    return binary_records(body, order, count).astype(order.newbyteorder("<"))


def _record(lines: list[list[str]], order: str) -> tuple[np.dtype, int]:
    """The type of a vertex, and the number of vertices."""
    words = [line for line in lines if line[:1] in (["element"], ["property"])]
    if not words or not re.fullmatch("element vertex [0-9]{1,9}", " ".join(words[0])):
        raise FormatError("the first element must be vertex, with the number of them")
    fields = list[tuple[str, str]]()
    for line in words[1:]:
        if line[0] == "element":
            break
        if len(line) != 3 or line[1] not in _TYPES:
            raise FormatError(f"{' '.join(line)!r:.80} is not a property of a vertex: a type of number and a name")
        fields.append((line[2], order + _TYPES[line[1]]))
    names = [name for name, _ in fields]
    if not fields or len(set(names)) != len(names):
        raise FormatError(f"the properties of a vertex are {' '.join(names)!r:.80}; each needs a name of its own")
    return np.dtype(fields), int(words[0][2])


def write_ply(path: str | os.PathLike[str], records: np.ndarray) -> None:
    """Write records [N] of float32 and unsigned fields as the vertices of a binary file."""
    names = records.dtype.names or ()
    properties = "".join(f"property {_NAMES[records.dtype[name].str[1:]]} {name}\n" for name in names)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(records)}\n{properties}end_header\n"
    with written_whole(path) as temporary:
        temporary.write_bytes(header.encode() + records.tobytes())


write_ply_folder = partial(write_each, ".ply", write_ply)
