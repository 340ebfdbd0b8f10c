"""Noise levels and the sampler against denoisers that are known exactly."""

import argparse
import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from lidardraft.cli.arguments import add_weights, read_pipeline
from lidardraft.diffusion.channels import STATE_CHANNELS
from lidardraft.diffusion.codec import encode_rays
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import GUIDANCE, LAST_NOISE, STEPS, DenoiserConfig
from lidardraft.diffusion.noise import add_noise, karras_levels, training_levels
from lidardraft.diffusion.sampler import Denoise, sample, sample_multistep
from lidardraft.errors import LidarDraftError, SensorError
from lidardraft.networks import weight_file
from lidardraft.networks.layers import reduced_precision
from lidardraft.pipeline import Pipeline
from lidardraft.scene.sensor import Sensor
from lidardraft.training import recipes


def test_karras_levels_fall_from_sigma_max_to_sigma_min_and_zero() -> None:
    levels = karras_levels(10, sigma_min=0.01, sigma_max=50.0)
    assert levels[0] == pytest.approx(50.0)
    assert levels[-2] == pytest.approx(0.01)
    assert levels[-1] == 0.0
    assert all(high > low for high, low in itertools.pairwise(levels))
    assert karras_levels(1) == pytest.approx([20.0, 0.0])
    with pytest.raises(LidarDraftError, match="steps is 0; it must be at least 1"):
        karras_levels(0)
    with pytest.raises(LidarDraftError, match=r"starts at the noise level 0\.01; it must be greater than 1"):
        karras_levels(3, sigma_min=1.0, sigma_max=0.01)


def test_training_levels_are_log_normal_and_stratified() -> None:
    sigma = training_levels(1000, torch.Generator().manual_seed(0), mean=-1.0, std=1.4)
    assert sigma.log().mean().item() == pytest.approx(-1.0, abs=0.01)
    assert sigma.log().std().item() == pytest.approx(1.4, abs=0.02)
    # One sample in each half, whatever the seed: without strata this fails every other time.
    for seed in range(20):
        low, high = sorted(training_levels(2, torch.Generator().manual_seed(seed), mean=-1.0, std=1.4).log().tolist())
        assert low <= -1.0 <= high


def test_noise_is_added_per_sample() -> None:
    clean, noise = torch.zeros(2, 3, 4, 4), torch.ones(2, 3, 4, 4)
    sigma = torch.tensor([0.5, 3.0])
    x = add_noise(clean, sigma, noise)
    assert x[0].unique().tolist() == [0.5]
    assert x[1].unique().tolist() == [3.0]


MEAN, STD = 0.3, 0.5


def of_a_gaussian(x: Tensor, sigma: Tensor) -> Tensor:
    """D for clean data N(MEAN, STD^2), closed form."""
    variance = (sigma**2).reshape(-1, *[1] * (x.dim() - 1))
    return (STD**2 * x + variance * MEAN) / (STD**2 + variance)


def of_points(points: Tensor) -> Denoise:
    """D for clean data that is one of `points` [N, C]: their mean under the posterior."""

    def denoise(x: Tensor, sigma: Tensor) -> Tensor:
        distance = ((x[:, None] - points) ** 2).sum(dim=-1)
        return torch.softmax(-distance / (2 * sigma[:, None] ** 2), dim=1) @ points

    return denoise


