"""The denoiser D(x, sigma, condition): score network and ControlNet under EDM preconditioning, and its loss."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn

from lidardraft.diffusion.codec import CONDITION_PARTS, DEPTH, INTENSITY, RAY_CHANNELS, STATE_CHANNELS, VALIDITY
from lidardraft.diffusion.controlnet import ControlNet
from lidardraft.diffusion.copy_gate import CopyGate, Mixture
from lidardraft.diffusion.noise import add_noise
from lidardraft.diffusion.score_network import ScoreNetwork
from lidardraft.errors import CheckpointError, LidarDraftError
from lidardraft.networks.convolution import pad_columns
from lidardraft.networks.weight_file import Network

SIGMA_DATA = 0.5  # standard deviation of a state
# Of the state's log depth: 2 % of the range, 12 % at most. Of its intensity, from -1 to 1: speckle, and another paint.
_GATED_DEPTH = {"trust": 0.01, "offset": 0.05}
_GATED_INTENSITY = {"trust": 0.08, "offset": 0.5}
_SURPRISE = 0.1  # of the loss, what a gate's surprise counts beside the squared error


@dataclass(frozen=True, kw_only=True)
class DenoiserConfig:
    """All that decides the shape of the network.

    `cell` is the (rows, columns) of pixels that the stem folds into channels; `widths`, `strides` and `dilations` hold
    one value a stage; `blocks` residual blocks make a stage; `refine_units` and `pools` are those of a refine block;
    `groups` of channels are normalised apart: of 16 channels or a multiple each, or the gradient in bfloat16 is slow.
    `condition` names the parts of the condition that the network sees (`CONDITION_PARTS`; none: it makes scans of
    nothing), with the state, or with `controlnet` through a ControlNet as in the paper. `copy_gate` says whether
    depths and intensities among them are gated in (the paper: no).
    """

    cell: tuple[int, int]
    widths: tuple[int, ...]
    strides: tuple[int, ...]
    dilations: tuple[int, ...]
    blocks: int = 2
    refine_units: int = 1
    pools: int = 1
    groups: int = 8
    condition: tuple[str, ...] = tuple(CONDITION_PARTS)
    controlnet: bool = False
    copy_gate: bool = True

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
            raise LidarDraftError("a ControlNet needs a condition")

    @property
    def condition_channels(self) -> list[int]:
        """The channels of the condition that the network sees."""
        parts = [CONDITION_PARTS[part] for part in self.condition]
        return [channel for part in parts for channel in range(part.start, part.stop)]

    @property
    def seen(self) -> list[int]:
        """The channels of the condition that stand beside the state: those of the simulated scan, a state itself."""
        return [c for c in self.condition_channels if c >= CONDITION_PARTS["simulated"].start and not self.controlnet]

    @property
    def told(self) -> list[int]:
        """The channels of the condition in the network's context: all others."""
        return [c for c in self.condition_channels if c < CONDITION_PARTS["simulated"].start and not self.controlnet]

    @property
    def gated(self) -> tuple[str, ...]:
        """The parts of the condition whose depth is gated in."""
        return tuple(part for part in self.condition if self.copy_gate and part != "class")

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON types."""
        return {key: list(v) if isinstance(v, tuple) else v for key, v in dataclasses.asdict(self).items()}

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> DenoiserConfig:
        """The inverse of `to_dict`; raises `TypeError` on an unknown or missing field."""
        values: dict[str, Any] = {key: tuple(v) if isinstance(v, list) else v for key, v in dict(fields).items()}
        return cls(**values)


class Denoiser(Network):
    """D(x, sigma): the clean state expected behind x = clean + sigma * noise, with or without a condition."""

    SCHEMA = "lidardraft.denoiser/1"

    def __init__(
        self, config: DenoiserConfig, network: ScoreNetwork, controlnet: ControlNet | None, gates: nn.ModuleDict
    ) -> None:
        super().__init__()
        self.config: DenoiserConfig = config
        self.network = network
        self.controlnet = controlnet
        self.gates = gates

    @classmethod
    def from_config(cls, config: DenoiserConfig) -> Denoiser:
        """The only builder: fresh weights, from torch's global seed."""
        seen, told = config.seen, config.told
        network = ScoreNetwork(
            2 * STATE_CHANNELS + len(seen),
            STATE_CHANNELS,
            cell=config.cell,
            widths=config.widths,
            strides=config.strides,
            dilations=config.dilations,
            blocks=config.blocks,
            refine_units=config.refine_units,
            pools=config.pools,
            groups=config.groups,
            context=RAY_CHANNELS + len(told),
        )
        return cls(config, network, *_controls(config, network))

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> Denoiser:
        """`from_config` of `DenoiserConfig.to_dict`."""
        return cls.from_config(DenoiserConfig.from_dict(fields))

    def with_controlnet(self, config: DenoiserConfig) -> Denoiser:
        """The same network, frozen, with a fresh ControlNet of `config` that starts as a copy of its encoder."""
        denoiser = Denoiser(config, self.network, *_controls(config, self.network)).requires_grad_(True)
        self.network.requires_grad_(False)
        return denoiser

    def denoise(
        self,
        x: Tensor,
        sigma: Tensor,
        rays: Tensor,
        condition: Tensor | None = None,
        *,
        wraps: bool,
        decide: bool = False,
    ) -> Tensor:
        """D(x, sigma) for x f32 [B, 3, H, W], sigma [B], rays f32 [4, H, W] (`encode_rays`).

        `wraps` says whether the last column is the first one's neighbour (`Sensor.wraps`). `condition` is f32
        [B, K + 5, H, W] (`encode_condition`); without it the ControlNet is not called. With `decide` what may be one of
        several values is the likeliest of them in place of their mean (`CopyGate`). Preconditioned as in Karras et al.,
        NeurIPS 2022, Table 1. Raises `CheckpointError` on a condition that these weights have no place for, and without
        one that they need.
        """
        denoised, mixtures = self._denoised(x, sigma, rays, condition, wraps=wraps)
        channels = list(denoised.chunk(STATE_CHANNELS, dim=1))
        for channel, mixture in mixtures.items():
            channels[channel] = mixture.likeliest() if decide else mixture.mean()
        return torch.cat(channels, dim=1)

    def _denoised(
        self, x: Tensor, sigma: Tensor, rays: Tensor, condition: Tensor | None, *, wraps: bool
    ) -> tuple[Tensor, dict[int, Mixture]]:
        """What the network makes of the state, and of each channel that has a gate what that says."""
        level = sigma.log() / 4
        sigma = sigma.reshape(-1, 1, 1, 1)
        variance = sigma**2 + SIGMA_DATA**2
        # Low noise is a small part of the state; it shows in what sets a pixel off from its neighbours, in sigmas.
        padded = pad_columns(x, 1, wraps)
        detail = torch.tanh((x - (padded[..., :-2] + padded[..., 2:]) / 2) / (2 * sigma))
        seen, told = [x / variance.sqrt(), detail], [rays.expand(len(x), -1, -1, -1)]
        if condition is not None and not self.config.condition:
            raise CheckpointError("a condition was given, but these weights have no place for one")
        if condition is None and self.config.condition and self.controlnet is None:
            raise CheckpointError("these weights need a condition")
        if condition is not None and self.controlnet is None:
            seen.append(condition[:, self.config.seen])
            told.append(condition[:, self.config.told])
        inputs, context, control = torch.cat(seen, dim=1), torch.cat(told, dim=1), None
        if condition is not None and self.controlnet is not None:
            control = self.controlnet(inputs, level, context, wraps, condition[:, self.config.condition_channels])
        features = self.network.features(inputs, level, context, wraps, control)
        output = self.network.output(features, inputs, wraps).float()
        denoised = SIGMA_DATA**2 / variance * x + sigma * SIGMA_DATA / variance.sqrt() * output
        if condition is None or not self.gates:
            return denoised, {}
        mixtures = {}
        for name, channel, parts in (("depth", DEPTH, self.config.gated), ("intensity", INTENSITY, ("simulated",))):
            if name in self.gates:
                given = condition[:, [CONDITION_PARTS[part].start + channel for part in parts]]
                one = slice(channel, channel + 1)
                mixtures[channel] = self.gates[name](denoised[:, one], x[:, one], sigma, features, given, wraps=wraps)
        return denoised, mixtures

    def loss(
        self,
        clean: Tensor,
        sigma: Tensor,
        noise: Tensor,
        rays: Tensor,
        condition: Tensor | None = None,
        *,
        wraps: bool,
    ) -> Tensor:
        """The loss of each sample [B]: EDM's weight times the squared error of D, over the pixels that count.

        With D - x = sigma^2 S this is the paper's sigma^2 |S - target|^2, normalised to be about 1 at every noise level
        for an untrained network. Depth and intensity count only where the scan has a return. Where they have gates, a
        small part of the loss is how surprised these are by the scan (`Mixture.surprise`), below 0 where they are sure.
        """
        denoised, mixtures = self._denoised(add_noise(clean, sigma, noise), sigma, rays, condition, wraps=wraps)
        weight = (sigma**2 + SIGMA_DATA**2) / (sigma * SIGMA_DATA) ** 2
        returns = clean[:, VALIDITY : VALIDITY + 1] > 0
        counts = returns.expand_as(clean).clone()
        counts[:, VALIDITY] = True
        channels = list(denoised.chunk(STATE_CHANNELS, dim=1))
        surprise = torch.zeros_like(sigma)
        for channel, mixture in mixtures.items():
            channels[channel] = mixture.mean()
            surprised = mixture.surprise(clean[:, channel : channel + 1]) * returns
            surprise = surprise + surprised.sum(dim=(1, 2, 3)) / returns.sum(dim=(1, 2, 3)).clamp(min=1)
        error = ((torch.cat(channels, dim=1) - clean) ** 2 * counts).sum(dim=(1, 2, 3)) / counts.sum(dim=(1, 2, 3))
        return weight * error + _SURPRISE * surprise


def _controls(config: DenoiserConfig, network: ScoreNetwork) -> tuple[ControlNet | None, nn.ModuleDict]:
    """What a score network has beside it for its condition: a ControlNet, and the gates of the channels it gives."""
    controlnet = ControlNet(network.encoder, len(config.condition_channels)) if config.controlnet else None
    gates, width = nn.ModuleDict(), config.widths[0]
    if config.gated:
        gates["depth"] = CopyGate(width, config.cell, values=len(config.gated), **_GATED_DEPTH)
    if "simulated" in config.gated:
        gates["intensity"] = CopyGate(width, config.cell, values=1, **_GATED_INTENSITY)
    return controlnet, gates
