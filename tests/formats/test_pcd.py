"""PCD files: the three ways of storing points, padding, and what is broken."""

import struct

import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.formats.pcd import parse_pcd, read_pcd

X = np.array([1.5, -2.25, 3.0], dtype="<f4")
RING = np.array([7, 0, 65535], dtype="<u2")
NORMAL = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], dtype="<f4")


def header(data: str, points: int = 3) -> bytes:
    return (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x _ ring normal\nSIZE 4 1 2 4\nTYPE F U U F\n"
        f"COUNT 1 2 1 3\nWIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
    ).encode()


def records() -> bytes:
    return b"".join(
        struct.pack("<fBBH3f", x, 1, 2, ring, *normal) for x, ring, normal in zip(X, RING, NORMAL, strict=True)
    )


def packed(flat: bytes) -> bytes:
    """LZF made of literals alone."""
    runs = (flat[start : start + 32] for start in range(0, len(flat), 32))
    body = b"".join(bytes([len(run) - 1]) + run for run in runs)
    return struct.pack("<II", len(body), len(flat)) + body


def columns() -> bytes:
    return X.tobytes() + bytes([1, 2] * 3) + RING.tobytes() + NORMAL.tobytes()


def text() -> bytes:
    rows = zip(X, RING, NORMAL, strict=True)
    return "\n".join(f"{x} 1 2 {ring} {' '.join(str(value) for value in normal)}" for x, ring, normal in rows).encode()


@pytest.mark.parametrize(
    "data",
    [
        header("ascii") + text(),
        header("binary") + records(),
        header("binary") + records() + bytes(40),  # some writers pad to a page
        header("binary_compressed") + packed(columns()),
    ],
    ids=["ascii", "binary", "padded", "compressed"],
)
def test_all_forms_hold_the_same_columns(data: bytes, tmp_path) -> None:
    path = tmp_path / "scan.pcd"
    path.write_bytes(data)
    fields = read_pcd(path).columns
    assert list(fields) == ["x", "ring", "normal"]
    assert fields["x"].dtype == np.float32
    assert fields["ring"].dtype == np.uint16
    np.testing.assert_array_equal(fields["x"], X)
    np.testing.assert_array_equal(fields["ring"], RING)
    np.testing.assert_array_equal(fields["normal"], NORMAL)


def compressed(points: int, body: bytes, full: int) -> bytes:
    head = f"FIELDS i\nSIZE 1\nTYPE U\nPOINTS {points}\nDATA binary_compressed\n".encode()
    return head + struct.pack("<II", len(body), full) + body


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (bytes([2, 5, 6, 7, 1 << 5, 2]), [5, 6, 7, 5, 6, 7]),  # three bytes from three back
        (bytes([0, 9, 2 << 5, 0]), [9, 9, 9, 9, 9]),  # a copy that runs into itself
        (bytes([1, 1, 2, 7 << 5, 3, 1]), [1, 2, *[1, 2] * 6]),  # a long copy has its length in a byte of its own
    ],
    ids=["copy", "overlapping", "long"],
)
def test_back_references(body: bytes, expected: list[int]) -> None:
    assert parse_pcd(compressed(len(expected), body, len(expected))).columns["i"].tolist() == expected


def test_a_reference_far_back_uses_both_bytes() -> None:
    flat = bytes(range(200)) + bytes(200)
    runs = b"".join(bytes([len(run) - 1]) + run for run in (flat[at : at + 32] for at in range(0, 400, 32)))
    body = runs + bytes([(1 << 5) | ((400 - 5) >> 8), (400 - 5 - 1) & 255])
    values = parse_pcd(compressed(403, body, 403)).columns["i"]
    assert values[-3:].tolist() == [5, 6, 7]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"solid cube\n", "no line DATA"),
        (header("zipped"), "DATA is 'zipped'; it must be ascii, binary or binary_compressed"),
        (header("binary").replace(b"POINTS 3\n", b""), "the header has no line POINTS"),
        (header("binary").replace(b"TYPE F U U F", b"TYPE F U U"), "TYPE and COUNT must have one value for each field"),
        (header("binary").replace(b"TYPE F", b"TYPE Q"), "TYPE 'Q' of SIZE '4' is unknown; F has 4 or 8 bytes"),
        (header("binary").replace(b"SIZE 4", b"SIZE 999999999999"), "TYPE 'F' of SIZE '999999999999' is unknown"),
        (header("binary").replace(b"POINTS 3", b"POINTS many"), "POINTS is 'many'; it must be a whole number >= 0"),
        (header("binary").replace(b"POINTS 3", b"POINTS -3"), "POINTS is '-3'; it must be a whole number >= 0"),
        (header("binary").replace(b"POINTS 3", b"POINTS 1" + b"0" * 12), "bytes of points; 1000000000000 need"),
        (header("binary").replace(b"POINTS 3", b"POINTS 1" + b"0" * 5000), "POINTS is .*; it must be a whole number"),
        (header("binary").replace(b"COUNT 1 2 1 3", b"COUNT 0 0 0 0"), "COUNT is 0 0 0 0; all are 1 to 65536"),
        (header("binary").replace(b"COUNT 1", b"COUNT 999999999999"), "COUNT is 999999999999 2 1 3; all are 1 to"),
        (
            header("binary").replace(b"0 0 0 1 0 0 0", b"0 0 0 1 0 0") + records(),
            "VIEWPOINT: '0 0 0 1 0 0' is not 7 finite numbers",
        ),
        (
            header("binary").replace(b"0 0 0 1 0 0 0", b"0 0 0 2 0 0 0") + records(),
            "VIEWPOINT: 0 0 0 2 0 0 0 has a quaternion of",
        ),
        (header("binary").replace(b"ring", b"x"), "FIELDS names 'x' twice"),
        (b"# comment\n" * 20_000 + header("ascii") + text(), "no line DATA"),
        (header("binary") + records()[:-1], "59 bytes of points; 3 need 60"),
        (header("ascii") + b"1 2 3", "not a table of numbers: the dtype passed requires 7 columns but 3"),
        (header("ascii") + text().replace(b"65535", b"left"), "could not convert string 'left' to uint16"),
        (header("ascii") + text().replace(b"65535", b"65536"), "could not convert string '65536' to uint16"),
        (header("ascii") + text().replace(b"1.5", b"left"), "could not convert string 'left' to float32"),
        (header("ascii", 4) + text(), "4 points are announced, but 3 lines of numbers are there"),
        (header("ascii") + b"1" * (2**24 + 1), "bytes of points as text; up to 16777216 are read"),
        (header("binary_compressed") + b"\0" * 4, "truncated before its points"),
        (header("binary_compressed") + packed(columns())[:-5], "the file is truncated"),
        (compressed(3, bytes([1 << 5, 9]), 3), "the packed points are broken"),
        (compressed(3, bytes([0, 9]), 3), "the packed points are 1 bytes; the header says 3"),
    ],
)
def test_broken_files(data: bytes, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        parse_pcd(data)
