"""ControlNet: the layout enters here (Zhang et al., ICCV 2023; Sec. "Layout-guided Generation" of the paper)."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator

from torch import Tensor, nn

from lidardraft.diffusion.channels import STATE_CHANNELS
from lidardraft.diffusion.score_network import EMBEDDING, Encoder
from lidardraft.networks.layers import fold, zero_conv

_LEVEL = math.log(0.05) / 4  # the noise level given to the copy for a cast, which has no noise


class ControlNet(nn.Module):
    """A copy of the encoder that gets the layout's cast in place of the noisy scan. Through zero convolutions, it adds
    to all inputs of the decoder: the outputs of the stages, and the pixels at the head.

    A cast is a range image like a scan, in the same numbers, so the decoder knows the copy's features from the first
    step on. The features do not depend on the noise; their gain at each level does.
    """

    def __init__(self, encoder: Encoder) -> None:
        super().__init__()
        self.encoder = copy.deepcopy(encoder).requires_grad_(True)
        pixels = encoder.cell[0] * encoder.cell[1]
        self.leave = nn.ModuleList(zero_conv(width, width) for width in encoder.widths)
        self.leave.append(zero_conv(STATE_CHANNELS * pixels, encoder.widths[0]))
        gains = [nn.Linear(EMBEDDING, width) for width in (*encoder.widths, encoder.widths[0])]
        for gain in gains:
            nn.init.zeros_(gain.weight)
            nn.init.ones_(gain.bias)
        self.gain = nn.ModuleList(gains)

    def read(self, cast: Tensor, context: Tensor, wraps: bool) -> list[Tensor]:
        """The copy's features for the state of a cast [B, 8, H, W], at any noise: each stage's output, and the folded
        cast itself."""
        outputs = self.encoder(cast, cast.new_full((len(cast),), _LEVEL), context, wraps)
        return [*outputs, fold(cast, self.encoder.cell)]

    def forward(self, outputs: list[Tensor], level: Tensor) -> list[Tensor]:
        """The terms for the decoder's inputs and the head's at the noise `level` [B], from the features of `read`."""
        embedding = self.encoder.embedding(level)
        return [
            leave(h) * gain(embedding)[:, :, None, None]
            for leave, gain, h in zip(self.leave, self.gain, outputs, strict=True)
        ]

    def learn(self, *, everything: bool) -> None:
        """Make all layers trainable, or the zero convolutions alone, as at first in the paper."""
        self.requires_grad_(everything)
        for _, conv in self.zero_convs():
            conv.requires_grad_(True)

    def zero_convs(self) -> Iterator[tuple[str, nn.Conv2d]]:
        """Every layer that starts at zero, by name."""
        for stage, leave in enumerate(self.leave):
            yield f"leave.{stage}", leave  # type: ignore[misc]
