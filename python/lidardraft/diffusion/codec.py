"""Between metres and the network's [-1, 1]: this file is the only place that knows both.

Depth r becomes 2 log2(r + 1) / log2(MAX_DEPTH + 1) - 1, as in LiDARGen and R2DM, with one MAX_DEPTH for all sensors, so
that one network can serve them.
"""

from __future__ import annotations

import math

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import NUM_CLASSES

MAX_DEPTH = 120.0  # m, becomes 1
DEPTH, INTENSITY, VALIDITY = range(3)  # channels of the state
STATE_CHANNELS = 3
# What a condition is made of, and its channels: the one-hot class and the depth and validity that the layout's cast
# has, and the state of its simulated scan.
CONDITION_PARTS = {
    "class": slice(0, NUM_CLASSES),
    "depth": slice(NUM_CLASSES, NUM_CLASSES + 2),
    "simulated": slice(NUM_CLASSES + 2, NUM_CLASSES + 2 + STATE_CHANNELS),
}
CONDITION_CHANNELS = NUM_CLASSES + 2 + STATE_CHANNELS
RAY_CHANNELS = 4

_SCALE = 2 / math.log2(MAX_DEPTH + 1)


def encode_scan(image: RangeImage) -> np.ndarray:
    """The state of a scan, f32 [3, H, W]: log depth and intensity in [-1, 1], validity +-1.

    A pixel without a return has the depth of the next return to its left, around the ring where the sensor wraps; left
    of a sector's first return, that one's; in an empty row, 1. A scan without intensities has the intensity 0.
    """
    valid = image.valid
    state = np.empty((STATE_CHANNELS, *image.sensor.shape), dtype=np.float32)
    state[DEPTH] = _fill_from_left(_encode_depth(image.depth), valid, image.sensor.wraps)
    state[INTENSITY] = -1.0 if image.intensity is None else 2 * image.intensity - 1
    state[VALIDITY] = 2.0 * valid - 1.0
    return state


def decode_scan(state: np.ndarray, sensor: Sensor) -> RangeImage:
    """The scan of a state f32 [3, H, W]: a return where validity is positive, depth within the sensor's range, and
    the vehicle not in the way.

    The state knows no classes: label and instance are 0. Raises `SensorError` on a state of another sensor.
    """
    if state.shape != (STATE_CHANNELS, *sensor.shape):
        raise SensorError(f"state is {state.shape}; {sensor.name} needs {(STATE_CHANNELS, *sensor.shape)}")
    depth = np.exp2((np.clip(state[DEPTH], -1, 1) + 1) / _SCALE) - 1
    valid = (state[VALIDITY] > 0) & (depth >= sensor.min_range) & (depth <= sensor.max_range)
    valid &= ~sensor.blocked_pixels
    intensity = np.clip((state[INTENSITY] + 1) / 2, 0, 1)
    return RangeImage(
        sensor=sensor,
        depth=np.where(valid, depth, 0).astype(np.float32),
        label=np.zeros(sensor.shape, dtype=np.uint8),
        instance=np.zeros(sensor.shape, dtype=np.uint32),
        intensity=np.where(valid, intensity, 0).astype(np.float32),
    )


def encode_condition(condition_image: RangeImage, simulated: RangeImage) -> np.ndarray:
    """The condition of a layout, f32 [K + 5, H, W], in the order of `CONDITION_PARTS`.

    Of its cast the one-hot label with "none", the log depth (1 without a hit) and validity +-1; of its simulated scan
    the state (`encode_scan`).
    """
    valid = condition_image.valid
    condition = np.zeros((CONDITION_CHANNELS, *condition_image.sensor.shape), dtype=np.float32)
    np.put_along_axis(condition, condition_image.label[None].astype(np.intp), 1.0, axis=0)
    depth = np.where(valid, _encode_depth(condition_image.depth), 1.0)
    condition[CONDITION_PARTS["depth"]] = depth, 2.0 * valid - 1.0
    condition[CONDITION_PARTS["simulated"]] = encode_scan(simulated)
    return condition


def encode_rays(sensor: Sensor) -> np.ndarray:
    """What the network is told of the rays, f32 [4, H, W], each of the order of 1.

    Elevation, log spacing of the beams, log spacing of the columns, and whether the vehicle hides the pixel.
    """
    elevation = np.array(sensor.elevations)
    spacing = -np.gradient(elevation) if len(elevation) > 1 else np.ones(1)
    rays = np.empty((RAY_CHANNELS, *sensor.shape), dtype=np.float32)
    rays[0] = elevation[:, None] / math.radians(30)
    rays[1] = np.log2(spacing / math.radians(0.5))[:, None]
    rays[2] = math.log2(sensor.azimuth_span / sensor.columns / math.radians(0.35))
    rays[3] = sensor.blocked_pixels
    return rays


def _encode_depth(depth: np.ndarray) -> np.ndarray:
    state: np.ndarray = np.log2(np.minimum(depth, np.float32(MAX_DEPTH)) + 1) * np.float32(_SCALE) - 1
    return state


def _fill_from_left(image: np.ndarray, valid: np.ndarray, wraps: bool) -> np.ndarray:
    """`image` [H, W] with the value of the last valid column to the left; 1 in rows without one."""
    width = image.shape[1]
    # The last valid column up to each column; before the first one it is the row's last if it wraps, else the first.
    source = np.maximum.accumulate(np.where(valid, np.arange(width, dtype=np.int32), -1), axis=1)
    before = source[:, -1:] if wraps else np.where(valid.any(axis=1), valid.argmax(axis=1), -1)[:, None]
    source = np.where(source < 0, before, source)
    filled = np.take_along_axis(image, np.maximum(source, 0), axis=1)
    return np.where(source < 0, np.float32(1), filled)
