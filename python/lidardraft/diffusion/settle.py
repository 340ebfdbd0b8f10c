"""What the network's state is too coarse for: ranges to the millimetre, and returns that hang in the air."""

from __future__ import annotations

import dataclasses

import numpy as np

from lidardraft.scene.range_image import RangeImage

# Two ranges are of one surface where they differ by no more than this [m], and this share of the range.
_SAME_SURFACE = (0.3, 0.03)


def settle(generated: RangeImage, simulated: RangeImage, rng: np.random.Generator) -> RangeImage:
    """`generated` with the ranges of the simulated scan, and without returns that no surface around them explains.

    Where both have a return, the range is the simulated one: of the moves that a network learns from streets a tenth is
    for the better, on recordings and on streets, and most leave what was right. A return that the simulated scan lacks
    gets the range noise of the sensor; without any neighbour at its range it is none.
    """
    sensor = generated.sensor
    added = generated.valid & ~simulated.valid
    noisy = generated.depth + sensor.range_sigma * rng.standard_normal(sensor.shape, dtype=np.float32)
    noisy = np.clip(noisy, sensor.min_range, sensor.max_range)
    depth = np.where(added, noisy, np.where(generated.valid, simulated.depth, 0)).astype(np.float32)
    depth[added & ~_has_neighbour(depth, sensor.wraps)] = 0
    assert generated.intensity is not None
    intensity = np.where(depth > 0, generated.intensity, 0).astype(np.float32)
    return dataclasses.replace(generated, depth=depth, intensity=intensity)


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
