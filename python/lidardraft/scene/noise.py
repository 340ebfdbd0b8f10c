"""Random numbers for whole images, as quick as they come: words looked up in quantiles, and noise that is smooth."""

from __future__ import annotations

import math
from functools import cache
from statistics import NormalDist

import numpy as np

_PATCH = 8  # pixels over which texture and dust change


def draws(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Random numbers u16 [*shape], the quickest there are."""
    count = math.prod(shape)
    words: np.ndarray = rng.bit_generator.random_raw(-(-count // 4))
    return words.view(np.uint16)[:count].reshape(shape)


def normal(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Random numbers f32 [*shape] of a normal distribution in 4096 steps, which end at 3.7 standard deviations."""
    return np.take(_normal_quantiles(), draws(rng, shape) >> np.uint16(4), mode="clip")


@cache
def exponential_quantiles() -> np.ndarray:
    """Quantiles f32 [65536] of an exponential distribution of mean 1, to be looked up by `draws`."""
    return -np.log1p(-(np.arange(65536, dtype=np.float64) + 0.5) / 65536).astype(np.float32)


@cache
def _normal_quantiles() -> np.ndarray:
    normal = NormalDist()
    return np.array([normal.inv_cdf((i + 0.5) / 4096) for i in range(4096)], np.float32)


def smooth_noise(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Noise of variance 1 that changes over `_PATCH` columns and half as many rows, f32 [H, W]."""
    coarse = rng.standard_normal((shape[0] // (_PATCH // 2) + 2, shape[1] // _PATCH + 2), np.float32)
    return _stretch(_stretch(coarse, shape[0], _PATCH // 2).T, shape[1], _PATCH).T


def _stretch(values: np.ndarray, length: int, step: int) -> np.ndarray:
    """The rows [N, M] blended into `length` rows, `step` of them from one to the next; the variance stays."""
    angle = (np.arange(step, dtype=np.float32) * np.float32(math.pi / 2 / step))[None, :, None]
    blended = values[:-1, None] * np.cos(angle) + values[1:, None] * np.sin(angle)
    rows: np.ndarray = blended.reshape(-1, values.shape[1])[:length]
    return rows