def error(steps: int) -> float:
    """Distance between the sampler's end and the ODE's, which scales x - MEAN by the falling spread."""
    sigmas = karras_levels(steps, sigma_min=1e-4, sigma_max=10.0)
    x = sigmas[0] * torch.randn(64, 1, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    *_, end = sample_multistep(of_a_gaussian, x, sigmas)
    exact = MEAN + (x - MEAN) * STD / (STD**2 + sigmas[0] ** 2) ** 0.5
    return (end - exact).abs().max().item()


def test_the_sampler_converges_with_the_second_order() -> None:
    coarse, middle, fine = error(16), error(32), error(64)
    assert coarse < 0.1
    assert 3.0 < coarse / middle < 5.5
    assert 3.0 < middle / fine < 5.5


def test_samples_of_a_finite_data_set_are_its_points_in_their_shares() -> None:
    points = torch.tensor([[-1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    sigmas = karras_levels(20, sigma_min=0.002)
    x = sigmas[0] * torch.randn(600, 2, generator=torch.Generator().manual_seed(0))
    *_, end = sample_multistep(of_points(points), x, sigmas)
    distance, nearest = (end[:, None] - points).norm(dim=-1).min(dim=1)
    assert distance.max() < 1e-3
    assert (torch.bincount(nearest, minlength=3) / 600 - 1 / 3).abs().max() < 0.08


@torch.no_grad()
def test_sample_k_does_not_depend_on_the_batch() -> None:
    torch.manual_seed(0)
    shape: dict[str, Any] = {"cell": (2, 4), "widths": (8, 8), "strides": (1, 2), "dilations": (1, 1)}
    config = DenoiserConfig(**shape, condition=("depth", "class"), controlnet=True)
    denoiser = Denoiser.from_config(config).eval()
    with torch.no_grad():
        for weight in denoiser.parameters():
            weight += 0.05 * torch.randn_like(weight)
    sensor = Sensor(name="small", elevations=(0.1, 0.0, -0.1, -0.2), columns=16)
    condition = torch.rand(1, STATE_CHANNELS, *sensor.shape)
    *_, together = sample(denoiser, sensor, seeds=[5, 6, 7], condition=condition, steps=3)
    *_, alone = sample(denoiser, sensor, seeds=[np.int64(6)], condition=condition, steps=3)
    assert together.shape == (3, STATE_CHANNELS, 4, 16)
    torch.testing.assert_close(together[1:2], alone, atol=2e-3, rtol=0)
    assert not torch.allclose(together[0], together[1], atol=1e-2)
    *_, free = sample(denoiser, sensor, seeds=[6], steps=3)
    assert not torch.allclose(free, alone, atol=1e-2)


def test_a_sensor_that_cannot_be_cut_into_cells_is_refused() -> None:
    config = DenoiserConfig(cell=(2, 4), widths=(8,), strides=(1,), dilations=(1,))
    sensor = Sensor(name="odd", elevations=(0.1, 0.0, -0.1), columns=16)
    with pytest.raises(SensorError, match=r"odd is \(3, 16\); these weights need multiples of \(2, 4\)"):
        sample(Denoiser.from_config(config), sensor, seeds=[0])


@torch.no_grad()
def test_whether_the_columns_wrap_follows_from_the_sensor() -> None:
    torch.manual_seed(0)
    config = DenoiserConfig(cell=(2, 4), widths=(8,), strides=(1,), dilations=(1,))
    denoiser = Denoiser.from_config(config).eval()
    with torch.no_grad():
        for weight in denoiser.parameters():
            weight += 0.05 * torch.randn_like(weight)
    elevations = (0.1, 0.0, -0.1, -0.2)
    ring = Sensor(name="ring", elevations=elevations, columns=16)
    sector = Sensor(name="sector", elevations=elevations, columns=16, azimuth_start=1.0, azimuth_span=2.0)
    ends = [list(sample(denoiser, sensor, seeds=[3], steps=3))[-1] for sensor in (ring, sector)]
    for end, wraps in zip(ends, (True, False), strict=True):
        sigmas = karras_levels(3)
        rays = torch.from_numpy(encode_rays(ring if wraps else sector))
        x = sigmas[0] * torch.randn((1, STATE_CHANNELS, 4, 16), generator=torch.Generator().manual_seed(3))
        with reduced_precision(torch.device("cpu")):
            *_, expected = sample_multistep(lambda x, s, r=rays, w=wraps: denoiser.denoise(x, s, r, wraps=w), x, sigmas)
        assert torch.equal(end, expected)
    assert not torch.allclose(ends[0], ends[1], atol=1e-3)


@torch.no_grad()
def test_a_processor_with_bfloat16_samples_the_same_scan_within_a_hundredth(monkeypatch: pytest.MonkeyPatch) -> None:
    torch.manual_seed(0)
    config = DenoiserConfig(cell=(2, 4), widths=(16, 16), strides=(1, 2), dilations=(1, 1))
    denoiser = Denoiser.from_config(config).eval()
    torch.nn.init.normal_(denoiser.network.head.weight, std=0.02)
    sensor = Sensor(name="ring", elevations=(0.1, 0.0, -0.1, -0.2), columns=64)
    ends = []
    for capabilities in ({}, {"avx512_bf16": True}):
        monkeypatch.setattr(torch.cpu, "get_capabilities", lambda found=capabilities: found, raising=False)
        ends.append(list(sample(denoiser, sensor, seeds=[3], steps=20))[-1])
    exact, rough = ends
    assert rough.dtype == torch.float32
    assert 0 < (rough - exact).square().mean().sqrt() < 0.01 * exact.std()


MEAN, STD = 0.3, 0.5


def test_python_and_the_command_line_sample_as_the_weights_say(tmp_path: Path) -> None:
    parser = argparse.ArgumentParser()
    add_weights(parser)
    file = tmp_path / "weights.safetensors"
    denoiser = Denoiser.from_config(recipes.tiny()[-1].denoiser)
    for stored, sampled in (
        ({}, (STEPS, GUIDANCE, LAST_NOISE)),
        ({"steps": 3, "last_noise": 0.25}, (3, GUIDANCE, 0.25)),
    ):
        weight_file.save(denoiser, file, {"sampling": stored} if stored else {})
        for pipeline in (Pipeline.from_pretrained(file), read_pipeline(parser.parse_args(["--weights", str(file)]))):
            assert (pipeline.steps, pipeline.guidance, pipeline.last_noise) == sampled
    given = Pipeline.from_pretrained(file, steps=5, guidance=1.5)
    assert (given.steps, given.guidance, given.last_noise) == (5, 1.5, 0.25)
    weight_file.save(denoiser, file, {"sampling": {"last_noise": 0}})
    with pytest.raises(LidarDraftError, match=r"weights.safetensors: last_noise is 0; it must be a finite"):
        Pipeline.from_pretrained(file)


def test_the_last_call_is_made_at_the_last_noise() -> None:
    assert karras_levels(4, sigma_min=0.1)[-2:] == pytest.approx([0.1, 0.0])
