"""Semantic maps: the class that each ray of a sensor would meet, without a range."""

from __future__ import annotations

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, GROUND, NUM_CLASSES

_FAR = 60.0  # m along the ground: the largest guess
_LOWEST_MOUNT = 0.5  # m


def standing_on_ground(label: np.ndarray, sensor: Sensor) -> RangeImage:
    """The image of a semantic map, class ids [H, W] with 0 for no return, with guessed ranges. The ground is flat;
    everything else stands at the far end of the highest ground below it in its column.

    Raises `FormatError` if the map does not fit the sensor, holds no class or an unknown one.
    """
    if label.shape != sensor.shape or label.dtype.kind not in "iu":
        raise FormatError(f"the map is {label.dtype} {label.shape}; {sensor.name} needs whole numbers {sensor.shape}")
    if not label.any() or label.min() < 0 or label.max() >= NUM_CLASSES:
        held = f"{label.min()} to {label.max()}"
        raise FormatError(f"the map holds {held}; classes are 1 to {NUM_CLASSES - 1}, and 0 for no return")
    down = -np.array(sensor.elevations)[:, None]
    flat = np.minimum(max(sensor.mount_height, _LOWEST_MOUNT) / np.tan(np.maximum(down, 1e-3)), _FAR)
    ground = np.where(np.isin(label, [BY_NAME[name].id for name in GROUND]), flat, flat[-1])
    along = np.maximum.accumulate(ground[::-1], axis=0)[::-1]  # upwards in each column
    depth = np.where(label > 0, along / np.cos(down), 0).astype(np.float32)
    instance = np.zeros(sensor.shape, dtype=np.uint32)
    return RangeImage(sensor=sensor, depth=depth, label=label.astype(np.uint8), instance=instance)
