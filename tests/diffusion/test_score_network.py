"""The score network: shapes, the noise level, its context, and what it sees beside a crop."""

import pytest
import torch

from lidardraft.diffusion.channels import RAY_CHANNELS, STATE_CHANNELS
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.score_network import ChainedPooling, RefineBlock, ScoreNetwork
from lidardraft.networks.layers import pad_columns


def small() -> ScoreNetwork:
    """Without a condition."""
    torch.manual_seed(0)
    config = DenoiserConfig(
        cell=(2, 4), widths=(8, 16), strides=(1, 2), dilations=(1, 1), refine_units=1, pools=1, groups=8
    )
    network = ScoreNetwork(config)
    torch.nn.init.normal_(network.head.weight, std=0.1)
    return network.eval()


X = torch.randn(2, STATE_CHANNELS, 8, 64, generator=torch.Generator().manual_seed(1))
CONTEXT = torch.randn(2, RAY_CHANNELS, 8, 64, generator=torch.Generator().manual_seed(2))
LEVEL = torch.zeros(2)


@torch.no_grad()
def test_the_output_has_the_pixels_of_the_input_and_depends_on_the_noise_level() -> None:
    network = small()
    low, high = (network(X, torch.full((2,), level), CONTEXT, True) for level in (-1.0, 1.0))
    assert low.shape == (2, STATE_CHANNELS, 8, 64)
    assert not torch.allclose(low, high)


@torch.no_grad()
def test_a_ring_has_no_seam_and_a_crop_has_edges() -> None:
    network = small()
    turned, told = X.roll(16, dims=-1), CONTEXT.roll(16, dims=-1)
    ring = network(turned, LEVEL, told, True).roll(-16, dims=-1)
    torch.testing.assert_close(ring, network(X, LEVEL, CONTEXT, True), rtol=1e-4, atol=1e-5)
    crop = network(turned, LEVEL, told, False).roll(-16, dims=-1)
    assert (crop - network(X, LEVEL, CONTEXT, False)).abs().max() > 1e-3


@torch.no_grad()
def test_the_stem_sees_each_cell_and_its_context_alone() -> None:
    network = small()
    seen = []
    network.encoder.stages[0][0].register_forward_pre_hook(lambda _, inputs: seen.append(inputs[0]))
    changed, told = X.clone(), CONTEXT.clone()
    changed[:, 0, 3, 9] += 1
    told[:, -1, 3, 9] += 1
    for x, context in ((X, CONTEXT), (changed, CONTEXT), (X, told)):
        network(x, LEVEL, context, True)
    for stem in seen[1:]:
        differs = (stem != seen[0]).any(dim=1)
        assert differs[:, 1, 2].all()
        assert differs.sum() == len(X)


@torch.no_grad()
def test_bfloat16_sees_the_state_and_the_context_in_float32() -> None:
    network = small()
    seen = []
    network.encoder.stages[0][0].register_forward_pre_hook(lambda _, inputs: seen.append(inputs[0]))
    exact = network(X, LEVEL, CONTEXT, True)
    with torch.autocast("cpu", torch.bfloat16):
        rough = network(X, LEVEL, CONTEXT, True)
    assert torch.equal(*seen)
    assert 0 < (rough.float() - exact).abs().max() < 0.05 * exact.abs().max()


@torch.no_grad()
def test_control_is_added_to_the_skips_and_to_what_the_head_sees() -> None:
    network = small()
    skips = [torch.zeros_like(skip) for skip in network.encoder(X, LEVEL, CONTEXT, True)]
    nothing = [*skips, skips[0]]
    plain = network(X, LEVEL, CONTEXT, True)
    assert torch.equal(network(X, LEVEL, CONTEXT, True, nothing), plain)
    for place in range(len(nothing)):
        control = [told + 1 if place == other else told for other, told in enumerate(nothing)]
        assert not torch.allclose(network(X, LEVEL, CONTEXT, True, control), plain)


@pytest.mark.parametrize("wraps", [True, False])
def test_max_pooling_by_rows_and_columns_is_the_square_one(wraps: bool) -> None:
    torch.manual_seed(0)
    pooling, x = ChainedPooling(2, 1), torch.rand(1, 2, 7, 9)
    with torch.no_grad():
        pooling.convs[0].weight.zero_()
        pooling.convs[0].bias.zero_()
        pooling.convs[0].weight[[0, 1], [0, 1], 1, 1] = 1.0
    act = torch.nn.functional.silu(x)
    square = torch.nn.functional.max_pool2d(pad_columns(act, 2, wraps), 5, stride=1, padding=(2, 0))
    torch.testing.assert_close(pooling(x, wraps), act + square)


def test_a_refine_block_fuses_a_coarser_stage_of_any_size() -> None:
    block = RefineBlock(4, 6, 5, units=1, pools=1, groups=2)
    assert block(torch.zeros(1, 4, 8, 15), torch.zeros(1, 6, 4, 8), True).shape == (1, 5, 8, 15)
    last = RefineBlock(4, None, 5, units=2, pools=2, groups=2)
    assert last(torch.zeros(1, 4, 8, 15), None, True).shape == (1, 5, 8, 15)
