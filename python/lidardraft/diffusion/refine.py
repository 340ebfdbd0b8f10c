"""RefineNet's blocks, which bring the stages of an encoder back together (Lin et al., CVPR 2017).

What enters a SiLU is normalised, as in NCSNv2: without it the sums of the deep stages drift to where its slope is zero,
and nothing reaches them any more.
"""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional

from lidardraft.networks.convolution import RangeImageConv, pad_columns
from lidardraft.networks.residual import Chain, group_norm


class ResidualUnit(nn.Module):
    """RefineNet's residual convolution unit: norm, then SiLU and convolution, twice, on a shortcut."""

    def __init__(self, width: int, groups: int) -> None:
        super().__init__()
        self.norm = group_norm(width, groups)
        self.conv_in = RangeImageConv(width, width)
        self.conv_out = RangeImageConv(width, width)

    def forward(self, x: Tensor, wraps: bool) -> Tensor:
        """[B, width, H, W] to the same shape."""
        h = self.conv_in(functional.silu(self.norm(x)), wraps)
        return x + self.conv_out(functional.silu(h), wraps)


class ChainedPooling(nn.Module):
    """RefineNet's chained residual pooling: what stands out in the surroundings, from a chain of max pools."""

    def __init__(self, width: int, pools: int) -> None:
        super().__init__()
        self.convs = nn.ModuleList(RangeImageConv(width, width) for _ in range(pools))

    def forward(self, x: Tensor, wraps: bool) -> Tensor:
        """[B, width, H, W] to the same shape."""
        x = functional.silu(x)
        path = x
        for conv in self.convs:
            # The 5 x 5 maximum, by rows and then by columns: the same values, faster.
            path = functional.max_pool2d(pad_columns(path, 2, wraps), (1, 5), stride=1)
            path = conv(functional.max_pool2d(path, (5, 1), stride=1, padding=(2, 0)), wraps)
            x = x + path
        return x


class RefineBlock(nn.Module):
    """RefineNet's block: the skip from the encoder is adapted, fused with the path from below, pooled and smoothed.

    The path from below has just left a residual unit, so only the skip passes through new ones.
    """

    def __init__(self, skip: int, below: int | None, width: int, *, units: int, pools: int, groups: int) -> None:
        super().__init__()
        self.adapt = Chain(*(ResidualUnit(skip, groups) for _ in range(units)))
        self.fuse_skip = RangeImageConv(skip, width)
        self.fuse_below = None if below is None else RangeImageConv(below, width)
        self.norm = group_norm(width, groups)
        self.pool = ChainedPooling(width, pools)
        self.output = ResidualUnit(width, groups)

    def forward(self, skip: Tensor, below: Tensor | None, wraps: bool) -> Tensor:
        """skip [B, skip, H, W], below [B, below, h, w] of a coarser stage -> [B, width, H, W]."""
        h = self.fuse_skip(self.adapt(skip, wraps), wraps)
        if self.fuse_below is not None and below is not None:
            h = h + functional.interpolate(self.fuse_below(below, wraps), size=h.shape[-2:], mode="nearest")
        return self.output(self.pool(self.norm(h), wraps), wraps)
