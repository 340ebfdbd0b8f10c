"""Scans for nodes of ROS 2, of which nothing need be installed here."""

from __future__ import annotations

from typing import Any

from lidardraft.formats.point_cloud2 import cloud_fields
from lidardraft.scan import Scan


def point_cloud2(scan: Scan, *, as_seen: bool = True) -> dict[str, Any]:
    """All fields of a sensor_msgs/PointCloud2 of a scan but `header`, by name; `fields` are those of a PointField each.

    A point has x, y, z [m], intensity in 0 to 1, ring, label and instance. With `as_seen` it lies in the frame of its
    own column, and has its time [s] after the first column, whose time is the stamp; else the motion of the sensor is
    taken out. Raises `SensorError` where the scan has no intensity.
    """
    return cloud_fields(scan.frame(as_seen=as_seen))
