"""The score network: shapes, the noise level, and what it sees beside a crop."""

import torch

from lidardraft.diffusion.score_network import ScoreNetwork
from lidardraft.networks.convolution import RangeImageConv, fold


def small(*, context: int = 0) -> ScoreNetwork:
    torch.manual_seed(0)
    sizes = {"widths": (8, 16), "strides": (1, 2), "dilations": (1, 1)}
    network = ScoreNetwork(3, 2, cell=(2, 4), blocks=1, refine_units=1, pools=1, context=context, **sizes)
    torch.nn.init.normal_(network.head.weight, std=0.1)
    return network.eval()


X = torch.randn(2, 3, 8, 64, generator=torch.Generator().manual_seed(1))


@torch.no_grad()
def test_the_output_has_the_pixels_of_the_input_and_depends_on_the_noise_level() -> None:
    network = small()
    low, high = (network(X, torch.full((2,), level), True) for level in (-1.0, 1.0))
    assert low.shape == (2, 2, 8, 64)
    assert not torch.allclose(low, high)


@torch.no_grad()
def test_a_ring_has_no_seam_and_a_crop_has_edges() -> None:
    network, level = small(), torch.zeros(2)
    turned = X.roll(16, dims=-1)
    ring = network(turned, level, True).roll(-16, dims=-1)
    torch.testing.assert_close(ring, network(X, level, True), rtol=1e-4, atol=1e-5)
    crop = network(turned, level, False).roll(-16, dims=-1)
    assert (crop - network(X, level, False)).abs().max() > 1e-3


@torch.no_grad()
def test_a_context_enters_as_the_central_cell_of_a_stem_over_both_would_let_it() -> None:
    network, level, context = small(context=5), torch.zeros(2), torch.randn(2, 5, 8, 64)
    encoder = network.encoder
    both = RangeImageConv(10 * 8, 8)
    both.weight.zero_()
    both.weight[:, : 5 * 8] = encoder.stem.weight
    both.weight[:, 5 * 8 :, 1, 1] = encoder.context.weight.flatten(1)
    both.bias.copy_(encoder.stem.bias)
    rows = BEAMS[None, :, :, None].expand(2, -1, -1, 64)
    expected = both(fold(torch.cat([X, rows, context], dim=1), (2, 4)), True)
    hint = encoder.embed(context)
    torch.testing.assert_close(encoder.stem(fold(torch.cat([X, rows], dim=1), (2, 4)), True) + hint, expected)
    plain, told = (network.features(X, level, BEAMS, True, hint=h) for h in (None, hint))
    assert not torch.allclose(plain, told)


@torch.no_grad()
def test_bfloat16_sees_the_state_and_the_context_in_float32() -> None:
    network, level, context = small(context=5), torch.zeros(2), torch.randn(2, 5, 8, 64)
    seen = []
    network.encoder.stages[0][0].register_forward_pre_hook(lambda _, inputs: seen.append(inputs[0]))
    exact = network(X, level, BEAMS, True, hint=network.encoder.embed(context))
    with torch.autocast("cpu", torch.bfloat16):
        rough = network(X, level, BEAMS, True, hint=network.encoder.embed(context))
    assert torch.equal(*seen)
    assert 0 < (rough.float() - exact).abs().max() < 0.05 * exact.abs().max()


@torch.no_grad()
def test_control_is_added_to_the_skips() -> None:
    network, level = small(), torch.zeros(2)
    nothing = [torch.zeros_like(skip) for skip in network.encoder(X, level, True)]
    plain = network(X, level, True)
    assert torch.equal(network(X, level, True, nothing), plain)
    assert not torch.allclose(network(X, level, True, [skip + 1 for skip in nothing]), plain)
