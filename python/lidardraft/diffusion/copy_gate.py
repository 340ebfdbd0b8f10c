"""The copy gate: where a denoised depth is one that the condition gives."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.diffusion.codec import DEPTH
from lidardraft.networks.convolution import RangeImageConv, fold, unfold, zero_conv

_OFFSET = 0.05  # how far the copied depth may leave the given one, in the state's log depth: 12 % of the range
_TRUST = 0.01  # how far a surface lies from the given depth where that is right, likewise
_SPREAD = 0.5  # and where it is wrong: the spread of all depths
_CLOSED = -1.0  # ln of the odds that a given depth is right, at the start of training


class CopyGate(nn.Module):
    """The mean of a pixel's depth if it is one of the given depths, or what the network makes of it, by Bayes' rule.

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
        self,
        denoised: Tensor,
        x: Tensor,
        sigma: Tensor,
        features: Tensor,
        given: Sequence[tuple[Tensor, Tensor]],
        wraps: bool,
    ) -> Tensor:
        """`denoised` [B, 3, H, W] with its depth moved to the given ones; x is noisy, sigma [B, 1, 1, 1], features
        [B, width, H / h, W / w].

        `given` are (depth, hit) [B, 1, H, W] of the state; where hit is not positive there is none.
        """
        noisy = x[:, DEPTH : DEPTH + 1]
        seen = []
        for depth, _ in given:
            right = sigma**2 + _TRUST**2
            seen += [
                torch.tanh((noisy - depth) / (2 * right.sqrt())),
                torch.tanh(_evidence(noisy, depth, right, sigma) / 4),
            ]
        folded = fold(torch.cat(seen, dim=1), self.cell).to(features)
        h = functional.silu(self.mix(torch.cat([features, folded], dim=1), wraps))
        said = unfold(self.head(h), self.cell).float().chunk(3 * self.depths, dim=1)
        odds, means = [torch.zeros_like(noisy)], [denoised[:, DEPTH : DEPTH + 1]]
        for k, (depth, hit) in enumerate(given):
            prior, trust, offset = said[3 * k : 3 * k + 3]
            spread = (_TRUST * torch.exp(2 * torch.tanh(trust))) ** 2
            right = sigma**2 + spread
            depth = depth + _OFFSET * torch.tanh(offset / 4)
            evidence = _evidence(noisy, depth, right, sigma)
            odds.append(torch.where(hit > 0, prior + _CLOSED + evidence, float("-inf")))
            # The given depth and the pixel, by the precision of either.
            means.append(depth + spread / right * (noisy - depth))
        weights = torch.softmax(torch.stack(odds), dim=0)
        depth = (weights * torch.stack(means)).sum(dim=0)
        return torch.cat([depth, denoised[:, DEPTH + 1 :]], dim=1)


def _evidence(noisy: Tensor, depth: Tensor, right: Tensor, sigma: Tensor) -> Tensor:
    """ln of N(noisy - depth; 0, right) / N(noisy - depth; 0, wrong): what a pixel says for and against a depth."""
    wrong = sigma**2 + _SPREAD**2
    return ((wrong / right).log() - (noisy - depth) ** 2 * (1 / right - 1 / wrong)) / 2
