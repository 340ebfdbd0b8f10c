"""What the network's state is too coarse for: lost returns, ranges to the millimetre, readings of intensity."""

from __future__ import annotations

import dataclasses

import numpy as np

from lidardraft.diffusion.codec import MAX_DEPTH
from lidardraft.scene.labelling import agrees
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor_model import SensorModel

# Two ranges are of one surface where they differ by no more than this [m], and this share of the range.
_SAME_SURFACE = (0.3, 0.03)
_END = 0.99 * MAX_DEPTH  # m
_DARK = 0.1  # an intensity up to which a surface may read 0


def postprocess(
    generated: RangeImage, condition_image: RangeImage, simulated: RangeImage, rng: np.random.Generator
) -> RangeImage:
    """`generated` as the sensor reports it, with what the network is right about.

    - Returns: those of the simulated scan, and further ones where the layout has no surface, but for those at the end
      of the state, which stand for any range beyond. Which firings are lost on a surface is chance that the sensor
      model knows: of returns that the network takes away 5 to 20 % are not there.
    - Ranges: the simulated one where both agree, whose noise is the sensor model's; of moves within that tolerance the
      network gets fewer right than wrong. A return without any neighbour at its range becomes the simulated one, or
      none. Others get the range noise of the sensor.
    - Readings: in the steps of the sensor; 0 where the simulated scan reads 0 and the surface is dark.
    """
    sensor = generated.sensor
    assert generated.intensity is not None
    assert simulated.intensity is not None
    added = ~condition_image.valid & (generated.depth < _END)
    depth = np.where(simulated.valid | added, generated.depth, 0)
    lone = (depth > 0) & ~_has_neighbour(depth, sensor.wraps)
    given = lone | (simulated.valid & (depth == 0))
    depth = np.where(given, simulated.depth, depth)
    # The state ends at MAX_DEPTH, sensors may not.
    known = dataclasses.replace(simulated, depth=np.minimum(simulated.depth, np.float32(MAX_DEPTH)))
    same = given | agrees(dataclasses.replace(generated, depth=depth), known)
    noisy = depth + sensor.range_sigma * rng.standard_normal(depth.shape, dtype=np.float32)
    noisy = np.clip(noisy, sensor.min_range, sensor.max_range)
    depth = np.where(depth > 0, np.where(same, simulated.depth, noisy), 0).astype(np.float32)
    intensity = np.where(given, simulated.intensity, generated.intensity)
    intensity[(simulated.intensity == 0) & (intensity <= _DARK) & simulated.valid] = 0
    levels = SensorModel.from_sensor(sensor).levels
    if levels:
        intensity = np.round(intensity * levels) / levels
    return dataclasses.replace(generated, depth=depth, intensity=np.where(depth > 0, intensity, 0).astype(np.float32))


def _has_neighbour(depth: np.ndarray, wraps: bool) -> np.ndarray:
    """Whether one of the eight pixels around has a return of the same surface, bool [H, W]."""
    around = np.pad(depth, ((1, 1), (0, 0)))
    around = np.pad(around, ((0, 0), (1, 1)), mode="wrap" if wraps else "constant")
    height, width = depth.shape
    reach = _SAME_SURFACE[0] + _SAME_SURFACE[1] * depth
    found = np.zeros(depth.shape, dtype=bool)
    for row in range(3):
        for column in range(3):
            if (row, column) != (1, 1):
                other = around[row : row + height, column : column + width]
                found |= (other > 0) & (np.abs(other - depth) <= reach)
    return found
