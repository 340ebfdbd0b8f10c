"""The top view of a layout, as a condition image: the rival of casting in the paper's ablation."""

from __future__ import annotations

import numpy as np

from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import Sensor

NEAR, FAR = 2.0, 80.0  # m from the sensor along the ground: the lowest row and the highest
_CEILING = 12.0  # m over the sensor's origin: what is higher counts as that high
_HIGH = 200.0  # m over the sensor's origin, where the rays start


def top_view(layout: Layout, sensor: Sensor, pose: np.ndarray) -> RangeImage:
    """What a layout shows from above around a sensor at world_from_sensor `pose` [4, 4], in images of its shape.

    A pixel looks straight down at a place of its own: its column's azimuth is the sensor's, and rows are the farther
    the higher, in equal ratios from 2 to 80 m. `depth` is how far below a ceiling of 12 m the surface is, `label` its
    class. The paper does not say how it projects; azimuths that agree with those of the scan are the best case for it.
    """
    rows, columns = sensor.shape
    azimuth = sensor.azimuth_start - (np.arange(columns) + 0.5) * sensor.azimuth_span / columns
    azimuth = azimuth + np.arctan2(pose[1, 0], pose[0, 0])
    distance = np.geomspace(FAR, NEAR, rows)[:, None]
    origins = np.empty((rows, columns, 3))
    origins[..., 0] = pose[0, 3] + distance * np.cos(azimuth)
    origins[..., 1] = pose[1, 3] + distance * np.sin(azimuth)
    origins[..., 2] = pose[2, 3] + _HIGH
    down = np.broadcast_to((0.0, 0.0, -1.0), (rows * columns, 3))
    hits = Raycaster(layout).cast(origins.reshape(-1, 3), down)
    depth = np.where(hits.valid, np.maximum(hits.distance - (_HIGH - _CEILING), 0.1), 0)
    return RangeImage(
        sensor=sensor,
        depth=depth.reshape(sensor.shape).astype(np.float32),
        label=hits.label.reshape(sensor.shape),
        instance=hits.instance.reshape(sensor.shape),
    )
