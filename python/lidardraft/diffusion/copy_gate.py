"""The copy gate: where a denoised channel is what the condition gives."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.networks.convolution import RangeImageConv, fold, unfold, zero_conv

_SPREAD = 0.5  # how far a value of the state lies from a given one that is wrong: the spread of all values
_KEEP = 2.0  # ln of how much likelier than the last given value another one must be to be decided for
_TRUST_RANGE = 2.0  # how many times e the trust of a pixel may be above or below that of the gate


class CopyGate(nn.Module):
    """A channel of the state as one of the given values, or as what the network makes of it, by Bayes' rule.

    Half a metre at 20 m is 0.011 of the state: copying it through folded features is what a small network cannot do.
    With the gate it only decides which given value holds where (walls, road) and where none does (glass, crowns, gaps):
    how likely each is before the noisy pixel is seen, how closely it holds, and how far the truth lies from it.
    `trust` is how far that is where a given value is right, `offset` the most that the network can correct.
    """

    def __init__(self, width: int, cell: tuple[int, int], *, values: int, trust: float, offset: float) -> None:
        super().__init__()
        pixels = cell[0] * cell[1]
        self.cell, self.trust, self.offset = cell, trust, offset
        self.mix = RangeImageConv(width + 2 * values * pixels, width)
        self.head = zero_conv(width, 3 * values * pixels)

    def forward(
        self, denoised: Tensor, x: Tensor, sigma: Tensor, features: Tensor, given: Tensor, *, wraps: bool, decide: bool
    ) -> Tensor:
        """The channel [B, 1, H, W] for what the network makes of it, the noisy x [B, 1, H, W], sigma [B, 1, 1, 1] and
        features [B, width, h, w].

        `given` [B, values, H, W] are values of the state. The result is the mean over what the channel may be, or with
        `decide` the likeliest of it: between two surfaces there is none. The last given value is kept where another is
        hardly likelier: what is left of the noise would decide there.
        """
        right = sigma**2 + self.trust**2
        distance = torch.tanh((x - given) / (2 * right.sqrt()))
        evidence = torch.tanh(_evidence(x - given, right, sigma) / 4)
        folded = fold(torch.cat([distance, evidence], dim=1), self.cell).to(features)
        h = functional.silu(self.mix(torch.cat([features, folded], dim=1), wraps))
        prior, trust, offset = unfold(self.head(h), self.cell).float().chunk(3, dim=1)
        spread = (self.trust * torch.exp(_TRUST_RANGE * torch.tanh(trust))) ** 2
        right = sigma**2 + spread
        value = given + self.offset * torch.tanh(offset / 4)
        odds = prior + _evidence(x - value, right, sigma)
        # A given value and the pixel, by the precision of either.
        value = value + spread / right * (x - value)
        odds = torch.cat([odds, torch.zeros_like(x)], dim=1)
        value = torch.cat([value, denoised], dim=1)
        if decide:
            odds[:, -2] += _KEEP
            return value.gather(1, odds.argmax(dim=1, keepdim=True))
        return (odds.softmax(dim=1) * value).sum(dim=1, keepdim=True)


def _evidence(distance: Tensor, right: Tensor, sigma: Tensor) -> Tensor:
    """ln of N(distance; 0, right) / N(distance; 0, wrong): what a pixel says for and against a value."""
    wrong = sigma**2 + _SPREAD**2
    return ((wrong / right).log() - distance**2 * (1 / right - 1 / wrong)) / 2
