import pytest
import torch

from lidardraft.diffusion.score_network import ChainedPooling, RefineBlock
from lidardraft.networks.convolution import pad_columns


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
    assert RefineBlock(4, None, 5, units=2, pools=2, groups=2)(torch.zeros(1, 4, 8, 15), None, True).shape == (
        1,
        5,
        8,
        15,
    )
