"""Annealed Langevin dynamics against denoisers that are known exactly."""

import itertools
from typing import Any

import pytest
import torch
from torch import Tensor

from lidardraft.diffusion.codec import CONDITION_CHANNELS
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.langevin import langevin_step, sample_langevin
from lidardraft.diffusion.noise import geometric_levels
from lidardraft.diffusion.sampler import sample
from lidardraft.errors import LidarDraftError
from lidardraft.scene.sensor import Sensor

MEAN, STD = 0.3, 0.5


def of_a_gaussian(x: Tensor, sigma: Tensor) -> Tensor:
    """D for clean data N(MEAN, STD^2), closed form."""
    variance = (sigma**2)[:, None]
    return (STD**2 * x + variance * MEAN) / (STD**2 + variance)


def of_points(points: Tensor, x: Tensor, sigma: Tensor) -> Tensor:
    """D for clean data that is one of `points` [N, C]: their mean under the posterior."""
    distance = ((x[:, None] - points) ** 2).sum(dim=-1)
    return torch.softmax(-distance / (2 * sigma[:, None] ** 2), dim=1) @ points


@pytest.mark.parametrize(
    ("sigma_max", "levels", "updates", "published"),
    [(50, 232, 5, 6.2e-6), (90, 500, 5, 3.3e-6), (190, 1086, 3, 1.8e-6), (348, 2311, 3, 0.9e-6)],
)
def test_the_step_is_what_ncsnv2_publishes(sigma_max: float, levels: int, updates: int, published: float) -> None:
    # CIFAR-10 (LiDARGen's), CelebA, LSUN bedroom and tower, FFHQ; step sizes at the last level, 0.01
    above, below = geometric_levels(levels, sigma_max=sigma_max)[:2]
    assert langevin_step(above / below, updates) * 0.01**2 == pytest.approx(published, rel=0.02)


def test_levels_fall_geometrically() -> None:
    levels = geometric_levels(232)
    assert (levels[0], levels[-1]) == pytest.approx((50.0, 0.01))
    ratios = [above / below for above, below in itertools.pairwise(levels)]
    assert ratios == pytest.approx([5000 ** (1 / 231)] * 231)
    assert geometric_levels(1) == [50.0]
    with pytest.raises(LidarDraftError, match="steps is 0"):
        geometric_levels(0)
    with pytest.raises(LidarDraftError, match=r"starts at the noise level 0\.01; it must be greater than 0\.01"):
        geometric_levels(3, sigma_max=0.01)


def spread_of_a_gaussian(sigmas: list[float]) -> float:
    """The standard deviation that the updates leave, in closed form: each is linear in x, with independent noise."""
    step, variance = langevin_step(sigmas[0] / sigmas[1], 5), sigmas[0] ** 2
    for sigma in sigmas:
        for _ in range(5):
            size = step * sigma**2
            variance = (1 - size / (STD**2 + sigma**2)) ** 2 * variance + 2 * size
    return float(variance**0.5 * STD**2 / (STD**2 + sigmas[-1] ** 2))


def test_a_gaussian_is_sampled_with_its_mean_and_the_spread_that_the_updates_leave() -> None:
    sigmas = geometric_levels(60, sigma_max=10.0)
    generator = torch.Generator().manual_seed(0)
    x = sigmas[0] * torch.randn(20_000, 1, generator=generator)
    *_, end = sample_langevin(of_a_gaussian, x, sigmas, lambda: torch.randn(x.shape, generator=generator))
    assert end.mean().item() == pytest.approx(MEAN, abs=0.015)
    assert end.std().item() == pytest.approx(spread_of_a_gaussian(sigmas), rel=0.015)


def test_fewer_levels_leave_more_spread_than_the_data_have() -> None:
    few, lidargens, more = (spread_of_a_gaussian(geometric_levels(levels)) / STD for levels in (30, 232, 2000))
    assert (few, lidargens, more) == pytest.approx((1.17, 1.067, 1.055), abs=0.005)


def test_points_are_sampled_in_their_shares() -> None:
    points = torch.tensor([[-1.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
    sigmas = geometric_levels(60, sigma_max=10.0)
    generator = torch.Generator().manual_seed(0)
    x = sigmas[0] * torch.randn(2000, 2, generator=generator)

    def denoise(x: Tensor, sigma: Tensor) -> Tensor:
        return of_points(points, x, sigma)

    *_, end = sample_langevin(denoise, x, sigmas, lambda: torch.randn(x.shape, generator=generator))
    distance, nearest = (end[:, None] - points[:3]).norm(dim=-1).min(dim=1)
    assert distance.max() < 1e-3  # without the last denoising it would be some hundredths
    shares = torch.bincount(nearest, minlength=3) / 2000
    assert (shares - torch.tensor([0.25, 0.25, 0.5])).abs().max() < 0.05


def test_a_level_takes_its_updates_and_the_last_one_call_more() -> None:
    seen: list[float] = []

    def denoise(x: Tensor, sigma: Tensor) -> Tensor:
        seen.append(sigma[0].item())
        return of_a_gaussian(x, sigma)

    sigmas = geometric_levels(4)
    x = torch.randn(2, 1)
    assert len(list(sample_langevin(denoise, x, sigmas, lambda: torch.randn(2, 1), updates=3))) == 4
    assert seen == pytest.approx([sigma for sigma in sigmas for _ in range(3)] + [sigmas[-1]])
    with pytest.raises(LidarDraftError, match="updates is 0; it must be at least 1"):
        next(sample_langevin(denoise, x, sigmas, lambda: x, updates=0))


@torch.no_grad()
def test_sample_k_does_not_depend_on_the_batch() -> None:
    torch.manual_seed(0)
    shape: dict[str, Any] = {"cell": (2, 4), "widths": (8, 8), "strides": (1, 2), "dilations": (1, 1)}
    config = DenoiserConfig(**shape, condition=("depth", "class"), controlnet=True)
    denoiser = Denoiser.from_config(config).eval()
    for weight in denoiser.parameters():
        weight += 0.05 * torch.randn_like(weight)
    sensor = Sensor(name="small", elevations=(0.1, 0.0, -0.1, -0.2), columns=16)
    condition = torch.rand(1, CONDITION_CHANNELS, *sensor.shape)
    ends = []
    for seeds in ([5, 6], [6]):
        *_, end = sample(denoiser, sensor, seeds=seeds, condition=condition, steps=3, langevin=2)
        ends.append(end[-1])
    torch.testing.assert_close(ends[0], ends[1], atol=5e-3, rtol=0)
    *_, other = sample(denoiser, sensor, seeds=[5], condition=condition, steps=3, langevin=2)
    assert not torch.allclose(other[0], ends[1], atol=1e-2)
