"""The fields of ROS 2's sensor_msgs/PointCloud2, as values: from records of points, and to columns."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.formats.frame import Frame, point_records

_KINDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}  # by PointField's datatype
_CODES = {kind: code for code, kind in _KINDS.items()}
_TIMES = ("time", "t", "timestamp", "time_stamp", "offset_time", "point_time_offset")
_MOST_BYTES = 2**29  # of a cloud
_LONGEST = 1.0  # s, of a sweep
_SHORTEST = 1e6  # ns


def cloud_fields(frame: Frame) -> dict[str, Any]:
    """All of a PointCloud2 except its header: `fields` are rows of name, offset, datatype and count."""
    packed = point_records(frame)
    # the alignment that readers in C++ need, with zeros between: `astype` leaves what was in memory there
    records = np.zeros(len(packed), np.dtype(packed.dtype.descr, align=True))
    for name in packed.dtype.names or ():
        records[name] = packed[name]
    rows = {name: (_CODES[kind.str[1:]], offset) for name, (kind, offset, *_) in (records.dtype.fields or {}).items()}
    fields = [{"name": name, "offset": at, "datatype": code, "count": 1} for name, (code, at) in rows.items()]
    step = records.dtype.itemsize
    size = {"height": 1, "width": len(records), "point_step": step, "row_step": step * len(records)}
    data = array("B", records.tobytes())
    return {**size, "fields": fields, "is_bigendian": False, "is_dense": True, "data": data}


def cloud_columns(cloud: Any) -> dict[str, np.ndarray]:
    """The columns [N] of a message by name, [N, count] for a field with several values; padding is left out.

    Raises `FormatError` if its sizes, types or names contradict each other.
    """
    order, step, width, height = "<>"[bool(cloud.is_bigendian)], cloud.point_step, cloud.width, cloud.height
    fields = [field for field in cloud.fields if field.name.strip("_")]
    names = [field.name for field in fields]
    if twice := {name for name in names if names.count(name) > 1}:
        raise FormatError(f"the field {min(twice)} occurs twice")
    formats = list[tuple[str, int]]()
    for field in fields:
        if field.datatype not in _KINDS:
            raise FormatError(f"the field {field.name} has datatype {field.datatype}; it must be 1 to 8")
        formats.append((order + _KINDS[field.datatype], max(1, field.count)))  # old drivers write 0 for one value
        if field.offset + formats[-1][1] * np.dtype(formats[-1][0]).itemsize > step:
            raise FormatError(f"the field {field.name} goes over the {step} bytes of a point")
    line = width * step if height == 1 else cloud.row_step  # for one row, drivers write anything
    if not height * width * step:
        raise FormatError("the cloud has no points")
    if height * width * step > _MOST_BYTES or line < width * step or height * line > len(cloud.data):
        said = f"{height} rows of {width} points of {step} bytes, {line} a row"
        raise FormatError(f"a cloud of {said}, has {len(cloud.data)} bytes; clouds of up to {_MOST_BYTES} are read")
    rows = np.asarray(cloud.data, np.uint8)[: height * line].reshape(height, line)[:, : width * step]
    kinds = [kind if count == 1 else (kind, (count,)) for kind, count in formats]
    layout = {"names": names, "formats": kinds, "offsets": [field.offset for field in fields], "itemsize": step}
    records = np.ascontiguousarray(rows).reshape(-1).view(np.dtype(layout))  # type: ignore[call-overload]
    return {name: records[name].astype(records[name].dtype.newbyteorder("="), copy=False) for name in names}


def sweep_middle(columns: dict[str, np.ndarray]) -> tuple[float, bool] | None:
    """The middle of the times of points [s], and whether it counts from the stamp of the cloud.

    Whole numbers are nanoseconds. Floats are seconds if they span a second or less, and nanoseconds if they span a
    million or more. None for any other span, for a sweep longer than a second, and without times."""
    name = next((name for name in _TIMES if name in columns and columns[name].ndim == 1), None)
    if name is None:
        return None
    times = columns[name].astype(np.float64)
    times = times[np.isfinite(times)]
    low, high = times.min(initial=np.inf), times.max(initial=-np.inf)
    in_ns = columns[name].dtype.kind in "iu" or high - low >= _SHORTEST
    unit = 1e-9 if in_ns else 1.0
    if not high >= low or (high - low) * unit > _LONGEST:
        return None
    middle = (low + high) / 2 * unit
    return middle, abs(middle) <= _LONGEST
