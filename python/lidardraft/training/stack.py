"""Stacks of pairs on the device that trains on them, compact as on disk."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import torch
from torch import Tensor

from lidardraft.diffusion.codec import encode_rays, encode_scans
from lidardraft.formats.pairs import DEPTH_STEP, INTENSITY_STEP
from lidardraft.scene.sensor import Sensor


@dataclass(frozen=True, slots=True)
class PairStack:
    """Pairs of one sensor: tensors [B, H, W] by the names of `formats.pairs.IMAGES`, with the bits of uint16 in int16,
    which torch supports on every device. `rays` f32 [5, H, W] are those of `encode_rays`."""

    sensor: Sensor
    images: Mapping[str, Tensor]
    rays: Tensor

    @classmethod
    def of(cls, sensor: Sensor, images: Mapping[str, Tensor]) -> PairStack:
        """The pairs of these images; the rays are on their device."""
        return cls(sensor, images, _rays(sensor, images["scan_label"].device))

    @classmethod
    def of_rows(
        cls, sensor: Sensor, images: Mapping[str, Tensor], drawn: np.ndarray, device: torch.device
    ) -> PairStack:
        """The pairs of the drawn rows, on the device."""
        at = torch.from_numpy(drawn).to(images["scan_label"].device)
        return cls.of(sensor, {name: rows[at].to(device, non_blocking=True) for name, rows in images.items()})

    def thinned(self, every: int) -> PairStack:
        """Every `every`-th beam and column, as a sensor with only these would have them."""
        if every == 1:
            return self
        return PairStack.of(_thinned(self.sensor, every), {n: x[:, ::every, ::every] for n, x in self.images.items()})

    def mirrored(self) -> PairStack:
        """The columns in reverse order; the mirror image of staggered beams is another sensor."""
        return PairStack(self.sensor, {name: x.flip(-1) for name, x in self.images.items()}, self.rays.flip(-1))

    def states(self) -> Tensor:
        """The states of the scans, f32 [B, 8, H, W]."""
        intensity = self.images["scan_intensity"] * INTENSITY_STEP
        return encode_scans(self._depth("scan"), self.images["scan_label"], intensity, self.sensor)

    def conditions(self) -> Tensor:
        """The conditions, f32 [B, 8, H, W]: the states of the casts."""
        return encode_scans(self._depth("condition"), self.images["condition_label"], None, self.sensor)

    def _depth(self, name: str) -> Tensor:
        return (self.images[f"{name}_depth"].int() & 0xFFFF) * DEPTH_STEP  # [m]


def as_tensors(images: Mapping[str, np.ndarray]) -> dict[str, Tensor]:
    """Compact images as tensors that share their memory."""
    return {name: torch.from_numpy(x.view(np.int16) if x.dtype == np.uint16 else x) for name, x in images.items()}


@lru_cache(maxsize=64)
def _rays(sensor: Sensor, device: torch.device) -> Tensor:
    return torch.from_numpy(encode_rays(sensor)).to(device)


@lru_cache(maxsize=64)
def _thinned(sensor: Sensor, every: int) -> Sensor:
    tables: dict[str, Any] = {name: value[::every] for name, value in vars(sensor).items() if isinstance(value, tuple)}
    return dataclasses.replace(sensor, **tables, columns=math.ceil(sensor.columns / every), model=None)
