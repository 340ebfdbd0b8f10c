"""The copy gate: where a denoised depth is one that the condition gives."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.diffusion.codec import DEPTH
from lidardraft.networks.convolution import RangeImageConv, fold, unfold, zero_conv

_OFFSET = 0.05  # how far the copied depth may leave the given one, in the state's log depth: 12 % of the range
_TRUST = 0.01  # how far a surface lies from the given depth where that is right, likewise
_SPREAD = 0.5  # and where it is wrong: the spread of all depths


class CopyGate(nn.Module):
    """A pixel's depth as one of the given depths, or as what the network makes of it, by Bayes' rule.

    Half a metre at 20 m is 0.011 of the state: copying it through folded features is what a small network cannot do.
    With the gate it only decides which given depth holds where (walls, road) and where none does (glass, crowns, gaps):
    how likely each is before the noisy pixel is seen, how closely it holds, and how far the surface lies from it.
    """

    def __init__(self, width: int, cell: tuple[int, int], *, depths: int) -> None:
        super().__init__()
        pixels = cell[0] * cell[1]
        self.cell, self.depths = cell, depths
        self.mix = RangeImageConv(width + 2 * depths * pixels, width)
        self.head = zero_conv(width, 3 * depths * pixels)

    def forward(
        self, denoised: Tensor, x: Tensor, sigma: Tensor, features: Tensor, given: Tensor, *, wraps: bool, decide: bool
    ) -> Tensor:
        """`denoised` [B, 3, H, W] with other depths; x is noisy, sigma [B, 1, 1, 1], features [B, width, h, w].

        `given` [B, depths, H, W] are depths of the state. The result is the mean over what the depth may be, or with
        `decide` the likeliest of it: between two surfaces there is none.
        """
        noisy = x[:, DEPTH : DEPTH + 1]
        right = sigma**2 + _TRUST**2
        seen = [
            torch.tanh((noisy - given) / (2 * right.sqrt())),
            torch.tanh(_evidence(noisy - given, right, sigma) / 4),
        ]
        folded = fold(torch.cat(seen, dim=1), self.cell).to(features)
        h = functional.silu(self.mix(torch.cat([features, folded], dim=1), wraps))
        prior, trust, offset = unfold(self.head(h), self.cell).float().chunk(3, dim=1)
        spread = (_TRUST * torch.exp(2 * torch.tanh(trust))) ** 2
        right = sigma**2 + spread
        depth = given + _OFFSET * torch.tanh(offset / 4)
        odds = prior + _evidence(noisy - depth, right, sigma)
        # A given depth and the pixel, by the precision of either.
        depth = depth + spread / right * (noisy - depth)
        odds = torch.cat([odds, torch.zeros_like(noisy)], dim=1)
        depth = torch.cat([depth, denoised[:, DEPTH : DEPTH + 1]], dim=1)
        if decide:
            depth = depth.gather(1, odds.argmax(dim=1, keepdim=True))
        else:
            depth = (odds.softmax(dim=1) * depth).sum(dim=1, keepdim=True)
        return torch.cat([depth, denoised[:, DEPTH + 1 :]], dim=1)


def _evidence(distance: Tensor, right: Tensor, sigma: Tensor) -> Tensor:
    """ln of N(distance; 0, right) / N(distance; 0, wrong): what a pixel says for and against a depth."""
    wrong = sigma**2 + _SPREAD**2
    return ((wrong / right).log() - distance**2 * (1 / right - 1 / wrong)) / 2
