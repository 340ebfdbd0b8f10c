import pytest
import torch

from lidardraft.networks.residual import Chain, ResidualBlock, group_norm


@pytest.fixture(autouse=True)
def seeded() -> None:
    torch.manual_seed(0)


def test_a_stride_rounds_odd_sizes_up() -> None:
    block = ResidualBlock(4, 6, embedding=8, stride=2)
    assert block(torch.zeros(1, 4, 5, 9), True, torch.zeros(1, 8)).shape == (1, 6, 3, 5)
    assert ResidualBlock(4, 6, stride=2)(torch.zeros(1, 4, 5, 9), True).shape == (1, 6, 3, 5)


def test_the_embedding_scales_and_shifts() -> None:
    block, x = ResidualBlock(4, 4, embedding=8), torch.randn(1, 4, 5, 9)
    assert not torch.allclose(block(x, True, torch.zeros(1, 8)), block(x, True, torch.ones(1, 8)), atol=1e-3)


@pytest.mark.parametrize("wraps", [True, False])
def test_a_chain_is_its_layers_one_after_another(wraps: bool) -> None:
    first, second, x = ResidualBlock(4, 6), ResidualBlock(6, 6, dilation=2), torch.randn(1, 4, 5, 9)
    assert torch.equal(Chain(first, second)(x, wraps), second(first(x, wraps), wraps))


def test_groups_divide_the_width() -> None:
    assert [group_norm(width).num_groups for width in (8, 12, 7)] == [8, 4, 1]
