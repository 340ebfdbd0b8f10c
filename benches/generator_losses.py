"""Losses of the generator: the squared error, and others that see what the eye sees."""

from __future__ import annotations

import math
from collections.abc import Callable

import torch
from torch import Tensor

from lidardraft.diffusion.codec import CONDITION_PARTS, DEPTH, MAX_DEPTH, VALIDITY
from lidardraft.diffusion.denoiser import edm_weight, has_return, what_counts
from lidardraft.networks.convolution import pad_columns
from lidardraft.semantics import BY_NAME

# Of what was denoised, the clean states and noise levels, and the conditions: a loss for each sample [B].
Loss = Callable[[Tensor, Tensor, Tensor, Tensor], Tensor]

_GROUND = [BY_NAME[name].id for name in ("road", "sidewalk", "terrain")]
_USUAL = 10.0  # m: there an error in metres counts as much as one of the state
_IN_THE_AIR = 1.0  # what being between two surfaces costs, beside the error itself


def mean_over(values: Tensor, where: Tensor) -> Tensor:
    """[B], of values where `where` is, 0 where it is nowhere."""
    where = where.to(values)
    return (values * where).flatten(1).sum(1) / where.flatten(1).sum(1).clamp(min=1)


def squared_error(denoised: Tensor, clean: Tensor, depth_weight: Tensor | float = 1.0) -> Tensor:
    """Over all that counts, as in `Denoiser.loss`: depth and intensity of returns, and validity."""
    error = (denoised - clean) ** 2
    weights = torch.ones_like(error)
    weights[:, DEPTH : DEPTH + 1] *= depth_weight
    return mean_over(error * weights, what_counts(clean))


def squared(denoised: Tensor, clean: Tensor, sigma: Tensor, condition: Tensor) -> Tensor:
    """`Denoiser.loss` without what its gates are taught."""
    del condition
    return edm_weight(sigma) * squared_error(denoised, clean)


def apart(denoised: Tensor, clean: Tensor, sigma: Tensor, condition: Tensor) -> Tensor:
    """Validity by the cross-entropy of its probability, which the same mean makes least, and without EDM's weight."""
    del condition
    surfaces = [channel for channel in range(clean.shape[1]) if channel != VALIDITY]
    error = ((denoised - clean) ** 2)[:, surfaces].mean(dim=1, keepdim=True)
    valid = has_return(clean)
    chance = ((1 + denoised[:, VALIDITY : VALIDITY + 1]) / 2).clamp(0.002, 0.998)
    entropy = -torch.where(valid, chance, 1 - chance).log()
    # Outside of 0 and 1 the clamp has no gradient: the square brings it back.
    outside = (denoised[:, VALIDITY : VALIDITY + 1].abs() - 1).clamp(min=0) ** 2
    return edm_weight(sigma) * mean_over(error, valid) + (entropy + outside).flatten(1).mean(1)


def in_metres(denoised: Tensor, clean: Tensor, sigma: Tensor, condition: Tensor) -> Tensor:
    """The depth of the ground in metres, in units in which 10 m away nothing changes."""
    ground = condition[:, CONDITION_PARTS["class"]][:, _GROUND].amax(dim=1, keepdim=True) > 0
    scale = 2 / math.log2(MAX_DEPTH + 1)
    metres = torch.exp2((clean[:, DEPTH : DEPTH + 1] + 1) / scale)  # range + 1, to which its derivative is proportional
    weight = torch.where(ground, (metres / (_USUAL + 1)) ** 2, torch.ones_like(metres))
    return edm_weight(sigma) * squared_error(denoised, clean, weight)


def without_air(denoised: Tensor, clean: Tensor, sigma: Tensor, condition: Tensor) -> Tensor:
    """A depth is also to be that of some return beside: between two surfaces, near to neither, it costs more."""
    valid = has_return(clean)
    depth = clean[:, DEPTH : DEPTH + 1]
    around = pad_columns(torch.where(valid, depth, torch.full_like(depth, 9.0)), 1, True)  # 9: no surface there
    width = depth.shape[-1]
    beside = torch.cat([around[..., shift : shift + width] for shift in range(3)], dim=1)
    gap = ((denoised[:, DEPTH : DEPTH + 1] - beside) ** 2).amin(dim=1, keepdim=True)
    return squared(denoised, clean, sigma, condition) + _IN_THE_AIR * edm_weight(sigma) * mean_over(gap, valid)
