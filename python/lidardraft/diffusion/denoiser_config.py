"""The shape of a denoiser, and its defaults for sampling; all without torch."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lidardraft.diffusion.channels import CONDITION_PARTS, RAY_CHANNELS
from lidardraft.errors import LidarDraftError

# Defaults of sampling for weight files that store none.
STEPS = 20  # calls of the network, two each with guidance of a ControlNet
GUIDANCE = 2.0  # the factor of a ControlNet's change of its base
LAST_NOISE = 1.0  # the noise level of the last call


@dataclass(frozen=True, kw_only=True)
class DenoiserConfig:
    """All parameters of the shape of the network.

    `cell` is the (rows, columns) of pixels that the stem folds into channels; `widths`, `strides` and `dilations` hold
    one value a stage; `blocks` residual blocks make a stage; `refine_units` and `pools` are those of a refine block.
    `groups` of channels are normalised apart: each should have 16 channels or a multiple, else the gradient in bfloat16
    is slow. `condition` names the parts of the condition that the network gets (`CONDITION_PARTS`; none for
    unconditional scans), beside the state, or with `controlnet` through a ControlNet as in the paper. Defaults are of
    `recipes.paper_small`.
    """

    cell: tuple[int, int]
    widths: tuple[int, ...]
    strides: tuple[int, ...]
    dilations: tuple[int, ...]
    blocks: int = 1
    refine_units: int = 1
    pools: int = 0
    groups: int = 4
    condition: tuple[str, ...] = ()
    controlnet: bool = False

    def __post_init__(self) -> None:
        for name in ("cell", "widths", "strides", "dilations"):
            values = getattr(self, name)
            if not isinstance(values, tuple) or not all(isinstance(v, int) and 1 <= v <= 4096 for v in values):
                raise LidarDraftError(f"{name} is {values!r}; it must be whole numbers from 1 to 4096")
        if len(self.cell) != 2:
            raise LidarDraftError(f"cell is {self.cell}; it must be (rows, columns)")
        if not self.widths or not len(self.widths) == len(self.strides) == len(self.dilations):
            raise LidarDraftError(
                f"widths {self.widths}, strides {self.strides} and dilations {self.dilations} must match"
            )
        for name, low in (("blocks", 1), ("refine_units", 0), ("pools", 0), ("groups", 1)):
            if not isinstance(getattr(self, name), int) or not low <= getattr(self, name) <= 64:
                raise LidarDraftError(f"{name} is {getattr(self, name)!r}; it must be {low} to 64")
        if self.condition != tuple(part for part in CONDITION_PARTS if part in self.condition):
            known = ", ".join(CONDITION_PARTS)
            raise LidarDraftError(f"condition is {self.condition}; it must be some of {known}, in this order")
        if self.controlnet and not self.condition:
            raise LidarDraftError("condition is empty; a ControlNet sees depth, class or both")

    @property
    def context(self) -> int:
        """The number of input channels beside the state: the rays, and the condition unless a ControlNet takes it."""
        return RAY_CHANNELS + (0 if self.controlnet else len(self.condition_channels))

    @property
    def condition_channels(self) -> list[int]:
        """The channels of the condition that the network gets."""
        return [channel for part in self.condition for channel in CONDITION_PARTS[part]]

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON types."""
        return {key: list(v) if isinstance(v, tuple) else v for key, v in dataclasses.asdict(self).items()}

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> DenoiserConfig:
        """The inverse of `to_dict`; raises `TypeError` on an unknown or missing field."""
        values: dict[str, Any] = {key: tuple(v) if isinstance(v, list) else v for key, v in dict(fields).items()}
        return cls(**values)
