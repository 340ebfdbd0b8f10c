"""The denoiser D(x, sigma, condition): score network and ControlNet under EDM preconditioning, and its loss."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor, nn

from lidardraft.diffusion.codec import CONDITION_PARTS, DEPTH, INTENSITY, STATE_CHANNELS, VALIDITY
from lidardraft.diffusion.controlnet import ControlNet
from lidardraft.diffusion.copy_gate import CopyGate, Mixture
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.noise import add_noise
from lidardraft.diffusion.score_network import ScoreNetwork
from lidardraft.errors import CheckpointError
from lidardraft.networks.convolution import pad_columns
from lidardraft.networks.weight_file import Network

SIGMA_DATA = 0.5  # standard deviation of a state
# Of the state's log depth: 2 % of the range, 12 % at most. Of its intensity, from -1 to 1: speckle, and another paint.
_GATED_DEPTH = {"tolerance": 0.01, "offset": 0.05}
_GATED_INTENSITY = {"tolerance": 0.08, "offset": 0.5}
_LIKELIHOOD_WEIGHT = 0.1  # of a gate's negative log likelihood, beside the squared error


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
        network = ScoreNetwork(config)
        return cls(config, network, *_controls(config, network))

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> Denoiser:
        """`from_config` of `DenoiserConfig.to_dict`."""
        return cls.from_config(DenoiserConfig.from_dict(fields))

    @property
    def cell(self) -> tuple[int, int]:
        """The (rows, columns) that images must be multiples of."""
        return self.config.cell

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
            seen.append(condition[:, self.config.beside_state])
            told.append(condition[:, self.config.in_context])
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
        small part of the loss is the negative log likelihood of the scan (`Mixture`), below 0 where they are sure.
        """
        denoised, mixtures = self._denoised(add_noise(clean, sigma, noise), sigma, rays, condition, wraps=wraps)
        returns, counts = has_return(clean), what_counts(clean)
        channels = list(denoised.chunk(STATE_CHANNELS, dim=1))
        likelihood_loss = torch.zeros_like(sigma)
        for channel, mixture in mixtures.items():
            channels[channel] = mixture.mean()
            unlikely = mixture.negative_log_likelihood(clean[:, channel : channel + 1]) * returns
            likelihood_loss = likelihood_loss + unlikely.sum(dim=(1, 2, 3)) / returns.sum(dim=(1, 2, 3)).clamp(min=1)
        error = ((torch.cat(channels, dim=1) - clean) ** 2 * counts).sum(dim=(1, 2, 3)) / counts.sum(dim=(1, 2, 3))
        return edm_weight(sigma) * error + _LIKELIHOOD_WEIGHT * likelihood_loss


def edm_weight(sigma: Tensor) -> Tensor:
    """What makes all noise levels [B] count alike (Karras et al., NeurIPS 2022, Table 1)."""
    return (sigma**2 + SIGMA_DATA**2) / (sigma * SIGMA_DATA) ** 2


def has_return(clean: Tensor) -> Tensor:
    """Where a clean state [B, 3, H, W] has a return, bool [B, 1, H, W]."""
    return clean[:, VALIDITY : VALIDITY + 1] > 0


def what_counts(clean: Tensor) -> Tensor:
    """What of a clean state is to be learned, bool [B, 3, H, W]: depth and intensity of returns, and all validity."""
    counts = has_return(clean).expand_as(clean).clone()
    counts[:, VALIDITY] = True
    return counts


def _controls(config: DenoiserConfig, network: ScoreNetwork) -> tuple[ControlNet | None, nn.ModuleDict]:
    """What a score network has beside it for its condition: a ControlNet, and the gates of the channels it gives."""
    controlnet = ControlNet(network.encoder, len(config.condition_channels)) if config.controlnet else None
    gates, width = nn.ModuleDict(), config.widths[0]
    if config.gated:
        gates["depth"] = CopyGate(width, config.cell, values=len(config.gated), **_GATED_DEPTH)
    if "simulated" in config.gated:
        gates["intensity"] = CopyGate(width, config.cell, values=1, **_GATED_INTENSITY)
    return controlnet, gates
