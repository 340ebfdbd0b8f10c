"""Score network, ControlNet and denoiser together."""

import dataclasses

import pytest
import torch

from lidardraft.diffusion.channels import (
    CLASS,
    CONDITION_PARTS,
    DEPTH,
    INTENSITY,
    RAY_CHANNELS,
    STATE_CHANNELS,
    VALIDITY,
)
from lidardraft.diffusion.denoiser import SIGMA_DATA, SIGMA_TURN, Denoiser, error, spread, weight
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.errors import CheckpointError

TINY = DenoiserConfig(
    cell=(2, 4),
    widths=(8, 8, 16, 16),
    strides=(1, 2, 2, 1),
    dilations=(1, 1, 1, 2),
    refine_units=1,
    pools=1,
)
CONDITIONED = dataclasses.replace(TINY, condition=("depth", "class"))
CONTROLLED = dataclasses.replace(TINY, condition=("depth", "class"), controlnet=True)
CONFIGS = pytest.mark.parametrize("config", [TINY, CONDITIONED, CONTROLLED], ids=["free", "conditioned", "controlled"])


def rays(width: int = 64) -> torch.Tensor:
    return torch.linspace(0.1, -0.8, 16)[:, None].expand(RAY_CHANNELS, -1, width)


BEAMS = rays()


@pytest.fixture(autouse=True)
def seeded() -> None:
    torch.manual_seed(0)


def shaken(denoiser: Denoiser) -> Denoiser:
    """The denoiser with every weight moved, so that nothing is zero by its start."""
    with torch.no_grad():
        for weight in denoiser.parameters():
            weight += 0.1 * torch.randn_like(weight)
    return denoiser.eval()


def a_state(batch: int = 2, width: int = 64) -> torch.Tensor:
    return torch.randn(batch, STATE_CHANNELS, 16, width)


def a_condition(batch: int = 2, width: int = 64) -> torch.Tensor:
    return torch.randn(batch, STATE_CHANNELS, 16, width)


@CONFIGS
@torch.no_grad()
def test_rolling_the_state_by_whole_cells_rolls_the_denoised(config: DenoiserConfig) -> None:
    denoiser = shaken(Denoiser.from_config(config))
    x, sigma = a_state(), torch.tensor([0.1, 2.0])
    condition = a_condition() if config.condition else None
    rolled = None if condition is None else condition.roll(16, dims=-1)
    y = denoiser.denoise(x, sigma, BEAMS, condition, wraps=True)
    torch.testing.assert_close(
        denoiser.denoise(x.roll(16, dims=-1), sigma, BEAMS, rolled, wraps=True),
        y.roll(16, dims=-1),
        atol=1e-4,
        rtol=1e-4,
    )
    assert not torch.allclose(y, y.roll(16, dims=-1), atol=1e-3)


@CONFIGS
@torch.no_grad()
def test_only_a_ring_knows_the_other_end(config: DenoiserConfig) -> None:
    """The denoised first columns of a sector do not change with its last ones, but for the norms over all pixels."""
    denoiser = shaken(Denoiser.from_config(config))
    for module in denoiser.modules():
        if isinstance(module, torch.nn.GroupNorm):
            module.forward = lambda x: x  # type: ignore[method-assign]
    x, sigma = a_state(1, 512), torch.tensor([0.5])
    changed = x.clone()
    changed[..., -8:] += 1
    condition = a_condition(1, 512) if config.condition else None
    gap = {
        wraps: (
            denoiser.denoise(x, sigma, rays(512), condition, wraps=wraps)
            - denoiser.denoise(changed, sigma, rays(512), condition, wraps=wraps)
        )
        for wraps in (True, False)
    }
    assert gap[True][..., :8].abs().max() > 1e-3
    assert not gap[False][..., :8].any()
    assert gap[False][..., -8:].any()


