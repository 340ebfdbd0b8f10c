"""What networks on range images share: convolutions that wrap, residual blocks, precision."""

import pytest
import torch

from lidardraft.networks import layers
from lidardraft.networks.layers import (
    RangeImageConv,
    ResidualBlock,
    fold,
    has_bfloat16,
    pad_columns,
    reduced_precision,
    unfold,
    zero_conv,
)


@pytest.fixture(autouse=True)
def seeded() -> None:
    torch.manual_seed(0)


@pytest.mark.parametrize("dilation", [1, 2, 4])
def test_the_convolution_of_a_ring_turns_with_it(dilation: int) -> None:
    conv, x = RangeImageConv(3, 5, dilation=dilation), torch.randn(2, 3, 8, 12)
    y = conv(x, True)
    assert y.shape == (2, 5, 8, 12)
    torch.testing.assert_close(conv(x.roll(5, dims=-1), True), y.roll(5, dims=-1))


@pytest.mark.parametrize("dilation", [1, 2, 4])
def test_the_last_column_of_a_sector_does_not_reach_the_first(dilation: int) -> None:
    conv, x = RangeImageConv(1, 1, dilation=dilation), torch.zeros(1, 1, 8, 12)
    last = x.clone()
    last[..., -1] = 1
    changed = [(conv(last, wraps) != conv(x, wraps)).any(dim=2)[0, 0] for wraps in (True, False)]
    assert changed[0][dilation - 1]
    assert not changed[1][: 12 - 1 - dilation].any()


def test_rows_do_not_wrap() -> None:
    conv, x = RangeImageConv(1, 1), torch.zeros(1, 1, 8, 12)
    bottom = x.clone()
    bottom[0, 0, -1] = 1
    changed = (conv(bottom, True) != conv(x, True)).any(dim=-1)[0, 0]
    assert changed.tolist() == [False] * 6 + [True] * 2


@pytest.mark.parametrize("columns", [0, 1, 4, 9])
def test_padding_may_be_wider_than_the_image(columns: int) -> None:
    x = torch.arange(4.0)[None]
    places = range(-columns, 4 + columns)
    assert pad_columns(x, columns, True)[0].tolist() == [i % 4 for i in places]
    assert pad_columns(x, columns, False)[0].tolist() == [min(max(i, 0), 3) for i in places]


@pytest.mark.parametrize("wraps", [True, False])
@pytest.mark.parametrize("columns", [1, 3, 5])
def test_the_gradient_of_padding_is_the_one_of_indexing(columns: int, wraps: bool) -> None:
    x = torch.randn(2, 3, 4, 5, requires_grad=True)
    places = torch.arange(-columns, 5 + columns)
    indexed = x[..., places % 5 if wraps else places.clamp(0, 4)]
    padded = pad_columns(x, columns, wraps)
    weights = torch.randn_like(indexed)
    assert torch.equal(padded, indexed)
    expected, found = (torch.autograd.grad((y * weights).sum(), x)[0] for y in (indexed, padded))
    torch.testing.assert_close(found, expected)


@pytest.mark.parametrize("wraps", [True, False])
def test_what_is_folded_stays_channels_last_through_a_convolution_and_back(wraps: bool) -> None:
    folded = fold(torch.randn(2, 3, 8, 12, requires_grad=True), (2, 4))
    y = RangeImageConv(24, 8)(folded, wraps)
    for x in (folded, pad_columns(folded, 1, wraps), pad_columns(folded, 3, wraps), y):
        assert x.is_contiguous(memory_format=torch.channels_last)
    (gradient,) = torch.autograd.grad(y.square().sum(), folded)
    assert gradient.is_contiguous(memory_format=torch.channels_last)


def test_unfold_undoes_fold() -> None:
    x = torch.randn(2, 3, 8, 12)
    folded = fold(x, (2, 4))
    assert folded.shape == (2, 24, 4, 3)
    assert torch.equal(unfold(folded, (2, 4)), x)
    assert torch.equal(fold(x.roll(4, dims=-1), (2, 4)), folded.roll(1, dims=-1))


def test_zero_convolutions_are_silent_and_still_learn() -> None:
    conv, x = zero_conv(3, 4), torch.randn(1, 3, 5, 5)
    y = conv(x)
    assert not y.any()
    y.sum().backward()
    assert conv.weight.grad is not None
    assert conv.weight.grad.any()


def test_the_embedding_scales_and_shifts() -> None:
    block, x = ResidualBlock(4, 4, embedding=8), torch.randn(1, 4, 5, 9)
    assert not torch.allclose(block(x, True, torch.zeros(1, 8)), block(x, True, torch.ones(1, 8)), atol=1e-3)


CPU = torch.device("cpu")


@pytest.mark.parametrize("capability", ["avx512_bf16", "amx_bf16"])
def test_a_cpu_with_the_instructions_works_in_bfloat16(monkeypatch: pytest.MonkeyPatch, capability: str) -> None:
    monkeypatch.setattr(layers.torch.cpu, "get_capabilities", lambda: {capability: True}, raising=False)
    assert has_bfloat16(CPU)
    with reduced_precision(CPU):
        assert torch.nn.Conv2d(2, 2, 1)(torch.zeros(1, 2, 4, 4)).dtype == torch.bfloat16


@pytest.mark.parametrize("capabilities", [{}, {"avx512_bf16": False, "avx2": True}])
def test_a_cpu_without_them_stays_in_float32(monkeypatch: pytest.MonkeyPatch, capabilities: dict[str, bool]) -> None:
    monkeypatch.setattr(layers.torch.cpu, "get_capabilities", lambda: capabilities, raising=False)
    assert not has_bfloat16(CPU)
    with reduced_precision(CPU):
        assert torch.nn.Conv2d(2, 2, 1)(torch.zeros(1, 2, 4, 4)).dtype == torch.float32
