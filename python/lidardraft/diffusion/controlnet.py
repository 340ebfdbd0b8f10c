"""ControlNet: the condition enters here (Zhang et al., ICCV 2023; Sec. "Layout-guided Generation" of the paper)."""

from __future__ import annotations

import copy
from collections.abc import Iterator

from torch import Tensor, nn
from torch.nn import functional

from lidardraft.diffusion.score_network import Encoder
from lidardraft.networks.convolution import RangeImageConv, fold, zero_conv


class ControlNet(nn.Module):
    """A copy of the encoder that also sees the condition and adds to the decoder's inputs through zero convolutions."""

    def __init__(self, encoder: Encoder, channels: int) -> None:
        super().__init__()
        width, pixels = encoder.widths[0], encoder.cell[0] * encoder.cell[1]
        self.embed = nn.Conv2d(channels * pixels, width, 1)
        self.hint = RangeImageConv(width, width)
        self.enter = zero_conv(width, width)
        self.encoder = copy.deepcopy(encoder)
        self.leave = nn.ModuleList(zero_conv(width, width) for width in encoder.widths)

    def forward(self, x: Tensor, level: Tensor, context: Tensor, wraps: bool, condition: Tensor) -> list[Tensor]:
        """What to add to the decoder's inputs, for what the encoder sees and the condition [B, channels, H, W]."""
        hint = functional.silu(self.hint(functional.silu(self.embed(fold(condition, self.encoder.cell))), wraps))
        outputs = self.encoder(x, level, context, wraps, self.enter(hint))
        return [leave(h) for leave, h in zip(self.leave, outputs, strict=True)]

    def learn(self, *, everything: bool) -> None:
        """Let all layers learn, or the zero convolutions alone, as at first in the paper."""
        self.requires_grad_(everything)
        for _, conv in self.zero_convs():
            conv.requires_grad_(True)

    def zero_convs(self) -> Iterator[tuple[str, nn.Conv2d]]:
        """Every layer that starts at zero, by name."""
        yield "enter", self.enter
        for stage, leave in enumerate(self.leave):
            yield f"leave.{stage}", leave  # type: ignore[misc]