@torch.no_grad()
def test_the_network_knows_its_rays() -> None:
    denoiser = shaken(Denoiser.from_config(TINY))
    x, sigma = a_state(1), torch.tensor([0.5])
    assert not torch.allclose(
        denoiser.denoise(x, sigma, BEAMS, wraps=True), denoiser.denoise(x, sigma, BEAMS.flip(-2), wraps=True), atol=1e-3
    )


@CONFIGS
@torch.no_grad()
def test_a_sample_does_not_depend_on_its_batch(config: DenoiserConfig) -> None:
    denoiser = shaken(Denoiser.from_config(config))
    x, sigma = a_state(3), torch.tensor([0.1, 1.0, 9.0])
    condition = a_condition(3) if config.condition else None
    together = denoiser.denoise(x, sigma, BEAMS, condition, wraps=True)
    one = None if condition is None else condition[1:2]
    alone = denoiser.denoise(x[1:2], sigma[1:2], BEAMS, one, wraps=True)
    torch.testing.assert_close(together[1:2], alone, atol=1e-4, rtol=1e-3)


@pytest.mark.parametrize("part", CONDITION_PARTS)
@torch.no_grad()
def test_a_network_sees_the_parts_of_the_condition_that_it_names(part: str) -> None:
    denoiser = shaken(Denoiser.from_config(dataclasses.replace(CONDITIONED, condition=(part,))))
    x, sigma, condition = a_state(1), torch.tensor([0.5]), a_condition(1)
    y = denoiser.denoise(x, sigma, BEAMS, condition, wraps=True)
    for other, channels in CONDITION_PARTS.items():
        changed = condition.clone()
        changed[:, channels] = 1 - changed[:, channels]
        assert torch.equal(denoiser.denoise(x, sigma, BEAMS, changed, wraps=True), y) == (other != part)


def test_a_condition_needs_a_place_and_a_place_a_condition() -> None:
    x, sigma = a_state(), torch.ones(2)
    with pytest.raises(CheckpointError, match="a condition was given, but these weights have no place for one"):
        Denoiser.from_config(TINY).denoise(x, sigma, BEAMS, a_condition(), wraps=True)
    with pytest.raises(CheckpointError, match="these weights need a condition"):
        Denoiser.from_config(CONDITIONED).denoise(x, sigma, BEAMS, wraps=True)


@torch.no_grad()
def test_an_untrained_network_loses_the_spread_of_white_data_at_every_level() -> None:
    denoiser = Denoiser.from_config(TINY).eval()
    clean = SIGMA_DATA * a_state(4)
    clean[:, VALIDITY] = clean[:, VALIDITY].abs() + 1e-3  # every pixel has a return
    noise, sigma = torch.randn_like(clean), torch.tensor([0.02, 0.2, 1.0, 10.0])
    lost = denoiser.loss(clean, sigma, noise, BEAMS, wraps=True)
    errors = spread(sigma) * torch.randn(100_000, 4)
    square, range_error = error_of(errors, INTENSITY), error_of(errors, DEPTH)
    # ranges count 40, each of the five bits of the class 0.2
    expected = (40 * range_error + 3 * square) / 43
    torch.testing.assert_close(lost / weight(sigma), expected, rtol=0.1, atol=0)


def error_of(errors: torch.Tensor, channel: int) -> torch.Tensor:
    """The mean `error` [4] of these errors [N, 4] in a channel."""
    made = torch.zeros(*errors.shape, 1, STATE_CHANNELS).movedim(-1, 1)
    made[:, channel, :, 0] = errors
    return error(made, torch.zeros_like(made))[:, channel, :, 0].mean(0)


def test_a_large_error_of_a_range_counts_in_proportion_and_all_else_as_its_square() -> None:
    made = torch.zeros(1, STATE_CHANNELS, 1, 3)
    made[:] = torch.tensor([0.001, 1.0, 2.0])
    lost = error(made, torch.zeros_like(made))[0, :, 0]
    torch.testing.assert_close(lost[DEPTH, 0], torch.tensor(1e-6), rtol=0.01, atol=0)
    torch.testing.assert_close(lost[DEPTH, 2] / lost[DEPTH, 1], torch.tensor(2.0), rtol=0.1, atol=0)
    torch.testing.assert_close(lost[[c for c in range(STATE_CHANNELS) if c != DEPTH]], made[0, 1:, 0] ** 2)


