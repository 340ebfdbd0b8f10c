"""The score network: shapes, the noise level, and what it sees beside a crop."""

import torch

from lidardraft.diffusion.score_network import ScoreNetwork


def small(seed: int = 0) -> ScoreNetwork:
    torch.manual_seed(seed)
    sizes = {"widths": (8, 16), "strides": (1, 2), "dilations": (1, 1)}
    network = ScoreNetwork(3, 2, cell=(2, 4), blocks=1, refine_units=1, pools=1, **sizes)
    torch.nn.init.normal_(network.head.weight, std=0.1)
    return network.eval()


X = torch.randn(2, 3, 8, 64, generator=torch.Generator().manual_seed(1))
BEAMS = torch.linspace(-1, 1, 16).reshape(2, 8)


@torch.no_grad()
def test_the_output_has_the_pixels_of_the_input_and_depends_on_the_noise_level() -> None:
    network = small()
    low, high = (network(X, torch.full((2,), level), BEAMS, True) for level in (-1.0, 1.0))
    assert low.shape == (2, 2, 8, 64)
    assert not torch.allclose(low, high)


@torch.no_grad()
def test_a_ring_has_no_seam_and_a_crop_has_edges() -> None:
    network, level = small(), torch.zeros(2)
    turned = X.roll(16, dims=-1)
    ring = network(turned, level, BEAMS, True).roll(-16, dims=-1)
    torch.testing.assert_close(ring, network(X, level, BEAMS, True), rtol=1e-4, atol=1e-5)
    crop = network(turned, level, BEAMS, False).roll(-16, dims=-1)
    assert (crop - network(X, level, BEAMS, False)).abs().max() > 1e-3


@torch.no_grad()
def test_control_is_added_to_the_skips() -> None:
    network, level = small(), torch.zeros(2)
    nothing = [torch.zeros_like(skip) for skip in network.encoder(X, level, BEAMS, True)]
    plain = network(X, level, BEAMS, True)
    assert torch.equal(network(X, level, BEAMS, True, nothing), plain)
    assert not torch.allclose(network(X, level, BEAMS, True, [skip + 1 for skip in nothing]), plain)
