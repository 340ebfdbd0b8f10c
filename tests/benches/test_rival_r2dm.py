"""The rival is what its paper says, and takes the place of our denoiser."""

import math

import pytest
import torch

from generator_arms import CONFIG, OURS, gflop
from lidardraft.diffusion.codec import CONDITION_CHANNELS, STATE_CHANNELS, encode_rays
from lidardraft.diffusion.noise import training_levels
from lidardraft.scene.sensor import Sensor
from rival_r2dm import R2DM, coordinates, cosine_levels, doubled, halved

SMALL = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)
RAYS = torch.from_numpy(encode_rays(SMALL))
CONDITION = torch.zeros(1, CONDITION_CHANNELS, 16, 128)


@pytest.mark.parametrize("cell", [(1, 1), (2, 4)])
def test_a_turn_of_all_that_it_sees_turns_what_it_says(cell: tuple[int, int]) -> None:
    torch.manual_seed(0)
    network = R2DM(16, cell).eval()
    for weight in network.parameters():
        torch.nn.init.normal_(weight, std=0.1)
    seen, turn = torch.randn(1, STATE_CHANNELS + len(OURS.condition_channels) + 32, 16, 128), 8 * cell[1]
    level = torch.tensor([1.0])
    with torch.inference_mode():
        said = network(seen, level, True)
        near = 1e-3 * float(said.std())
        assert torch.allclose(network(seen.roll(turn, -1), level, True), said.roll(turn, -1), atol=near)
        assert not torch.allclose(network(seen, torch.tensor([5.0]), True), said, atol=10 * near)


def test_resampling_keeps_what_is_even() -> None:
    ramp = torch.arange(16.0).expand(1, 2, 8, 16)
    inside = slice(1, -1)
    assert torch.allclose(halved(ramp, False)[..., inside], torch.arange(0.5, 16, 2)[inside].expand(1, 2, 4, 6))
    assert torch.allclose(doubled(ramp, False)[..., 2:-2], torch.arange(-0.25, 15.5, 0.5)[2:-2].expand(1, 2, 16, 28))
    ones = torch.ones(1, 2, 8, 16)
    assert torch.allclose(doubled(halved(ones, True), True), ones)


def test_coordinates_close_to_a_ring() -> None:
    turn = coordinates(RAYS)
    assert turn.shape == (32, 16, 128)
    slowest = turn[16:18]  # of the azimuth
    assert torch.allclose(slowest.square().sum(0), torch.ones(16, 128))
    step = (slowest[..., 1:] - slowest[..., :-1]).norm(dim=0)
    assert torch.allclose((slowest[..., 0] - slowest[..., -1]).norm(dim=0), step[:, 0])


def test_the_right_v_is_the_clean_state() -> None:
    clean, noise = torch.randn(2, 1, STATE_CHANNELS, 16, 128)
    sigma = torch.tensor([0.7])
    alpha = (1 + sigma**2).rsqrt()

    class Knowing(R2DM):
        def forward(self, x: torch.Tensor, log_snr: torch.Tensor, wraps: bool) -> torch.Tensor:
            assert wraps
            assert torch.allclose(x[:, :STATE_CHANNELS], alpha * (clean + sigma * noise))
            assert torch.allclose(log_snr, torch.log(alpha**2 / (alpha * sigma) ** 2))
            return alpha * noise - alpha * sigma * clean

    found = Knowing(16).denoise(clean + sigma * noise, sigma, RAYS, CONDITION, wraps=True)
    assert torch.allclose(found, clean, atol=1e-5)


def test_levels_are_those_of_the_cosine_schedule() -> None:
    ours = training_levels(1000, torch.Generator().manual_seed(0), mean=CONFIG.sigma_mean, std=CONFIG.sigma_std)
    levels = cosine_levels(ours)
    assert levels.median() == pytest.approx(1.0, rel=0.01)
    assert torch.allclose(levels.sort().values[249], torch.tensor(math.tan(math.pi / 8)), rtol=0.01)
    assert levels.max() <= math.exp(7.5) * 1.001


def test_low_noise_counts_five_times_at_most() -> None:
    class Wrong(R2DM):
        def denoise(self, *_: object, **__: object) -> torch.Tensor:
            return clean + 1

    clean = torch.ones(3, STATE_CHANNELS, 16, 128)
    sigma = torch.tensor([0.1, 1.0, 2.0])
    losses = Wrong(16).loss(clean, sigma, torch.zeros_like(clean), RAYS, CONDITION, wraps=True)
    assert torch.allclose(losses, torch.tensor([5.0, 1.0, 0.25]))


def test_its_own_size_is_about_what_is_known_of_it() -> None:
    small, large = R2DM(16), R2DM(32)
    assert 3.5 < gflop(large, SMALL) / gflop(small, SMALL) < 4
    with torch.device("meta"):
        weights = sum(weight.numel() for weight in R2DM(64).parameters())
    assert 0.85 * 31.1e6 < weights < 31.1e6
