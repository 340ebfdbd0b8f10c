"""The score network: shapes, the noise level, its context, and what it sees beside a crop."""

import torch

from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.score_network import ScoreNetwork
from lidardraft.networks.convolution import RangeImageConv, fold


def small() -> ScoreNetwork:
    """6 channels and 4 of context to 3, without a condition."""
    torch.manual_seed(0)
    config = DenoiserConfig(
        cell=(2, 4), widths=(8, 16), strides=(1, 2), dilations=(1, 1), refine_units=1, pools=1, groups=8, condition=()
    )
    network = ScoreNetwork(config)
    torch.nn.init.normal_(network.head.weight, std=0.1)
    return network.eval()


def output(
    network: ScoreNetwork,
    x: torch.Tensor,
    level: torch.Tensor,
    context: torch.Tensor,
    wraps: bool,
    control: list[torch.Tensor] | None = None,
) -> torch.Tensor:
    return network.output(network.features(x, level, context, wraps, control), x, wraps)


X = torch.randn(2, 6, 8, 64, generator=torch.Generator().manual_seed(1))
CONTEXT = torch.randn(2, 4, 8, 64, generator=torch.Generator().manual_seed(2))
LEVEL = torch.zeros(2)


@torch.no_grad()
def test_the_output_has_the_pixels_of_the_input_and_depends_on_the_noise_level() -> None:
    network = small()
    low, high = (output(network, X, torch.full((2,), level), CONTEXT, True) for level in (-1.0, 1.0))
    assert low.shape == (2, 3, 8, 64)
    assert not torch.allclose(low, high)


@torch.no_grad()
def test_a_ring_has_no_seam_and_a_crop_has_edges() -> None:
    network = small()
    turned, told = X.roll(16, dims=-1), CONTEXT.roll(16, dims=-1)
    ring = output(network, turned, LEVEL, told, True).roll(-16, dims=-1)
    torch.testing.assert_close(ring, output(network, X, LEVEL, CONTEXT, True), rtol=1e-4, atol=1e-5)
    crop = output(network, turned, LEVEL, told, False).roll(-16, dims=-1)
    assert (crop - output(network, X, LEVEL, CONTEXT, False)).abs().max() > 1e-3


@torch.no_grad()
def test_a_context_enters_as_the_central_cell_of_a_stem_over_both_would_let_it() -> None:
    network = small()
    encoder = network.encoder
    both = RangeImageConv(10 * 8, 8)
    both.weight.zero_()
    both.weight[:, : 6 * 8] = encoder.stem.weight
    both.weight[:, 6 * 8 :, 1, 1] = encoder.context.weight.flatten(1)
    both.bias.copy_(encoder.stem.bias)
    expected = both(fold(torch.cat([X, CONTEXT], dim=1), (2, 4)), True)
    seen = []
    encoder.stages[0][0].register_forward_pre_hook(lambda _, inputs: seen.append(inputs[0]))
    encoder(X, LEVEL, CONTEXT, True)
    torch.testing.assert_close(seen[0], expected)


@torch.no_grad()
def test_bfloat16_sees_the_state_and_the_context_in_float32() -> None:
    network = small()
    seen = []
    network.encoder.stages[0][0].register_forward_pre_hook(lambda _, inputs: seen.append(inputs[0]))
    exact = output(network, X, LEVEL, CONTEXT, True)
    with torch.autocast("cpu", torch.bfloat16):
        rough = output(network, X, LEVEL, CONTEXT, True)
    assert torch.equal(*seen)
    assert 0 < (rough.float() - exact).abs().max() < 0.05 * exact.abs().max()


@torch.no_grad()
def test_control_is_added_to_the_skips() -> None:
    network = small()
    nothing = [torch.zeros_like(skip) for skip in network.encoder(X, LEVEL, CONTEXT, True)]
    plain = output(network, X, LEVEL, CONTEXT, True)
    assert torch.equal(output(network, X, LEVEL, CONTEXT, True, nothing), plain)
    assert not torch.allclose(output(network, X, LEVEL, CONTEXT, True, [skip + 1 for skip in nothing]), plain)
