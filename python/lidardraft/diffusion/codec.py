"""Conversion between metres and the network's numbers, which spread by about 1/2: only this file knows both.

A range is encoded relative to that of flat ground along the same ray, on a logarithmic scale: 0 is the ground of any
sensor at any mount, and an error of 5 % is the same number everywhere.
"""

from __future__ import annotations

import math

import numpy as np
import torch
from torch import Tensor

from lidardraft.diffusion.channels import CLASS, DEPTH, INTENSITY, RAY_CHANNELS, STATE_CHANNELS, VALIDITY
from lidardraft.errors import SensorError
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, NUM_CLASSES

MAX_DEPTH = 120.0  # m, the limit of encoded ranges

_GROUND_WITHIN = 20.0  # m, also for beams above it: farther away, walls and trees are likelier than ground
# Means and spreads of streets' returns; they make each channel spread by about 1/2.
_DEPTH_SCALE = 1.2  # of log2 of the range over the ground's
_INTENSITY_SCALE, _INTENSITY_SHIFT = 2.9, 1.65  # of the root of the intensity, which spreads dark readings
_BITS = 1 << np.arange(CLASS.stop - CLASS.start, dtype=np.uint8)
_BIT = 0.5  # a bit is this or its negative


def encode_scans(depth: Tensor, label: Tensor, intensity: Tensor | None, sensor: Sensor) -> Tensor:
    """The states of scans, f32 [B, 8, H, W]: range, intensity, validity +-1, and the bits of the class.

    `depth` f32 [B, H, W] in metres, 0 without a return; `label` u8; `intensity` f32 in 0 to 1; None stands for the
    mean. A pixel without a return has the depth of the next return to its left, around the ring if the sensor wraps; to
    the left of a sector's first return, that of this return; in an empty row, 120 m.
    """
    valid = depth > 0
    log_depth = torch.log2(_filled_from_left(depth, valid, sensor.wraps).clamp(max=MAX_DEPTH) + 1)
    ground = torch.from_numpy(_log_ground(sensor)).to(depth.device)
    shown = torch.zeros_like(depth) if intensity is None else _INTENSITY_SCALE * intensity.sqrt() - _INTENSITY_SHIFT
    single = torch.stack([(log_depth - ground) / _DEPTH_SCALE, shown, 2.0 * valid - 1.0], dim=1)
    bits = torch.from_numpy(_BITS).to(depth.device)[:, None, None]
    return torch.cat([single, torch.where((label[:, None] & bits) > 0, _BIT, -_BIT)], dim=1)


def encode_scan(image: RangeImage) -> np.ndarray:
    """The state f32 [8, H, W] of one scan, as in `encode_scans`; that of a layout's cast is a condition."""
    intensity = None if image.intensity is None else _tensor(image.intensity)
    return encode_scans(_tensor(image.depth), _tensor(image.label), intensity, image.sensor)[0].numpy()


def decode_scan(state: np.ndarray, sensor: Sensor) -> RangeImage:
    """The scan of a state f32 [8, H, W], with labels. A pixel has a return if validity is positive, the depth is in the
    sensor's range, and the vehicle is not in the way.

    A state has no instances: they are 0. Raises `SensorError` on a state of another sensor.
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


def encode_rays(sensor: Sensor) -> np.ndarray:
    """The network's input on the rays, f32 [5, H, W], each of the order of 1.

    Channels: elevation, log spacing of the beams, log spacing of the columns, log range of flat ground, and whether the
    vehicle hides the pixel.
    """
    elevation = np.array(sensor.elevations)
    spacing = -np.gradient(elevation) if len(elevation) > 1 else np.ones(1)
    rays = np.empty((RAY_CHANNELS, *sensor.shape), dtype=np.float32)
    rays[0] = elevation[:, None] / math.radians(30)
    rays[1] = np.log2(spacing / math.radians(0.5))[:, None]
    rays[2] = math.log2(sensor.azimuth_span / sensor.columns / math.radians(0.35))
    rays[3] = _log_ground(sensor) - 3
    rays[4] = sensor.blocked_pixels
    return rays


def _log_ground(sensor: Sensor) -> np.ndarray:
    """log2(range + 1) of flat ground along each beam, f32 [H, 1]; that of 20 m for beams that see none nearby."""
    down = np.sin(-np.array(sensor.elevations))
    height = max(sensor.mount_height, 0.5)
    ground = np.where(down * _GROUND_WITHIN > height, height / np.maximum(down, 1e-6), _GROUND_WITHIN)
    return np.log2(ground + 1).astype(np.float32)[:, None]


def _tensor(image: np.ndarray) -> Tensor:
    return torch.from_numpy(np.ascontiguousarray(image))[None]


def _filled_from_left(depth: Tensor, valid: Tensor, wraps: bool) -> Tensor:
    """`depth` [B, H, W] with the value of the last valid column to the left; 120 m in rows without one."""
    columns = torch.arange(depth.shape[-1], device=depth.device)
    # The last valid column up to each column; before the first one it is the row's last if it wraps, else the first.
    source = torch.where(valid, columns, -1).cummax(-1).values
    first = torch.where(valid.any(-1), valid.int().argmax(-1), -1)
    source = torch.where(source < 0, source[..., -1:] if wraps else first[..., None], source)
    return torch.where(source < 0, MAX_DEPTH, depth.gather(-1, source.clamp(min=0)))
