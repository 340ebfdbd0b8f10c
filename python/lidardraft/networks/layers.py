"""Layers on range images, whose columns may form a ring: convolutions, cells of pixels folded into channels, residual
blocks; and their precision.

`wraps` is whether the columns form a ring, that is, the last column is next to the first. A full turn wraps; a crop of
one, or a sensor with a sector, does not.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional


class RangeImageConv(nn.Conv2d):
    """A convolution of odd size with `pad_columns` to the left and right, and zeros above and below the image."""

    def __init__(self, inputs: int, outputs: int, size: int = 3, *, stride: int = 1, dilation: int = 1) -> None:
        reach = dilation * (size // 2)
        super().__init__(inputs, outputs, size, stride=stride, dilation=dilation, padding=(reach, 0))
        self.reach = reach

    def forward(self, x: Tensor, wraps: bool) -> Tensor:  # type: ignore[override]
        """[B, inputs, H, W] -> [B, outputs, ceil(H / stride), ceil(W / stride)]."""
        return super().forward(pad_columns(x, self.reach, wraps))


def zero_conv(inputs: int, outputs: int) -> nn.Conv2d:
    """A 1 x 1 convolution that starts at zero."""
    conv = nn.Conv2d(inputs, outputs, 1)
    nn.init.zeros_(conv.weight)
    nn.init.zeros_(conv.bias)  # type: ignore[arg-type]
    return conv


def pad_columns(x: Tensor, columns: int, wraps: bool) -> Tensor:
    """`x` [..., W] with `columns` more on either side: those of the other end if it wraps, else the outermost repeated.

    If it wraps, more than W columns go round again.
    """
    if columns == 0:
        return x
    width = x.shape[-1]
    if columns <= width:
        padded: Tensor = _PaddedColumns.apply(x, columns, wraps)  # type: ignore[no-untyped-call]
        return padded
    places = torch.arange(-columns, width + columns, device=x.device)
    return x[..., places % width if wraps else places.clamp(0, width - 1)]


class _PaddedColumns(torch.autograd.Function):
    """`pad_columns` by at most W columns, with a gradient that costs one copy.

    Autograd's own gradient of slices and `cat` fills four whole images in another layout: as much work as a
    convolution's.
    """

    @staticmethod
    def forward(ctx: Any, x: Tensor, columns: int, wraps: bool) -> Tensor:
        """The padded tensor."""
        ctx.columns, ctx.wraps = columns, wraps
        if wraps:
            return torch.cat([x[..., -columns:], x, x[..., :columns]], dim=-1)
        return torch.cat([*columns * [x[..., :1]], x, *columns * [x[..., -1:]]], dim=-1)

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> tuple[Tensor, None, None]:
        """The gradients of each column, summed over its own place and its repeats."""
        columns = ctx.columns
        left, right = gradient[..., :columns], gradient[..., -columns:]
        total = gradient[..., columns:-columns].clone()
        if ctx.wraps:
            total[..., -columns:] += left
            total[..., :columns] += right
        else:
            total[..., 0] += left.sum(dim=-1)
            total[..., -1] += right.sum(dim=-1)
        return total, None, None


def fold(x: Tensor, cell: tuple[int, int]) -> Tensor:
    """[B, C, H, W] -> [B, C h w, H / h, W / w]: the pixels of a cell (h, w) become channels.

    Channels last in memory: the layout in which convolutions are fast, and which they pass on.
    """
    b, c, height, width = x.shape
    h, w = cell
    x = x.reshape(b, c, height // h, h, width // w, w).permute(0, 2, 4, 1, 3, 5)
    return x.reshape(b, height // h, width // w, c * h * w).permute(0, 3, 1, 2)


def unfold(x: Tensor, cell: tuple[int, int]) -> Tensor:
    """The inverse of `fold`, channels first in memory."""
    b, c, height, width = x.shape
    h, w = cell
    x = x.reshape(b, c // (h * w), h, w, height, width)
    return x.permute(0, 1, 4, 2, 5, 3).reshape(b, c // (h * w), height * h, width * w)


class ResidualBlock(nn.Module):
    """norm, SiLU, convolution, twice, with a shortcut; an `embedding` of that many channels modulates the second
    norm."""

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
    """Layers in sequence, each called with `wraps`."""

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
    """Normalisation over `groups` groups of channels, or as many as divide the width."""
    return nn.GroupNorm(math.gcd(groups, width), width)


def reduced_precision(device: torch.device) -> torch.autocast:
    """A context in which convolutions and linear layers work in bfloat16, if `device` has the instructions.

    Weights, norms' statistics and the optimiser stay float32. Code that needs more digits leaves it with its own
    `autocast(enabled=False)`.
    """
    return torch.autocast(device.type, dtype=torch.bfloat16, enabled=has_bfloat16(device))


def has_bfloat16(device: torch.device) -> bool:
    """Whether bfloat16 is faster than float32: a CPU without the instructions emulates them."""
    capabilities: dict[str, Any] = getattr(torch.cpu, "get_capabilities", dict)()  # newer torch
    return device.type == "cuda" or bool(capabilities.get("avx512_bf16") or capabilities.get("amx_bf16"))


def devices() -> list[str]:
    """The devices that torch may use here, GPUs first, with their names."""
    gpus = [f"cuda:{number} ({torch.cuda.get_device_name(number)})" for number in range(torch.cuda.device_count())]
    return [*gpus, *(["mps"] if torch.backends.mps.is_available() else []), "cpu"]
