"""The copy gate: where a denoised channel is what the condition gives."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.networks.convolution import RangeImageConv, fold, unfold, zero_conv

_SPREAD = 0.5  # how far a value of the state lies from a given one that is wrong: the spread of all values
_FREE_SPREAD = 0.1  # how far what the network makes of a channel lies from the truth, before it has learned
_KEEP = 2.0  # ln of how much likelier than the last given value another one must be to be decided for
_RANGE = 2.0  # how many times e a learned spread may be above or below that of the gate


@dataclass(frozen=True)
class Mixture:
    """What a channel may be at each pixel: one of the given values, or last what the network makes of it.

    `logits` say how likely each is; `values` their means and `variances` how far from these the truth
    lies; all [B, values + 1, H, W].
    """

    logits: Tensor
    values: Tensor
    variances: Tensor

    def mean(self) -> Tensor:
        """The expected value [B, 1, H, W]."""
        return (self.logits.softmax(dim=1) * self.values).sum(dim=1, keepdim=True)

    def likeliest(self) -> Tensor:
        """The value that is likeliest [B, 1, H, W]: between two surfaces there is none, nor between two paints.

        The last given value is kept where another is hardly likelier: what is left of the noise would decide there.
        """
        *others, kept, own = range(self.logits.shape[1])
        best, logits = self.values[:, kept], self.logits[:, kept] + _KEEP
        for one in (*others, own):  # argmax and gather take ten times as long
            best = torch.where(self.logits[:, one] > logits, self.values[:, one], best)
            logits = torch.maximum(logits, self.logits[:, one])
        return best[:, None]

    def negative_log_likelihood(self, truth: Tensor) -> Tensor:
        """-ln of the density at the truth [B, 1, H, W], in place of the squared error of the mean: that hardly tells
        half a metre from none, and so does not teach which of two near values holds."""
        normal = -((truth - self.values) ** 2 / self.variances + (2 * math.pi * self.variances).log()) / 2
        return -torch.logsumexp(self.logits.log_softmax(dim=1) + normal, dim=1, keepdim=True)


class CopyGate(nn.Module):
    """A channel of the state as one of the given values, or as what the network makes of it, by Bayes' rule.

    Half a metre at 20 m is 0.011 of the state: copying it through folded features is what a small network cannot do.
    With the gate it only decides which given value holds where (walls, road) and where none does (glass, crowns, gaps):
    how likely each is before the noisy pixel is seen, how closely it holds, and how far the truth lies from it.
    `tolerance` is how far that is where a given value is right, `offset` the most that the network can correct.
    """

    def __init__(self, width: int, cell: tuple[int, int], *, values: int, tolerance: float, offset: float) -> None:
        super().__init__()
        pixels = cell[0] * cell[1]
        self.cell, self.tolerance, self.offset = cell, tolerance, offset
        self.mix = RangeImageConv(width + 2 * values * pixels, width)
        self.head = zero_conv(width, (3 * values + 1) * pixels)

    def forward(
        self, denoised: Tensor, x: Tensor, sigma: Tensor, features: Tensor, given: Tensor, *, wraps: bool
    ) -> Mixture:
        """What the channel may be, for what the network makes of it [B, 1, H, W], the noisy x [B, 1, H, W], sigma
        [B, 1, 1, 1], features [B, width, h, w] and values of the state `given` [B, values, H, W]."""
        right = sigma**2 + self.tolerance**2
        distance = torch.tanh((x - given) / (2 * right.sqrt()))
        evidence = torch.tanh(_evidence(x - given, right, sigma) / 4)
        folded = fold(torch.cat([distance, evidence], dim=1), self.cell).to(features)
        h = functional.silu(self.mix(torch.cat([features, folded], dim=1), wraps))
        learned = unfold(self.head(h), self.cell).float()
        prior, tolerance, offset = learned[:, :-1].chunk(3, dim=1)
        spread, free = (_learned_variance(*of) for of in ((self.tolerance, tolerance), (_FREE_SPREAD, learned[:, -1:])))
        right = sigma**2 + spread
        value = given + self.offset * torch.tanh(offset / 4)
        logits = prior + _evidence(x - value, right, sigma)
        # A given value and the pixel, by the precision of either.
        value = value + spread / right * (x - value)
        return Mixture(
            logits=torch.cat([logits, torch.zeros_like(x)], dim=1),
            values=torch.cat([value, denoised], dim=1),
            variances=sigma**2 * torch.cat([spread / right, free / (sigma**2 + free)], dim=1),
        )


def _learned_variance(spread: float, learned: Tensor) -> Tensor:
    return (spread * torch.exp(_RANGE * torch.tanh(learned))) ** 2


def _evidence(distance: Tensor, right: Tensor, sigma: Tensor) -> Tensor:
    """ln of N(distance; 0, right) / N(distance; 0, wrong): what a pixel says for and against a value."""
    wrong = sigma**2 + _SPREAD**2
    return ((wrong / right).log() - distance**2 * (1 / right - 1 / wrong)) / 2
