"""What the vehicle under a sensor hides from it, by the vehicle's shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lidardraft.scene.layout import Layout
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor

_NEAREST = 1e-3  # m: what is too near to be measured hides as well


def with_vehicle(sensor: Sensor, vehicle: Layout) -> Sensor:
    """The sensor with `blocked` as a vehicle hides it: every ray that meets `vehicle`, in the layout frame, where the
    sensor stands on its mount over the origin.

    `detail(Layout((box,)))` makes a vehicle with a roof, a bonnet and windows of a box of class car.
    """
    near = replace(sensor, min_range=_NEAREST, blocked=(), model=None)
    hidden = raycast(vehicle, near, sensor.pose()).valid
    step = sensor.azimuth_span / sensor.columns
    offsets = sensor.azimuth_offsets or (0.0,) * len(hidden)
    blocked = []
    for row, offset in zip(hidden, offsets, strict=True):
        changes = np.flatnonzero(np.diff(np.pad(row.astype(np.int8), 1)))
        starts, ends = sensor.azimuth_start + offset - step * changes.reshape(-1, 2)[:, ::-1].T
        blocked.append(tuple(zip(starts.tolist(), ends.tolist(), strict=True)))
    return replace(sensor, blocked=tuple(blocked))
