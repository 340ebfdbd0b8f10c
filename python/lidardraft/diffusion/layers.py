"""Layers on range images. The width is a ring; the height has an upper and a lower edge."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional


class RingConv(nn.Conv2d):
    """A convolution of odd size that wraps around in width and sees zeros beyond the first and the last row."""

    def __init__(self, inputs: int, outputs: int, size: int = 3, *, stride: int = 1, dilation: int = 1) -> None:
        reach = dilation * (size // 2)
        super().__init__(inputs, outputs, size, stride=stride, dilation=dilation, padding=(reach, 0))
        self.reach = reach

    def forward(self, x: Tensor) -> Tensor:
        """[B, inputs, H, W] -> [B, outputs, ceil(H / stride), ceil(W / stride)]."""
        return super().forward(ring_pad(x, self.reach))


def ring_pad(x: Tensor, columns: int) -> Tensor:
    """`x` [..., W] with `columns` columns of the ring's other end on either side; more than W go round again."""
    if columns == 0:
        return x
    if columns > x.shape[-1]:
        return x[..., torch.arange(-columns, x.shape[-1] + columns, device=x.device) % x.shape[-1]]
    return torch.cat([x[..., -columns:], x, x[..., :columns]], dim=-1)


def zero_conv(inputs: int, outputs: int) -> nn.Conv2d:
    """A 1 x 1 convolution that starts at zero (ControlNet, Zhang et al., ICCV 2023)."""
    conv = nn.Conv2d(inputs, outputs, 1)
    nn.init.zeros_(conv.weight)
    nn.init.zeros_(conv.bias)  # type: ignore[arg-type]
    return conv


def group_norm(width: int) -> nn.GroupNorm:
    """Normalisation over eight groups of channels, or as many as divide the width."""
    return nn.GroupNorm(math.gcd(8, width), width)


class NoiseEmbedding(nn.Module):
    """ln(sigma) / 4 as Fourier features and a small network: [B] -> [B, width]."""

    frequencies: Tensor

    def __init__(self, width: int) -> None:
        super().__init__()
        self.register_buffer("frequencies", torch.pi * torch.linspace(0.25, 8.0, width // 2), persistent=False)
        self.net = nn.Sequential(nn.Linear(width, width), nn.SiLU(), nn.Linear(width, width), nn.SiLU())

    def forward(self, level: Tensor) -> Tensor:
        """Embed c_noise [B]."""
        phase = level[:, None] * self.frequencies
        return self.net(torch.cat([phase.cos(), phase.sin()], dim=1))


class ResidualBlock(nn.Module):
    """norm, SiLU, convolution, twice, on a shortcut; the noise level scales and shifts the second norm."""

    def __init__(self, inputs: int, outputs: int, embedding: int, *, stride: int = 1, dilation: int = 1) -> None:
        super().__init__()
        self.stride = stride
        self.norm_in = group_norm(inputs)
        self.conv_in = RingConv(inputs, outputs, stride=stride, dilation=dilation)
        self.modulation = nn.Linear(embedding, 2 * outputs)
        self.norm_out = group_norm(outputs)
        self.conv_out = RingConv(outputs, outputs, dilation=dilation)
        self.shortcut = nn.Conv2d(inputs, outputs, 1) if inputs != outputs else nn.Identity()

    def forward(self, x: Tensor, embedding: Tensor) -> Tensor:
        """[B, inputs, H, W] -> [B, outputs, ceil(H / stride), ceil(W / stride)]."""
        scale, shift = self.modulation(embedding)[:, :, None, None].chunk(2, dim=1)
        h = self.conv_in(functional.silu(self.norm_in(x)))
        h = self.conv_out(functional.silu(self.norm_out(h) * (1 + scale) + shift))
        if self.stride > 1:
            x = functional.avg_pool2d(x, self.stride, ceil_mode=True, count_include_pad=False)
        return self.shortcut(x) + h


class ResidualUnit(nn.Module):
    """RefineNet's residual convolution unit (Lin et al., CVPR 2017): SiLU and convolution, twice, on a shortcut."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.conv_in = RingConv(width, width)
        self.conv_out = RingConv(width, width)

    def forward(self, x: Tensor) -> Tensor:
        """[B, width, H, W] to the same shape."""
        return x + self.conv_out(functional.silu(self.conv_in(functional.silu(x))))


class ChainedPooling(nn.Module):
    """RefineNet's chained residual pooling: what stands out in the surroundings, from a chain of max pools."""

    def __init__(self, width: int, pools: int) -> None:
        super().__init__()
        self.convs = nn.ModuleList(RingConv(width, width) for _ in range(pools))

    def forward(self, x: Tensor) -> Tensor:
        """[B, width, H, W] to the same shape."""
        x = functional.silu(x)
        path = x
        for conv in self.convs:
            # The 5 x 5 maximum, by rows and then by columns: the same values, faster.
            path = functional.max_pool2d(ring_pad(path, 2), (1, 5), stride=1)
            path = conv(functional.max_pool2d(path, (5, 1), stride=1, padding=(2, 0)))
            x = x + path
        return x


class RefineBlock(nn.Module):
    """RefineNet's block: the skip from the encoder is adapted, fused with the path from below, pooled and smoothed.

    The path from below has just left a residual unit, so only the skip passes through new ones.
    """

    def __init__(self, skip: int, below: int | None, width: int, *, units: int, pools: int) -> None:
        super().__init__()
        self.adapt = nn.Sequential(*(ResidualUnit(skip) for _ in range(units)))
        self.fuse_skip = RingConv(skip, width)
        self.fuse_below = None if below is None else RingConv(below, width)
        self.pool = ChainedPooling(width, pools)
        self.output = ResidualUnit(width)

    def forward(self, skip: Tensor, below: Tensor | None) -> Tensor:
        """skip [B, skip, H, W], below [B, below, h, w] of a coarser stage -> [B, width, H, W]."""
        h = self.fuse_skip(self.adapt(skip))
        if self.fuse_below is not None and below is not None:
            h = h + functional.interpolate(self.fuse_below(below), size=_size(h), mode="nearest")
        return self.output(self.pool(h))


def _size(x: Tensor) -> Sequence[int]:
    return x.shape[-2:]


def fold(x: Tensor, cell: tuple[int, int]) -> Tensor:
    """[B, C, H, W] -> [B, C h w, H / h, W / w]: the pixels of a cell (h, w) become channels."""
    b, c, height, width = x.shape
    h, w = cell
    x = x.reshape(b, c, height // h, h, width // w, w)
    return x.permute(0, 1, 3, 5, 2, 4).reshape(b, c * h * w, height // h, width // w)


def unfold(x: Tensor, cell: tuple[int, int]) -> Tensor:
    """The inverse of `fold`."""
    b, c, height, width = x.shape
    h, w = cell
    x = x.reshape(b, c // (h * w), h, w, height, width)
    return x.permute(0, 1, 4, 2, 5, 3).reshape(b, c // (h * w), height * h, width * w)
