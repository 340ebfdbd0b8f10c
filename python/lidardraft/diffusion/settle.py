"""What the network's state is too coarse for: ranges to the millimetre, and returns that hang in the air."""

from __future__ import annotations

import dataclasses

import numpy as np

from lidardraft.scene.labelling import agrees
from lidardraft.scene.range_image import RangeImage

# Two ranges are of one surface where they differ by no more than this [m], and this share of the range.
_SAME_SURFACE = (0.3, 0.03)


def settle(generated: RangeImage, simulated: RangeImage, rng: np.random.Generator) -> RangeImage:
    """`generated` with the noise of its sensor, and without returns that no surface around them explains.

    A return without any neighbour at its range becomes the simulated one, or none where that is none. Where both agree,
    the range is the simulated one, whose noise is the sensor model's: of moves within that tolerance the network gets
    fewer right than wrong. Elsewhere it gets the range noise of the sensor.
    """
    sensor = generated.sensor
    lone = generated.valid & ~_has_neighbour(generated.depth, sensor.wraps)
    depth = np.where(lone, simulated.depth, generated.depth)
    same = agrees(dataclasses.replace(generated, depth=depth), simulated)
    noisy = depth + sensor.range_sigma * rng.standard_normal(depth.shape, dtype=np.float32)
    noisy = np.clip(noisy, sensor.min_range, sensor.max_range)
    depth = np.where(depth > 0, np.where(same, simulated.depth, noisy), 0).astype(np.float32)
    assert generated.intensity is not None
    assert simulated.intensity is not None
    intensity = np.where(lone, simulated.intensity, generated.intensity)
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
