"""ControlNet: the condition enters here (Zhang et al., ICCV 2023; Sec. "Layout-guided Generation" of the paper)."""

from __future__ import annotations

import copy
from collections.abc import Iterator

import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.diffusion.codec import CONDITION_CHANNELS, CONDITION_DEPTH, CONDITION_VALIDITY, DEPTH, STATE_CHANNELS
from lidardraft.diffusion.score_network import Encoder
from lidardraft.networks.convolution import RangeImageConv, fold, unfold

_OFFSET = 0.05  # how far the copied depth may leave the condition's, in the state's log depth: 12 % of the range
_TRUST = 0.01  # how far a surface lies from the condition's depth where that is right, likewise
_SPREAD = 0.5  # and where it is wrong: the spread of all depths


class ControlNet(nn.Module):
    """A copy of the encoder that also sees the condition and adds to the decoder's inputs through zero convolutions."""

    def __init__(self, encoder: Encoder, *, copy_gate: bool) -> None:
        super().__init__()
        width, pixels = encoder.widths[0], encoder.cell[0] * encoder.cell[1]
        self.embed = nn.Conv2d(CONDITION_CHANNELS * pixels, width, 1)
        self.hint = RangeImageConv(width, width)
        self.enter = zero_conv(width, width)
        self.encoder = copy.deepcopy(encoder)
        self.leave = nn.ModuleList(zero_conv(width, width) for width in encoder.widths)
        self.gate = CopyGate(width, encoder.cell) if copy_gate else None

    def forward(
        self, x: Tensor, level: Tensor, beams: Tensor, wraps: bool, condition: Tensor
    ) -> tuple[list[Tensor], Tensor]:
        """What to add to the decoder's inputs, and the hint [B, width, H / h, W / w] that the condition gives.

        x [B, channels, H, W] is what the encoder sees, level [B], beams [2, H], condition [B, K + 2, H, W].
        """
        hint = functional.silu(self.hint(functional.silu(self.embed(fold(condition, self.encoder.cell))), wraps))
        outputs = self.encoder(x, level, beams, wraps, self.enter(hint))
        return [leave(h) for leave, h in zip(self.leave, outputs, strict=True)], hint

    def zero_convs(self) -> Iterator[tuple[str, Tensor]]:
        """Name and weight of every layer that starts at zero."""
        yield "enter", self.enter.weight
        for stage, leave in enumerate(self.leave):
            yield f"leave.{stage}", leave.weight  # type: ignore[misc]
        if self.gate is not None:
            yield "gate.head", self.gate.head.weight


def zero_conv(inputs: int, outputs: int) -> nn.Conv2d:
    """A 1 x 1 convolution that starts at zero."""
    conv = nn.Conv2d(inputs, outputs, 1)
    nn.init.zeros_(conv.weight)
    nn.init.zeros_(conv.bias)  # type: ignore[arg-type]
    return conv


class CopyGate(nn.Module):
    """Where to trust the condition: depth becomes D + m (C + offset - D), C its depth, the gate m 0 at the start.

    Half a metre at 20 m is 0.011 of the state: copying it through folded features is what a small network cannot do.
    With the gate it only decides where the condition holds (walls, road) and where it does not (glass, crowns, gaps),
    and starts from what Bayes' rule says of a single pixel.
    """

    def __init__(self, width: int, cell: tuple[int, int]) -> None:
        super().__init__()
        pixels = cell[0] * cell[1]
        self.cell = cell
        self.mix = RangeImageConv(2 * width + 2 * pixels, width)
        self.head = zero_conv(width, (4 + STATE_CHANNELS) * pixels)

    def forward(
        self,
        denoised: Tensor,
        x: Tensor,
        sigma: Tensor,
        wraps: bool,
        condition: Tensor,
        features: Tensor,
        hint: Tensor,
    ) -> Tensor:
        """`denoised` [B, 3, H, W] with its depth moved towards the condition's; x is noisy, sigma [B, 1, 1, 1]."""
        target = condition[:, CONDITION_DEPTH : CONDITION_DEPTH + 1]
        hit = condition[:, CONDITION_VALIDITY : CONDITION_VALIDITY + 1] > 0
        distance = x[:, DEPTH : DEPTH + 1] - target
        right, wrong = sigma**2 + _TRUST**2, sigma**2 + _SPREAD**2
        seen = [torch.tanh(distance / (2 * right.sqrt())), torch.tanh(_evidence(distance, right, wrong) / 4)]
        folded = fold(torch.cat(seen, dim=1), self.cell).to(features)
        h = functional.silu(self.mix(torch.cat([features, hint, folded], dim=1), wraps))
        opening, prior, trust, offset, *correction = (
            unfold(self.head(h), self.cell).float().chunk(4 + STATE_CHANNELS, dim=1)
        )
        denoised = denoised + sigma * _SPREAD / wrong.sqrt() * torch.cat(correction, dim=1)
        right = sigma**2 + (_TRUST * torch.exp(2 * torch.tanh(trust))) ** 2
        # Where the condition is right, the mean of condition and pixel weighs them by the precision of either.
        gate = torch.tanh(opening) * torch.sigmoid(prior + _evidence(distance, right, wrong)) * hit * sigma**2 / right
        depth = denoised[:, DEPTH : DEPTH + 1]
        depth = depth + gate * (target + _OFFSET * torch.tanh(offset / 4) - depth)
        return torch.cat([depth, denoised[:, DEPTH + 1 :]], dim=1)


def _evidence(distance: Tensor, right: Tensor, wrong: Tensor) -> Tensor:
    """ln of N(distance; 0, right) / N(distance; 0, wrong): what a pixel says for and against the condition."""
    return ((wrong / right).log() - distance**2 * (1 / right - 1 / wrong)) / 2
