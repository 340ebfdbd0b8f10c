import math

import torch

from lidardraft.diffusion.copy_gate import CopyGate, Mixture

GIVEN = torch.tensor([0.1, 0.6])[None, :, None, None].expand(1, 2, 4, 8)
FEATURES = torch.zeros(1, 8, 2, 2)


def mixture(noisy: float, sigma: float, *, prior: float = 0.0) -> Mixture:
    """What an untrained gate says of [4, 8] pixels of that value, where the network says -0.8."""
    gate = CopyGate(8, (2, 4), values=2, tolerance=0.01, offset=0.05)
    gate.head.bias.data[:16] = prior
    x, denoised = torch.full((1, 1, 4, 8), noisy), torch.full((1, 1, 4, 8), -0.8)
    with torch.no_grad():
        return gate(denoised, x, torch.full((1, 1, 1, 1), sigma), FEATURES, GIVEN, wraps=True)


def assert_all(y: torch.Tensor, value: float, tolerance: float) -> None:
    torch.testing.assert_close(y, torch.full((1, 1, 4, 8), value), atol=tolerance, rtol=0)


def test_a_pixel_near_a_given_value_takes_it() -> None:
    for given, noisy in ((0.1, 0.12), (0.6, 0.58)):
        found = mixture(noisy, 0.05, prior=5.0)
        assert_all(found.mean(), given, 0.01)
        assert_all(found.likeliest(), given, 0.01)


def test_a_pixel_far_from_all_given_values_is_what_the_network_says() -> None:
    found = mixture(-0.7, 0.05)
    assert_all(found.mean(), -0.8, 1e-4)
    assert_all(found.likeliest(), -0.8, 1e-4)


def test_of_two_values_there_is_the_mean_or_one() -> None:
    between = mixture(0.35, 1.0, prior=20.0).mean()
    assert (between > 0.2).all()
    assert (between < 0.5).all()
    assert_all(mixture(0.36, 1.0, prior=20.0).likeliest(), 0.6, 0.02)


def test_what_the_gate_says_decides_without_evidence() -> None:
    low, high = (mixture(0.35, 5.0, prior=prior).likeliest() for prior in (-20.0, 20.0))
    assert_all(low, -0.8, 1e-6)
    assert (high > 0).all()


def test_of_two_values_that_are_about_as_likely_the_last_is_kept() -> None:
    assert (mixture(0.35, 0.3, prior=5.0).likeliest() > 0.5).all()
    clearly_the_first = mixture(0.1, 0.05, prior=5.0).likeliest()
    assert (clearly_the_first < 0.2).all()


def test_the_negative_log_likelihood_is_that_of_the_density() -> None:
    found = mixture(0.35, 5.0, prior=math.log(2))
    grid = torch.linspace(-8, 8, 40_001)
    density = torch.stack(
        [torch.exp(-found.negative_log_likelihood(torch.full((1, 1, 4, 8), float(v))))[0, 0, 0, 0] for v in grid]
    )
    torch.testing.assert_close(torch.trapezoid(density, grid), torch.tensor(1.0), atol=1e-3, rtol=0)
    assert density[grid.sub(0.1).abs().argmin()] > 10 * density[grid.sub(0.3).abs().argmin()]


def test_an_estimate_is_no_surer_than_pixel_and_gate_are() -> None:
    for sigma in (0.01, 0.1, 10.0):
        found = mixture(0.3, sigma)
        assert (found.variances < sigma**2).all()
        assert (found.variances[:, :2] <= 0.01**2).all()
