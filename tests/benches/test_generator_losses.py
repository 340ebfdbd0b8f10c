"""Losses of the generator see what they say."""

import dataclasses
import math

import numpy as np
import pytest
import torch

from generator_losses import apart, in_metres, mean_over, squared, without_air
from lidardraft.diffusion.codec import CONDITION_CHANNELS, DEPTH, INTENSITY, MAX_DEPTH, VALIDITY
from lidardraft.diffusion.denoiser import Denoiser, edm_weight
from lidardraft.semantics import BY_NAME
from lidardraft.training import recipes

SIGMA = torch.tensor([0.3])
NO_CONDITION = torch.zeros(1, CONDITION_CHANNELS, 4, 8)


def state(depth: float = 0.2) -> torch.Tensor:
    """All pixels return, at one depth."""
    clean = torch.zeros(1, 3, 4, 8)
    clean[:, DEPTH], clean[:, VALIDITY] = depth, 1.0
    return clean


def test_the_present_loss_is_the_denoisers() -> None:
    torch.manual_seed(0)
    denoiser = Denoiser.from_config(dataclasses.replace(recipes.tiny().stages[0].denoiser, copy_gate=False))
    clean, noise, sigma = torch.randn(2, 3, 16, 64), torch.randn(2, 3, 16, 64), torch.tensor([0.1, 2.0])
    rays, condition = torch.randn(4, 16, 64), torch.randn(2, CONDITION_CHANNELS, 16, 64)
    denoised = denoiser.denoise(clean + sigma[:, None, None, None] * noise, sigma, rays, condition, wraps=True)
    expected = denoiser.loss(clean, sigma, noise, rays, condition, wraps=True)
    assert torch.allclose(squared(denoised, clean, sigma, condition), expected)


def test_validity_apart_is_least_for_the_mean() -> None:
    share = 0.75
    clean = state()
    clean[:, VALIDITY].view(-1)[: round((1 - share) * 32)] = -1.0

    def loss(validity: float) -> float:
        denoised = clean.clone()
        denoised[:, VALIDITY] = validity
        return apart(denoised, clean, SIGMA, NO_CONDITION).item()

    tried = np.linspace(-1.2, 1.2, 49)
    assert tried[np.argmin([loss(v) for v in tried])] == pytest.approx(2 * share - 1)
    # What is surer than sure is worse.
    assert loss(1.2) > loss(1.1) > loss(1.0)


def test_an_error_of_the_ground_counts_in_metres() -> None:
    def loss(metres: float, ground: bool) -> float:
        clean = state(2 * math.log2(metres + 1) / math.log2(MAX_DEPTH + 1) - 1)
        denoised, condition = clean.clone(), NO_CONDITION.clone()
        denoised[:, DEPTH] += 0.01
        condition[:, BY_NAME["road" if ground else "building"].id] = 1.0
        return in_metres(denoised, clean, SIGMA, condition).item()

    assert loss(10.0, ground=True) == pytest.approx(loss(10.0, ground=False), rel=1e-4)
    assert loss(21.0, ground=True) == pytest.approx(4 * loss(21.0, ground=False), rel=1e-4)
    assert loss(21.0, ground=False) == pytest.approx(loss(10.0, ground=False), rel=1e-3)


def test_a_depth_between_two_surfaces_costs_more_than_either() -> None:
    clean = state()
    clean[:, DEPTH, :, 4:] = 0.6

    def more(column: int, depth: float) -> float:
        denoised = clean.clone()
        denoised[:, DEPTH, 0, column] = depth
        return (
            without_air(denoised, clean, SIGMA, NO_CONDITION) - squared(denoised, clean, SIGMA, NO_CONDITION)
        ).item()

    assert more(3, 0.2) == more(3, 0.6) == more(4, 0.2) == 0.0
    in_the_air = (edm_weight(SIGMA) * 0.2**2 / 32).item()
    assert more(3, 0.4) == pytest.approx(in_the_air)
    assert more(1, 0.4) == pytest.approx(in_the_air)  # no surface of 0.6 is beside
    # Surfaces on either side of the seam are beside each other.
    assert more(0, 0.6) == 0.0


def test_pixels_without_a_return_count_for_validity_alone() -> None:
    clean = state()
    clean[:, VALIDITY, 0, 0] = -1.0
    denoised = clean.clone()
    denoised[:, [DEPTH, INTENSITY], 0, 0] += 0.5
    for loss in (squared, in_metres):
        assert loss(denoised, clean, SIGMA, NO_CONDITION).item() == 0.0
    assert mean_over(torch.ones(2, 1, 2, 2), torch.zeros(2, 1, 2, 2)).tolist() == [0.0, 0.0]
