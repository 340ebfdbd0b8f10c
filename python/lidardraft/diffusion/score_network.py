"""The score network: four residual stages down, four refine stages up, after the paper's and LiDARGen's NCSNv2.

RefineNet's blocks (Lin et al., CVPR 2017) combine the stages of the encoder. The inputs of SiLUs are normalised, as in
NCSNv2: without it the sums of the deep stages drift to a region of zero slope, and no gradient reaches them any more.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.diffusion.channels import STATE_CHANNELS
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.networks.layers import (
    Chain,
    RangeImageConv,
    ResidualBlock,
    fold,
    group_norm,
    modulated,
    pad_columns,
    unfold,
    zero_conv,
)

EMBEDDING = 64


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
    """RefineNet's chained residual pooling: salient features of the surroundings, from a chain of max pools."""

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


class Encoder(nn.Module):
    """The stem, which folds cells of pixels into channels, and the residual stages."""

    def __init__(self, config: DenoiserConfig) -> None:
        super().__init__()
        self.cell, self.widths = config.cell, config.widths
        self.embedding = NoiseEmbedding(EMBEDDING)
        inputs = self.widths[0]
        self.stem = nn.Conv2d((STATE_CHANNELS + config.context) * self.cell[0] * self.cell[1], inputs, 1)
        self.stages = nn.ModuleList()
        for width, stride, dilation in zip(self.widths, config.strides, config.dilations, strict=True):
            stage = nn.ModuleList()
            for block in range(config.blocks):
                sizes = (inputs, width, stride) if block == 0 else (width, width, 1)
                stage.append(ResidualBlock(*sizes, dilation=dilation, embedding=EMBEDDING, groups=config.groups))
            self.stages.append(stage)
            inputs = width

    def forward(self, x: Tensor, level: Tensor, context: Tensor, wraps: bool) -> list[Tensor]:
        """Each stage's output for x [B, channels, H, W] and its context [B, channels, H, W]."""
        embedding = self.embedding(level)
        # In bfloat16 the state would lose all noise below about 0.01: the stem gets it in float32 in any case.
        with torch.autocast(x.device.type, enabled=False):
            h = self.stem(fold(torch.cat([x, context], dim=1), self.cell))
        outputs = []
        for stage in self.stages:
            for block in stage:  # type: ignore[attr-defined]
                h = block(h, wraps, embedding)
            outputs.append(h)
        return outputs


class ScoreNetwork(nn.Module):
    """The network's estimate of the clean state from the preconditioned state and its noise level; no condition, no
    loss."""

    def __init__(self, config: DenoiserConfig) -> None:
        super().__init__()
        self.encoder = Encoder(config)
        self.refine = nn.ModuleList()
        below = None
        for width in reversed(config.widths):
            self.refine.append(
                RefineBlock(width, below, width, units=config.refine_units, pools=config.pools, groups=config.groups)
            )
            below = width
        width, pixels = config.widths[0], config.cell[0] * config.cell[1]
        self.norm = group_norm(width, config.groups)
        self.modulation = nn.Linear(EMBEDDING, 2 * width)
        self.gain = nn.Linear(EMBEDDING, STATE_CHANNELS * pixels)
        self.head = zero_conv(width + STATE_CHANNELS * pixels, STATE_CHANNELS * pixels)

    def forward(
        self, x: Tensor, level: Tensor, context: Tensor, wraps: bool, control: Sequence[Tensor] | None = None
    ) -> Tensor:
        """The output [B, 8, H, W] for x [B, 8, H, W] at the noise `level` [B] and its context [B, channels, H, W];
        `control` is added to the decoder's skips, stage by stage, and its last to the input of the head."""
        skips = self.encoder(x, level, context, wraps)
        if control is not None:
            skips = [skip + residual for skip, residual in zip(skips, control[:-1], strict=True)]
        h = None
        for refine, skip in zip(self.refine, reversed(skips), strict=True):
            h = refine(skip, h, wraps)
        embedding, cell = self.encoder.embedding(level), self.encoder.cell
        features = functional.silu(modulated(self.norm(h), self.modulation(embedding)))
        if control is not None:
            features = features + control[-1]
        # For the finest detail, the head gets the input again, in float32 as the stem does.
        with torch.autocast(x.device.type, enabled=False):
            seen = fold(x, cell) * self.gain(embedding.float())[:, :, None, None]
            return unfold(self.head(torch.cat([features.float(), seen], dim=1)), cell)
