"""Annealed Langevin dynamics, the sampler of the paper's base.

That is LiDARGen (Zyrianov et al., ECCV 2022), which samples as NCSNv2 does (Song and Ermon, "Improved Techniques for
Training Score-Based Generative Models", NeurIPS 2020, Algorithm 1).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from torch import Tensor

from lidardraft.diffusion.noise import score_from_denoised
from lidardraft.errors import LidarDraftError


def sample_langevin(
    denoise: Callable[[Tensor, Tensor], Tensor],
    x: Tensor,
    sigmas: Sequence[float],
    noise: Callable[[], Tensor],
    *,
    updates: int = 5,
) -> Iterator[Tensor]:
    """The state after each level of `sigmas`, which fall geometrically, from x at the level sigmas[0].

    A level takes `updates` calls and as many of `noise()`, which gives new standard normal noise like x; the last one
    is denoised by one call more, as LiDARGen does. Raises `LidarDraftError` on `updates` less than 1.
    """
    if updates < 1:
        raise LidarDraftError(f"updates is {updates}; it must be at least 1")
    ratio = sigmas[0] / sigmas[1] if len(sigmas) > 1 else 1.0
    step = langevin_step(ratio, updates)
    for number, sigma in enumerate(sigmas, start=1):
        level = x.new_full((len(x),), sigma)
        size = step * sigma**2
        for _ in range(updates):
            score = score_from_denoised(x, denoise(x, level), level)
            x = x + size * score + (2 * size) ** 0.5 * noise()
        yield x if number < len(sigmas) else denoise(x, level)


def langevin_step(ratio: float, updates: int) -> float:
    """The step size of a level in units of its variance, for levels that fall by `ratio` and so many updates each.

    NCSNv2's Technique 4: of data at a single point the spread after the updates is as close as it can be to that of the
    level. LiDARGen's constants are NCSNv2's for CIFAR-10: ratio 1.0376, 5 updates, 0.062.
    """
    steps = np.geomspace(1e-4, 1, 4000)
    settled = 1 / (1 - steps / 2)
    spread = (1 - steps) ** (2 * updates) * (ratio**2 - settled) + settled
    return float(steps[np.abs(spread - 1).argmin()])
