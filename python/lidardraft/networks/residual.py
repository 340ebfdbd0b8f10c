"""Residual blocks on range images, with or without an embedding that modulates them."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.networks.convolution import RangeImageConv


class ResidualBlock(nn.Module):
    """norm, SiLU, convolution, twice, on a shortcut; an `embedding` of that many channels modulates the second norm."""

    def __init__(
        self,
        inputs: int,
        outputs: int,
        stride: int = 1,
        *,
        dilation: int = 1,
        embedding: int | None = None,
        groups: int = 8,
    ) -> None:
        super().__init__()
        self.stride = stride
        self.norm_in = group_norm(inputs, groups)
        self.conv_in = RangeImageConv(inputs, outputs, stride=stride, dilation=dilation)
        self.modulation = None if embedding is None else nn.Linear(embedding, 2 * outputs)
        self.norm_out = group_norm(outputs, groups)
        self.conv_out = RangeImageConv(outputs, outputs, dilation=dilation)
        self.shortcut = nn.Conv2d(inputs, outputs, 1) if inputs != outputs else nn.Identity()

    def forward(self, x: Tensor, wraps: bool, embedding: Tensor | None = None) -> Tensor:
        """[B, inputs, H, W] -> [B, outputs, ceil(H / stride), ceil(W / stride)]; the embedding [B, channels]."""
        h = self.norm_out(self.conv_in(functional.silu(self.norm_in(x)), wraps))
        if self.modulation is not None:
            h = modulated(h, self.modulation(embedding))
        h = self.conv_out(functional.silu(h), wraps)
        if self.stride > 1:
            x = functional.avg_pool2d(x, self.stride, ceil_mode=True, count_include_pad=False)
        return self.shortcut(x) + h


class Chain(nn.Sequential):
    """Layers one after another, each of which is told whether the columns wrap."""

    def forward(self, x: Tensor, wraps: bool) -> Tensor:  # type: ignore[override]
        """[B, inputs of the first, H, W] -> the output of the last."""
        for layer in self:
            x = layer(x, wraps)
        return x


def modulated(x: Tensor, scale_and_shift: Tensor) -> Tensor:
    """x [B, C, H, W] scaled by 1 + the first half of [B, 2 C], and shifted by the second."""
    scale, shift = scale_and_shift[:, :, None, None].chunk(2, dim=1)
    return torch.addcmul(shift, x, 1 + scale)


def group_norm(width: int, groups: int = 8) -> nn.GroupNorm:
    """Normalisation over so many groups of channels, or as many as divide the width."""
    return nn.GroupNorm(math.gcd(groups, width), width)
