"""A rival trained alike: R2DM (Nakashima and Kurazume, ICRA 2024), with the condition beside its input.

    python benches/rival_r2dm.py --pairs FOLDER [--seconds 300] [-n 10]

Pairs, seconds and scores are those of `generator_arms.py`, whose first row stands beside it. Written from the paper's
description: an Efficient U-Net with blocks before resampling, circular in width alone; Fourier features of each ray's
angles; group norm scaled and shifted by an embedding of the log signal-to-noise ratio; attention at the coarsest
level; v-prediction on a cosine schedule, weighted by min-SNR. Ours are the state, which is not within -1 and 1 and so
is not clipped, which pixels count, the optimiser and the solver, so that calls are alike. R2DM is 64 wide: here 28.5
million weights and 185 GFLOP a call (counted in its own code, 31.1 and 229). 16 wide, or 48 on pixels folded as ours
are, it has 12.4 and 15.8 GFLOP a call.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator_arms import ARMS, CONFIG, OURS, Arm, compare
from lidardraft.diffusion.codec import STATE_CHANNELS
from lidardraft.diffusion.denoiser import what_counts
from lidardraft.diffusion.noise import add_noise
from lidardraft.networks.layers import RangeImageConv, fold, modulated, pad_columns, unfold

FREQUENCIES = 8
MULTIPLES = (1, 2, 4, 8)
BLOCKS = 3
HEADS = 8
LARGEST_LOG_SNR = 15.0
GAMMA = 5.0


class Block(nn.Module):
    """Two convolutions on a shortcut, the second norm modulated by the embedding; the sum keeps its spread."""

    def __init__(self, inputs: int, outputs: int, embedding: int) -> None:
        super().__init__()
        self.norm_in, self.norm_out = (nn.GroupNorm(min(8, width // 16), width) for width in (inputs, outputs))
        self.conv_in, self.conv_out = RangeImageConv(inputs, outputs), RangeImageConv(outputs, outputs)
        nn.init.zeros_(self.conv_out.weight)
        self.modulation = nn.Linear(embedding, 2 * outputs)
        self.shortcut = nn.Conv2d(inputs, outputs, 1) if inputs != outputs else nn.Identity()

    def forward(self, x: Tensor, embedding: Tensor, wraps: bool) -> Tensor:
        """[B, inputs, H, W] -> [B, outputs, H, W]."""
        h = self.conv_in(functional.silu(self.norm_in(x)), wraps)
        h = functional.silu(modulated(self.norm_out(h), self.modulation(embedding)))
        return (self.shortcut(x) + self.conv_out(h, wraps)) / math.sqrt(2)


class Attention(nn.Module):
    """Self-attention over all pixels, on a shortcut."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.norm = nn.GroupNorm(min(8, width // 16), width)
        self.inputs, self.output = nn.Conv2d(width, 3 * width, 1), nn.Conv2d(width, width, 1)
        nn.init.zeros_(self.output.weight)

    def forward(self, x: Tensor) -> Tensor:
        """[B, width, H, W] to the same shape."""
        b, c, height, width = x.shape
        tokens = self.inputs(self.norm(x)).reshape(b, 3, HEADS, c // HEADS, height * width).transpose(3, 4)
        q, k, v = tokens.contiguous().unbind(1)  # attention in blocks wants a token's channels beside each other
        h = functional.scaled_dot_product_attention(q, k, v).transpose(2, 3).reshape(b, c, height, width)
        return (x + self.output(h)) / math.sqrt(2)


def halved(x: Tensor, wraps: bool) -> Tensor:
    """Every second row and column, after a blur of 1, 3, 3, 1."""
    tap = torch.tensor([1.0, 3.0, 3.0, 1.0], dtype=x.dtype, device=x.device) / 8
    kernel = (tap[:, None] * tap).expand(x.shape[1], 1, 4, 4)
    padded = functional.pad(pad_columns(x, 1, wraps), (0, 0, 1, 1), mode="replicate")
    return functional.conv2d(padded, kernel, stride=2, groups=x.shape[1])


def doubled(x: Tensor, wraps: bool) -> Tensor:
    """The same blur, between twice as many rows and columns: linear interpolation."""
    height, width = x.shape[-2:]
    wide = functional.interpolate(pad_columns(x, 1, wraps), scale_factor=2, mode="bilinear", align_corners=False)
    assert wide.shape[-2:] == (2 * height, 2 * width + 4)
    return wide[..., 2:-2]


class R2DM(nn.Module):
    """The network, of a `width` at the finest level, on pixels folded by `cell`; 1 x 1 is the paper's."""

    def __init__(self, width: int, cell: tuple[int, int] = (1, 1)) -> None:
        super().__init__()
        self.width, self.cell, embedding = width, cell, 4 * width
        inputs, pixels = STATE_CHANNELS + len(OURS.condition_channels) + 4 * FREQUENCIES, cell[0] * cell[1]
        self.embed = nn.Sequential(nn.Linear(width, embedding), nn.SiLU(), nn.Linear(embedding, embedding), nn.SiLU())
        self.stem = RangeImageConv(inputs * pixels, width)
        widths = [width * multiple for multiple in MULTIPLES]
        self.down, self.up = nn.ModuleList(), nn.ModuleList()
        for finer, here in zip([width, *widths], widths, strict=False):
            self.down.append(self._level(finer, here, embedding))
            self.up.append(self._level(2 * here, finer, embedding))
        self.attention = Attention(widths[-1])
        self.norm = nn.GroupNorm(min(8, width // 16), width)
        self.head = RangeImageConv(width, STATE_CHANNELS * pixels)
        nn.init.zeros_(self.head.weight)

    @staticmethod
    def _level(inputs: int, outputs: int, embedding: int) -> nn.ModuleList:
        return nn.ModuleList(Block(inputs if i == 0 else outputs, outputs, embedding) for i in range(BLOCKS))

    def forward(self, x: Tensor, log_snr: Tensor, wraps: bool) -> Tensor:
        """v [B, 8, H, W] of all inputs [B, channels, H, W] at log_snr [B]."""
        frequencies = torch.exp(torch.linspace(0, -math.log(10_000), self.width // 2, device=x.device))
        phase = 1000 * log_snr[:, None] / LARGEST_LOG_SNR * frequencies
        embedding = self.embed(torch.cat([phase.sin(), phase.cos()], dim=1))
        with torch.autocast(x.device.type, enabled=False):  # as in `score_network`: low noise needs its digits
            h = self.stem(fold(x, self.cell), wraps)
        skips = []
        for level, blocks in enumerate(self.down):
            h = h if level == 0 else halved(h, wraps)
            for block in blocks:  # type: ignore[attr-defined]
                h = block(h, embedding, wraps)
            skips.append(h)
        h = self.attention(h)
        for level, blocks in reversed(list(enumerate(self.up))):
            h = torch.cat([h, skips[level]], dim=1)
            for block in blocks:  # type: ignore[attr-defined]
                h = block(h, embedding, wraps)
            h = h if level == 0 else doubled(h, wraps)
        return unfold(self.head(functional.silu(self.norm(h)), wraps), self.cell).float()

    def denoise(self, x: Tensor, sigma: Tensor, rays: Tensor, condition: Tensor, *, wraps: bool) -> Tensor:
        """What `Denoiser.denoise` gives."""
        # x = clean + sigma noise is the variance-preserving state over alpha, whose sigma / alpha is ours.
        noise = sigma.reshape(-1, 1, 1, 1)
        alpha = (1 + noise**2).rsqrt()
        state = alpha * x
        angles = coordinates(rays).to(x).expand(len(x), -1, -1, -1)
        v = self(torch.cat([state, angles, condition[:, OURS.condition_channels]], dim=1), -2 * sigma.log(), wraps)
        return alpha * state - alpha * noise * v

    def loss(
        self, clean: Tensor, sigma: Tensor, noise: Tensor, rays: Tensor, condition: Tensor, *, wraps: bool
    ) -> Tensor:
        """That of each sample [B], by min-SNR (Hang et al., ICCV 2023): the error of the clean state counts as much as
        its signal-to-noise ratio, 5 at most."""
        denoised = self.denoise(add_noise(clean, sigma, noise), sigma, rays, condition, wraps=wraps)
        counts = what_counts(clean)
        error = ((denoised - clean) ** 2 * counts).sum(dim=(1, 2, 3)) / counts.sum(dim=(1, 2, 3))
        return (sigma**-2).clamp(max=GAMMA) * error


def coordinates(rays: Tensor) -> Tensor:
    """Fourier features [32, H, W] of the elevation and azimuth of each ray, for rays [5, H, W] (`encode_rays`)."""
    height, width = rays.shape[-2:]
    elevation = rays[0] * math.radians(30)
    azimuth = (torch.pi * (1 - 2 * (torch.arange(width) + 0.5) / width)).expand(height, width)
    # Whole numbers of turns: the features close to a ring.
    phases = [2**k * angle for angle in (elevation, azimuth) for k in range(FREQUENCIES)]
    return torch.stack([wave(phase) for phase in phases for wave in (torch.sin, torch.cos)])


def cosine_levels(sigma: Tensor) -> Tensor:
    """sigma / alpha [B] of the cosine schedule at the times that are as rare as our noise levels are."""
    time = torch.special.ndtr((sigma.log() - CONFIG.sigma_mean) / CONFIG.sigma_std)
    largest = math.exp(LARGEST_LOG_SNR / 2)
    return torch.tan(torch.pi * time / 2).clamp(1 / largest, largest)


def r2dm_arm(width: int, cell: tuple[int, int] = (1, 1)) -> Arm:
    """R2DM of a width, by its own loss and levels."""
    return Arm(stages=(lambda _: R2DM(width, cell),), levels=cosine_levels)


RIVALS = {
    "ours": ARMS["ours"],
    "R2DM, 16 wide": r2dm_arm(16),
    "R2DM, 48 wide, folded": r2dm_arm(48, (2, 4)),
}

if __name__ == "__main__":
    compare(RIVALS, __doc__)
