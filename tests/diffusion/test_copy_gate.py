import torch

from lidardraft.diffusion.copy_gate import CopyGate

GIVEN = torch.tensor([0.1, 0.6])[None, :, None, None].expand(1, 2, 4, 8)
FEATURES = torch.zeros(1, 8, 2, 2)


def gated(noisy: float, sigma: float, *, decide: bool, prior: float = 0.0) -> torch.Tensor:
    """The channel [4, 8] of an untrained gate for pixels of that value, where the network says -0.8."""
    gate = CopyGate(8, (2, 4), values=2, trust=0.01, offset=0.05)
    gate.head.bias.data[:16] = prior
    x, denoised = torch.full((1, 1, 4, 8), noisy), torch.full((1, 1, 4, 8), -0.8)
    with torch.no_grad():
        y = gate(denoised, x, torch.full((1, 1, 1, 1), sigma), FEATURES, GIVEN, wraps=True, decide=decide)
    return y[0, 0]


def test_a_pixel_near_a_given_value_takes_it() -> None:
    for decide in (False, True):
        for given, noisy in ((0.1, 0.12), (0.6, 0.58)):
            y = gated(noisy, 0.05, decide=decide, prior=5.0)
            torch.testing.assert_close(y, torch.full((4, 8), given), atol=0.01, rtol=0)


def test_a_pixel_far_from_all_given_values_is_what_the_network_says() -> None:
    for decide in (False, True):
        torch.testing.assert_close(gated(-0.7, 0.05, decide=decide), torch.full((4, 8), -0.8), atol=1e-4, rtol=0)


def test_of_two_values_there_is_the_mean_or_one() -> None:
    between = gated(0.35, 1.0, decide=False, prior=20.0)
    assert (between > 0.2).all()
    assert (between < 0.5).all()
    one = gated(0.36, 1.0, decide=True, prior=20.0)
    torch.testing.assert_close(one, torch.full((4, 8), 0.6), atol=0.02, rtol=0)


def test_what_the_gate_says_decides_without_evidence() -> None:
    low, high = (gated(0.35, 5.0, decide=True, prior=prior) for prior in (-20.0, 20.0))
    torch.testing.assert_close(low, torch.full((4, 8), -0.8))
    assert (high > 0).all()


def test_of_two_values_that_are_about_as_likely_the_last_is_kept() -> None:
    kept = gated(0.35, 0.3, decide=True, prior=5.0)
    assert (kept > 0.5).all()
    clearly_the_first = gated(0.1, 0.05, decide=True, prior=5.0)
    assert (clearly_the_first < 0.2).all()
