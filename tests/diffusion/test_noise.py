import itertools

import pytest
import torch

from lidardraft.diffusion.noise import add_noise, karras_levels, score_from_denoised, training_levels
from lidardraft.errors import LidarDraftError


def test_karras_levels_fall_from_sigma_max_to_sigma_min_and_zero() -> None:
    levels = karras_levels(10, sigma_min=0.01, sigma_max=50.0)
    assert levels[0] == pytest.approx(50.0)
    assert levels[-2] == pytest.approx(0.01)
    assert levels[-1] == 0.0
    assert all(high > low for high, low in itertools.pairwise(levels))
    assert karras_levels(1) == pytest.approx([20.0, 0.0])
    with pytest.raises(LidarDraftError, match="steps is 0; it must be at least 1"):
        karras_levels(0)


def test_training_levels_are_log_normal_and_stratified() -> None:
    sigma = training_levels(1000, torch.Generator().manual_seed(0), mean=-1.0, std=1.4)
    assert sigma.log().mean().item() == pytest.approx(-1.0, abs=0.01)
    assert sigma.log().std().item() == pytest.approx(1.4, abs=0.02)
    # One sample in each half, whatever the seed: without strata this fails every other time.
    for seed in range(20):
        low, high = sorted(training_levels(2, torch.Generator().manual_seed(seed), mean=-1.0, std=1.4).log().tolist())
        assert low <= -1.0 <= high


def test_the_score_of_a_gaussian_is_known() -> None:
    # Clean data N(2, 0.3^2): D = (s^2 x + sigma^2 2) / (s^2 + sigma^2), and the score of N(2, s^2 + sigma^2).
    x, sigma, variance = torch.tensor([[0.5], [3.0]]), torch.tensor([0.4, 2.0]), 0.3**2
    denoised = (variance * x + sigma[:, None] ** 2 * 2) / (variance + sigma[:, None] ** 2)
    score = score_from_denoised(x, denoised, sigma)
    torch.testing.assert_close(score, (2 - x) / (variance + sigma[:, None] ** 2))


def test_noise_is_added_per_sample_and_given_back_by_the_score() -> None:
    clean, noise = torch.zeros(2, 3, 4, 4), torch.ones(2, 3, 4, 4)
    sigma = torch.tensor([0.5, 3.0])
    x = add_noise(clean, sigma, noise)
    assert x[0].unique().tolist() == [0.5]
    assert x[1].unique().tolist() == [3.0]
    # S = -noise / sigma
    torch.testing.assert_close(score_from_denoised(x, clean, sigma), -noise / sigma[:, None, None, None])
