"""Between metres and the network's numbers, which spread by about 1/2: this file is the only place that knows both.

A range is told by how it compares with that of flat ground along the same ray, on a logarithmic scale: 0 is the ground
of any sensor at any mount, and an error of 5 % is the same number everywhere.
"""

from __future__ import annotations

import math

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, NUM_CLASSES

MAX_DEPTH = 120.0  # m, what is farther is as far
DEPTH, INTENSITY, VALIDITY = range(3)  # channels of the state
CLASS = slice(3, 8)  # those of the bits of a class id, the lowest first (Chen et al., Analog Bits, ICLR 2023)
STATE_CHANNELS = 8
# What a condition is made of, and its channels: range and validity of the layout's cast, its class, the state of its
# simulated scan, and where the layout leaves open what there is.
CONDITION_PARTS = {
    "depth": [DEPTH, VALIDITY],
    "class": list(range(CLASS.start, CLASS.stop)),
    "simulated": list(range(STATE_CHANNELS, 2 * STATE_CHANNELS)),
    "open": [2 * STATE_CHANNELS],
}
CONDITION_CHANNELS = 2 * STATE_CHANNELS + 1
RAY_CHANNELS = 5
HIDDEN = 4  # the channel of the rays that says what the vehicle hides

_GROUND_WITHIN = 20.0  # m, and what looks over it: farther off, walls and trees are likelier than ground
# Means and spreads of streets' returns, by which each channel spreads by about 1/2.
_DEPTH_SCALE = 1.2  # of log2 of the range over the ground's
_INTENSITY_SCALE, _INTENSITY_SHIFT = 2.9, 1.65  # of the root of the intensity, which spreads dark readings
_BITS = 1 << np.arange(CLASS.stop - CLASS.start, dtype=np.uint8)
_BIT = 0.5  # a bit is this or its negative


def encode_scan(image: RangeImage) -> np.ndarray:
    """The state of a scan, f32 [8, H, W]: range, intensity, validity +-1, and the bits of the class.

    A pixel without a return has the depth of the next return to its left, around the ring where the sensor wraps; left
    of a sector's first return, that one's; in an empty row, 120 m. A scan without intensities has the mean one.
    """
    valid = image.valid
    state = np.empty((STATE_CHANNELS, *image.sensor.shape), dtype=np.float32)
    state[DEPTH] = _encode_depth(_fill_from_left(image.depth, valid, image.sensor.wraps), image.sensor)
    state[INTENSITY] = 0.0
    if image.intensity is not None:
        state[INTENSITY] = _INTENSITY_SCALE * np.sqrt(image.intensity) - _INTENSITY_SHIFT
    state[VALIDITY] = 2.0 * valid - 1.0
    state[CLASS] = np.where(image.label & _BITS[:, None, None], _BIT, -_BIT)
    return state


def decode_scan(state: np.ndarray, sensor: Sensor) -> RangeImage:
    """The scan of a state f32 [8, H, W], with labels: a return where validity is positive, depth within the sensor's
    range, and the vehicle not in the way.

    The state knows no instances: they are 0. Raises `SensorError` on a state of another sensor.
    """
    if state.shape != (STATE_CHANNELS, *sensor.shape):
        raise SensorError(f"state is {state.shape}; {sensor.name} needs {(STATE_CHANNELS, *sensor.shape)}")
    depth = np.exp2(np.clip(state[DEPTH] * _DEPTH_SCALE + _log_ground(sensor), 0, math.log2(MAX_DEPTH + 1))) - 1
    valid = (state[VALIDITY] > 0) & (depth >= sensor.min_range) & (depth <= sensor.max_range)
    valid &= ~sensor.blocked_pixels
    intensity = (np.clip(state[INTENSITY] + _INTENSITY_SHIFT, 0, _INTENSITY_SCALE) / _INTENSITY_SCALE) ** 2
    label = ((state[CLASS] > 0) * _BITS[:, None, None]).sum(axis=0, dtype=np.uint8)
    label[label >= NUM_CLASSES] = BY_NAME["other"].id
    return RangeImage(
        sensor=sensor,
        depth=np.where(valid, depth, 0).astype(np.float32),
        label=np.where(valid, label, 0).astype(np.uint8),
        instance=np.zeros(sensor.shape, dtype=np.uint32),
        intensity=np.where(valid, intensity, 0).astype(np.float32),
    )


def encode_condition(
    condition_image: RangeImage, simulated: RangeImage, open_pixels: np.ndarray | None = None
) -> np.ndarray:
    """The condition of a layout, f32 [17, H, W]: the states (`encode_scan`) of its cast and of its simulated scan, and
    1 where `open_pixels`, bool [H, W]; there both states are 0. The classes of both are the cast's: pairs on disk keep
    no others.
    """
    open_ = np.zeros(simulated.sensor.shape, dtype=bool) if open_pixels is None else open_pixels
    # before they are encoded: a pixel without a return would have the depth of an open one to its left
    states = [encode_scan(image.keep(~open_)) for image in (condition_image, simulated)]
    states[1][CLASS] = states[0][CLASS]
    condition = np.concatenate([*states, open_[None].astype(np.float32)])
    condition[:-1, open_] = 0.0
    return condition


def encode_rays(sensor: Sensor) -> np.ndarray:
    """What the network is told of the rays, f32 [5, H, W], each of the order of 1.

    Elevation, log spacing of the beams, log spacing of the columns, log range of flat ground, and whether the vehicle
    hides the pixel.
    """
    elevation = np.array(sensor.elevations)
    spacing = -np.gradient(elevation) if len(elevation) > 1 else np.ones(1)
    rays = np.empty((RAY_CHANNELS, *sensor.shape), dtype=np.float32)
    rays[0] = elevation[:, None] / math.radians(30)
    rays[1] = np.log2(spacing / math.radians(0.5))[:, None]
    rays[2] = math.log2(sensor.azimuth_span / sensor.columns / math.radians(0.35))
    rays[3] = _log_ground(sensor) - 3
    rays[HIDDEN] = sensor.blocked_pixels
    return rays


def _encode_depth(depth: np.ndarray, sensor: Sensor) -> np.ndarray:
    log_depth = np.log2(np.minimum(depth, np.float32(MAX_DEPTH)) + 1)
    state: np.ndarray = (log_depth - _log_ground(sensor)) / np.float32(_DEPTH_SCALE)
    return state


def _log_ground(sensor: Sensor) -> np.ndarray:
    """log2(range + 1) of flat ground along each beam, f32 [H, 1]; of what sees none nearby, that of 20 m."""
    down = np.sin(-np.array(sensor.elevations))
    height = max(sensor.mount_height, 0.5)
    ground = np.where(down * _GROUND_WITHIN > height, height / np.maximum(down, 1e-6), _GROUND_WITHIN)
    return np.log2(ground + 1).astype(np.float32)[:, None]


def _fill_from_left(depth: np.ndarray, valid: np.ndarray, wraps: bool) -> np.ndarray:
    """`depth` [H, W] with the value of the last valid column to the left; 120 m in rows without one."""
    width = depth.shape[1]
    # The last valid column up to each column; before the first one it is the row's last if it wraps, else the first.
    source = np.maximum.accumulate(np.where(valid, np.arange(width, dtype=np.int32), -1), axis=1)
    before = source[:, -1:] if wraps else np.where(valid.any(axis=1), valid.argmax(axis=1), -1)[:, None]
    source = np.where(source < 0, before, source)
    filled = np.take_along_axis(depth, np.maximum(source, 0), axis=1)
    return np.where(source < 0, np.float32(MAX_DEPTH), filled)
