import pytest
import torch

from lidardraft.diffusion.layers import (
    ChainedPooling,
    RefineBlock,
    ResidualBlock,
    RingConv,
    fold,
    ring_pad,
    unfold,
    zero_conv,
)


@pytest.fixture(autouse=True)
def seeded() -> None:
    torch.manual_seed(0)


@pytest.mark.parametrize("dilation", [1, 2, 4])
def test_ring_convolution_wraps_around_in_width(dilation: int) -> None:
    conv, x = RingConv(3, 5, dilation=dilation), torch.randn(2, 3, 8, 12)
    y = conv(x)
    assert y.shape == (2, 5, 8, 12)
    torch.testing.assert_close(conv(x.roll(5, dims=-1)), y.roll(5, dims=-1))


def test_ring_convolution_does_not_wrap_around_in_height() -> None:
    conv, x = RingConv(1, 1), torch.zeros(1, 1, 8, 12)
    bottom = x.clone()
    bottom[0, 0, -1] = 1
    changed = (conv(bottom) != conv(x)).any(dim=-1)[0, 0]
    assert changed.tolist() == [False] * 6 + [True] * 2


def test_a_stride_rounds_odd_sizes_up() -> None:
    assert RingConv(1, 1, stride=2)(torch.zeros(1, 1, 5, 9)).shape == (1, 1, 3, 5)
    block = ResidualBlock(4, 6, 8, stride=2)
    assert block(torch.zeros(1, 4, 5, 9), torch.zeros(1, 8)).shape == (1, 6, 3, 5)


@pytest.mark.parametrize("columns", [0, 1, 4, 9])
def test_ring_padding_may_go_round_more_than_once(columns: int) -> None:
    x = torch.arange(4.0)[None]
    expected = [i % 4 for i in range(-columns, 4 + columns)]
    assert ring_pad(x, columns)[0].tolist() == expected


def test_max_pooling_by_rows_and_columns_is_the_square_one() -> None:
    pooling, x = ChainedPooling(2, 1), torch.rand(1, 2, 7, 9)
    with torch.no_grad():
        pooling.convs[0].weight.zero_()
        pooling.convs[0].bias.zero_()
        pooling.convs[0].weight[[0, 1], [0, 1], 1, 1] = 1.0
    act = torch.nn.functional.silu(x)
    square = torch.nn.functional.max_pool2d(ring_pad(act, 2), 5, stride=1, padding=(2, 0))
    torch.testing.assert_close(pooling(x), act + square)


def test_a_refine_block_fuses_a_coarser_stage_of_any_size() -> None:
    block = RefineBlock(4, 6, 5, units=1, pools=1)
    assert block(torch.zeros(1, 4, 8, 15), torch.zeros(1, 6, 4, 8)).shape == (1, 5, 8, 15)
    assert RefineBlock(4, None, 5, units=2, pools=2)(torch.zeros(1, 4, 8, 15), None).shape == (1, 5, 8, 15)


def test_zero_convolutions_are_silent_and_still_learn() -> None:
    conv, x = zero_conv(3, 4), torch.randn(1, 3, 5, 5)
    y = conv(x)
    assert not y.any()
    y.sum().backward()
    assert conv.weight.grad is not None
    assert conv.weight.grad.any()


def test_unfold_undoes_fold() -> None:
    x = torch.randn(2, 3, 8, 12)
    folded = fold(x, (2, 4))
    assert folded.shape == (2, 24, 4, 3)
    assert torch.equal(unfold(folded, (2, 4)), x)
    assert torch.equal(fold(x.roll(4, dims=-1), (2, 4)), folded.roll(1, dims=-1))
