"""Scans for nodes of ROS 2, which need not be installed here."""

from __future__ import annotations

from typing import Any

from lidardraft.formats.point_cloud2 import cloud_fields
from lidardraft.scan import Scan


def point_cloud2(scan: Scan, *, as_seen: bool = True) -> dict[str, Any]:
    """All fields of a sensor_msgs/PointCloud2 of a scan except `header`, by name; each of `fields` has those of a
    PointField.

    A point has x, y, z [m], intensity in 0 to 1, ring, label and instance. With `as_seen` it is in the frame of its own
    column, with its time [s] after the first column, whose time is the stamp. Else the motion of the sensor is taken
    out. Raises `SensorError` if the scan has no intensity.
    """
    return cloud_fields(scan.frame(as_seen=as_seen))
