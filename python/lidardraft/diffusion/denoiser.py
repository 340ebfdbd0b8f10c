"""The denoiser D(x, sigma, condition): score network and ControlNet under preconditioning, and its loss."""

from __future__ import annotations

import dataclasses
from typing import Any

import torch
from torch import Tensor

from lidardraft.diffusion.channels import CLASS, DEPTH, VALIDITY
from lidardraft.diffusion.controlnet import ControlNet
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.noise import add_noise
from lidardraft.diffusion.score_network import ScoreNetwork
from lidardraft.errors import CheckpointError
from lidardraft.networks.weight_file import Network

SIGMA_DATA = 0.5  # standard deviation of a state
# The noise level above which the network predicts the scan, and below which it predicts the noise. Karras et al. have
# SIGMA_DATA here; but folded pixels leave no room for their noise, while a scan is smooth (Li and He, Back to Basics,
# 2025), and a decoder that renders scans can be conditioned. 0.02 is 1.7 % of the range.
SIGMA_TURN = 0.02
_DEPTH_WEIGHT, _CLASS_WEIGHT = 40.0, 0.2  # in the loss; validity and intensity count 1
# The error of a range, 9 % of it, above which the loss grows linearly. Squared, the errors at edges, which nobody can
# predict to the pixel, would outweigh all precision elsewhere.
_DEPTH_BEND = 0.1


class Denoiser(Network):
    """D(x, sigma): the expected clean state for x = clean + sigma * noise, with or without a condition.

    The network under a ControlNet is frozen.
    """

    SCHEMA = "lidardraft.denoiser/2"

    def __init__(self, config: DenoiserConfig, network: ScoreNetwork, controlnet: ControlNet | None) -> None:
        super().__init__()
        self.config: DenoiserConfig = config
        self.network = network.requires_grad_(controlnet is None)
        self.controlnet = controlnet

    @classmethod
    def from_config(cls, config: DenoiserConfig) -> Denoiser:
        """The only builder: fresh weights, from torch's global seed."""
        network = ScoreNetwork(config)
        return cls(config, network, _controlnet(config, network))

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> Denoiser:
        """`from_config` of `DenoiserConfig.to_dict`."""
        return cls.from_config(DenoiserConfig.from_dict(fields))

    @property
    def cell(self) -> tuple[int, int]:
        """The (rows, columns) of a cell: images must be multiples of it."""
        return self.config.cell

    def base(self) -> Denoiser:
        """The same network without its ControlNet, if it has one."""
        if self.controlnet is None:
            return self
        return Denoiser(dataclasses.replace(self.config, condition=(), controlnet=False), self.network, None)

    def with_controlnet(self, config: DenoiserConfig) -> Denoiser:
        """The same network, frozen, with a fresh ControlNet of `config` that starts as a copy of its encoder."""
        return Denoiser(config, self.network, _controlnet(config, self.network))

    def with_condition(self, config: DenoiserConfig) -> Denoiser:
        """A network of `config`, with a condition beside the state, which at first ignores the condition."""
        denoiser = Denoiser.from_config(config)
        weights = self.state_dict()
        stem = denoiser.network.encoder.stem.weight.detach().zero_()
        stem[:, : self.network.encoder.stem.in_channels] = weights.pop("network.encoder.stem.weight")
        denoiser.load_state_dict(weights, strict=False)
        return denoiser

    def read(self, condition: Tensor, rays: Tensor, *, wraps: bool) -> list[Tensor] | None:
        """The ControlNet's features for a condition [B, 8, H, W] at any noise, for all calls of a sample; None without
        a ControlNet."""
        if self.controlnet is None:
            return None
        cast = torch.zeros_like(condition)
        cast[:, self.config.condition_channels] = condition[:, self.config.condition_channels] / SIGMA_DATA
        return self.controlnet.read(cast, rays.expand(len(cast), -1, -1, -1), wraps)

    def denoise(
        self,
        x: Tensor,
        sigma: Tensor,
        rays: Tensor,
        condition: Tensor | None = None,
        *,
        wraps: bool,
        reading: list[Tensor] | None = None,
    ) -> Tensor:
        """D(x, sigma) for x f32 [B, 8, H, W], sigma [B], rays f32 [5, H, W] (`encode_rays`).

        `wraps` is whether the last column is next to the first (`Sensor.wraps`). `condition` is f32 [B, 8, H, W],
        the states of casts, `reading` the result of `read` for it, if known; without a condition the ControlNet is not
        called. Raises `CheckpointError` on a condition that these weights do not take, and without one that they need.
        """
        level, sigma = sigma.log() / 4, sigma.reshape(-1, 1, 1, 1)
        inputs = x / (sigma**2 + SIGMA_DATA**2).sqrt()
        context = rays.expand(len(x), -1, -1, -1)
        if condition is not None and not self.config.condition:
            raise CheckpointError("a condition was given, but these weights have no place for one")
        if condition is None and self.config.condition and self.controlnet is None:
            raise CheckpointError("these weights need a condition")
        control = None
        if condition is not None and self.controlnet is not None:
            control = self.controlnet(reading or self.read(condition, rays, wraps=wraps), level)
        elif condition is not None:
            context = torch.cat([context, condition[:, self.config.condition_channels]], dim=1)
        output = self.network(inputs, level, context, wraps, control).float()
        skip = SIGMA_TURN**2 / (sigma**2 + SIGMA_TURN**2)
        return skip * x + spread(sigma) * output

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
        """The loss of each sample [B]: the `error` of D over the pixels that count, as `weight` weights it.

        With D - x = sigma^2 S this is about the paper's `sigma^2 |S - target|^2` at low noise. Range, intensity and
        class count only in pixels with a return.
        """
        counts = what_counts(clean)
        denoised = self.denoise(add_noise(clean, sigma, noise), sigma, rays, condition, wraps=wraps)
        lost = (error(denoised, clean) * counts).sum(dim=(1, 2, 3)) / counts.sum(dim=(1, 2, 3)).clamp(min=1)
        return weight(sigma) * lost


