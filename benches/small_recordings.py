"""Small files as others have them: captures of an Ouster's packets, laid out as its sensor documentation says, and
PandaSet's, without pandas: tables as pandas 0.25 pickles them, and a drive of one sweep."""

from __future__ import annotations

import gzip
import json
import pickle
import struct
from pathlib import Path

import numpy as np

COLUMNS, BEAMS = 512, 16
METADATA = {
    "prod_line": "OS-1-16",
    "prod_sn": "1",
    "lidar_mode": "512x10",
    "beam_altitude_angles": np.linspace(-15, 15, BEAMS).tolist(),  # from the lowest: our rows are turned over
    "beam_azimuth_angles": [3.0, 1.0, -1.0, -3.0] * (BEAMS // 4),
    "lidar_origin_to_beam_origin_mm": 15.8,
    "lidar_to_sensor_transform": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1],
    "data_format": {
        "columns_per_frame": COLUMNS,
        "columns_per_packet": 16,
        "pixels_per_column": BEAMS,
        "column_window": [0, COLUMNS - 1],
        "pixel_shift_by_row": [0] * BEAMS,
        "udp_profile_lidar": "RNG19_RFL8_SIG16_NIR16",
    },
}


def write_capture(
    path: Path,
    millimetres: list[np.ndarray],
    reflectivity: int = 51,
    window: tuple[int, int] = (0, COLUMNS - 1),
    largest: int = 2**16,
) -> None:
    """A capture of frames of ranges u32 [BEAMS, COLUMNS], the lowest beam first, and the metadata beside it; the sensor
    measures the columns of a `window`. Datagrams come in fragments of the `largest` size."""
    text = json.dumps(METADATA | {"data_format": METADATA["data_format"] | {"column_window": list(window)}})
    path.with_suffix(".json").write_text(text)
    pixel = np.dtype({"names": ["range", "reflectivity"], "formats": ["<u4", "u1"], "offsets": [0, 4], "itemsize": 12})
    column = np.dtype([("time", "<u8"), ("number", "<u2"), ("status", "<u2"), ("pixels", pixel, BEAMS)])
    packets = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 2**18, 1)]
    for number, ranges in enumerate(millimetres, 1):
        columns = np.zeros(COLUMNS, column)
        columns["number"] = np.arange(COLUMNS)
        columns["status"] = (columns["number"] - window[0]) % COLUMNS <= (window[1] - window[0]) % COLUMNS
        columns["pixels"]["range"], columns["pixels"]["reflectivity"] = ranges.T, reflectivity
        for first in range(0, COLUMNS, 16):
            payload = struct.pack("<HH28x", 1, number) + columns[first : first + 16].tobytes() + bytes(32)
            datagram = struct.pack(">HHHH", 7502, 7502, 8 + len(payload), 0) + payload
            parts = range(0, len(datagram), largest)
            packets += [_ethernet(datagram, start, largest, number * COLUMNS + first) for start in parts]
    path.write_bytes(b"".join(packets))


def _ethernet(datagram: bytes, start: int, largest: int, number: int) -> bytes:
    part = datagram[start : start + largest]
    cut = (0x2000 if start + largest < len(datagram) else 0) | start // 8
    head = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(part), number, cut, 64, 17, 0, b"\1\1\1\1", b"\2\2\2\2")
    packet = bytes(12) + b"\x08\x00" + head + part
    return struct.pack("<IIII", 0, 0, len(packet), len(packet)) + packet


def pandas_pickle(**columns: np.ndarray) -> bytes:
    """The program of a table as pandas 0.25 writes it; columns are of numbers or of objects."""
    blocks = [_array_step(values[None]) for values in columns.values()]
    names = [_index_step(name) for name in columns]
    axes = [_index_step(*columns), _call("pandas.core.indexes.range RangeIndex")]
    state = b"(" + b"".join(map(_list_step, (axes, blocks, names))) + b"}t"
    return b"\x80\x03cpandas.core.frame\nDataFrame\n)\x81}X\x05\x00\x00\x00_datac" + (
        b"pandas.core.internals.managers\nBlockManager\n)\x81" + state + b"bsb."
    )


def _step(value: object) -> bytes:
    return pickle.dumps(value, 3)[2:-1]


def _list_step(items: list[bytes]) -> bytes:
    return b"](" + b"".join(items) + b"e"


def _call(name: str, *arguments: bytes) -> bytes:
    return b"c" + name.replace(" ", "\n").encode() + b"\n(" + b"".join(arguments) + b"tR"


def _index_step(*names: str) -> bytes:
    data = b"}" + _step("data") + _array_step(np.array(names, dtype=object)) + b"s"
    return _call("pandas.core.indexes.base _new_Index", b"cpandas.core.indexes.base\nIndex\n", data)


def _array_step(values: np.ndarray) -> bytes:
    order, kind = values.dtype.str[0], values.dtype.str[1:].replace("O", "O8")
    content = values.ravel().tolist() if kind == "O8" else values.tobytes()
    dtype = _call("numpy dtype", _step(kind), _step(False), _step(True)) + _step((3, order)) + b"b"
    array = _call("numpy.core.multiarray _reconstruct", b"cnumpy\nndarray\n", _step((0,)), _step(b"b"))
    return array + b"(" + _step(1) + _step(values.shape) + dtype + _step(False) + _step(content) + b"tb"


def pandaset(root: Path) -> Path:
    """A drive of PandaSet of one sweep, two points of the Pandar64 and one of the PandarGT, with a car and labels, of a
    vehicle that looks along the world's y from (5, 7, 0); its sweep."""
    folder = root / "001"
    for part in ("lidar", "annotations/cuboids", "annotations/semseg"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    points = np.array([(5.0, 17.0, 1.0), (8.0, 17.0, 1.0), (5.0, 27.0, 1.0)])
    xyz = dict(zip("xyz", points.T, strict=True))
    sweep = pandas_pickle(**xyz, i=np.array([0.0, 51, 255]), t=np.full(3, 9.9), d=np.array([0, 0, 1]))
    place = {f"position.{axis}": np.array([value]) for axis, value in zip("xyz", (5.0, 17.0, 0.75), strict=True)}
    size = {f"dimensions.{axis}": np.array([value]) for axis, value in zip("xyz", (1.8, 4.2, 1.5), strict=True)}
    label, status = np.array(["Car"], object), np.array([np.nan], object)
    cuboids = {"label": label, "yaw": np.array([0.5]), "cuboids.sensor_id": np.array([-1])} | place | size
    tables = {
        "lidar": sweep,
        "annotations/cuboids": pandas_pickle(**cuboids, **{"attributes.rider_status": status}),
        "annotations/semseg": pandas_pickle(**{"class": np.array([13, 7, 41])}),
    }
    for part, program in tables.items():
        (folder / part / "00.pkl.gz").write_bytes(gzip.compress(program, mtime=0))
    pose = {"position": {"x": 5, "y": 7, "z": 0}, "heading": {"w": 1, "x": 0, "y": 0, "z": 0}}
    (folder / "lidar/poses.json").write_text(json.dumps([pose]))
    (folder / "lidar/timestamps.json").write_text("[10.0]")
    return folder / "lidar" / "00.pkl.gz"