def test_errors_weigh_as_in_karras_et_al_down_to_where_the_network_turns() -> None:
    sigma = torch.tensor([0.1, 0.5, 2.0, 20.0])
    torch.testing.assert_close(weight(sigma), (sigma**2 + SIGMA_DATA**2) / (sigma * SIGMA_DATA) ** 2, rtol=0.05, atol=0)
    assert weight(torch.tensor(0.0)) < 2 * weight(torch.tensor(SIGMA_TURN))


@torch.no_grad()
def test_dropped_pixels_do_not_count() -> None:
    denoiser = Denoiser.from_config(TINY).eval()
    clean = torch.zeros(1, STATE_CHANNELS, 16, 64)
    clean[:, VALIDITY] = 1
    clean[:, VALIDITY, :, 20:30] = -1
    noise, sigma = a_state(1), torch.tensor([0.05])
    # A network that is silent, as its head starts at zero, answers for each pixel alone.
    loss = denoiser.loss(clean, sigma, noise, BEAMS, wraps=True)
    ignored = noise.clone()
    ignored[:, [DEPTH, INTENSITY, *range(CLASS.start, CLASS.stop)], :, 20:30] += 5
    torch.testing.assert_close(denoiser.loss(clean, sigma, ignored, BEAMS, wraps=True), loss)
    counted = noise.clone()
    counted[:, VALIDITY, :, 20:30] += 10
    assert denoiser.loss(clean, sigma, counted, BEAMS, wraps=True) > loss + 0.1


def test_the_loss_of_a_crop_without_any_return_is_finite() -> None:
    clean = -torch.ones(1, STATE_CHANNELS, 16, 64)
    loss = Denoiser.from_config(TINY).loss(clean, torch.ones(1), torch.randn_like(clean), BEAMS, wraps=True)
    assert loss.isfinite().all()


def test_widths_that_no_group_divides_are_fine() -> None:
    config = dataclasses.replace(CONTROLLED, widths=(6, 10, 7, 9))
    y = Denoiser.from_config(config).denoise(a_state(1), torch.ones(1), BEAMS, a_condition(1), wraps=True)
    assert y.shape == (1, STATE_CHANNELS, 16, 64)


def test_odd_numbers_of_cells_are_fine() -> None:
    y = Denoiser.from_config(TINY).denoise(a_state(1, 60), torch.ones(1), rays(60), wraps=True)
    assert y.shape == (1, STATE_CHANNELS, 16, 60)


@pytest.mark.parametrize("config", [CONDITIONED, CONTROLLED], ids=["conditioned", "control"])
@torch.no_grad()
def test_what_is_built_on_a_base_begins_as_that_base(config: DenoiserConfig) -> None:
    base = shaken(Denoiser.from_config(TINY))
    x, sigma = a_state(), torch.tensor([0.1, 2.0])
    before = base.denoise(x, sigma, BEAMS, wraps=True)
    build = base.with_controlnet if config.controlnet else base.with_condition
    built = build(config).eval()
    assert built.config == config
    torch.testing.assert_close(built.denoise(x, sigma, BEAMS, a_condition(), wraps=True), before, atol=1e-5, rtol=1e-5)
    assert all(weight.requires_grad != config.controlnet for weight in built.network.parameters())
    heeded = shaken(built).denoise(x, sigma, BEAMS, a_condition(), wraps=True)
    assert not torch.allclose(heeded, shaken(built).denoise(x, sigma, BEAMS, a_condition().flip(-1), wraps=True))
    assert (built.base().config == TINY) == config.controlnet