def spread(sigma: Tensor) -> Tensor:
    """The spread of clean states around SIGMA_TURN's share of the noisy one, at each noise level."""
    skip = SIGMA_TURN**2 / (sigma**2 + SIGMA_TURN**2)
    return (((1 - skip) * SIGMA_DATA) ** 2 + (skip * sigma) ** 2).sqrt()


def weight(sigma: Tensor) -> Tensor:
    """The weight of an error at each noise level: 1 / sigma^2 + 1 / SIGMA_DATA^2 (Karras et al.), constant below
    SIGMA_TURN."""
    return 1 / (sigma**2 + SIGMA_TURN**2) + 1 / SIGMA_DATA**2


def error(denoised: Tensor, clean: Tensor) -> Tensor:
    """The error of each number of states [B, 8, H, W]: its square; for large errors of ranges, the pseudo-Huber loss
    (Charbonnier et al., 1997), as in Song and Dhariwal (ICLR 2024) for diffusion."""
    square = (denoised - clean) ** 2
    ranges = 2 * _DEPTH_BEND * ((square[:, DEPTH : DEPTH + 1] + _DEPTH_BEND**2).sqrt() - _DEPTH_BEND)
    return torch.cat([square[:, :DEPTH], ranges, square[:, DEPTH + 1 :]], dim=1)


def has_return(clean: Tensor) -> Tensor:
    """bool [B, 1, H, W]: True for the pixels of a clean state [B, 8, H, W] with a return."""
    return clean[:, VALIDITY : VALIDITY + 1] > 0


def what_counts(clean: Tensor) -> Tensor:
    """The weights of a clean state in the loss, f32 [B, 8, H, W]: all of validity, and the rest for returns."""
    counts = has_return(clean).expand_as(clean).float()
    counts[:, DEPTH] *= _DEPTH_WEIGHT
    counts[:, CLASS] *= _CLASS_WEIGHT
    counts[:, VALIDITY] = 1.0
    return counts


def _controlnet(config: DenoiserConfig, network: ScoreNetwork) -> ControlNet | None:
    return ControlNet(network.encoder) if config.controlnet else None
