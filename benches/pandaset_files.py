"""Files as PandaSet has them, without pandas: tables as pandas 0.25 pickles them, and a drive of one sweep."""

from __future__ import annotations

import gzip
import json
import pickle
from pathlib import Path

import numpy as np


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
