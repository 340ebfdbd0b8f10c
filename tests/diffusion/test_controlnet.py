import torch

from lidardraft.diffusion.controlnet import zero_conv


def test_zero_convolutions_are_silent_and_still_learn() -> None:
    torch.manual_seed(0)
    conv, x = zero_conv(3, 4), torch.randn(1, 3, 5, 5)
    y = conv(x)
    assert not y.any()
    y.sum().backward()
    assert conv.weight.grad is not None
    assert conv.weight.grad.any()
