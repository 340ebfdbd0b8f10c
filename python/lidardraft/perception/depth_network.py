"""Pixels -> metric depth, by any depth network of transformers."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from lidardraft.errors import CheckpointError
from lidardraft.perception.pretrained import load_network, load_pretrained

_SATURATED = 0.95  # of the largest depth that a network knows; what is further away it does not tell


@dataclass(frozen=True, slots=True, eq=False)
class DepthNetwork:
    """A network with the processor of its pictures."""

    name: str
    network: Any
    processor: Any

    @classmethod
    def from_pretrained(cls, name: str | os.PathLike[str], *, device: str = "cpu") -> DepthNetwork:
        """That of an id or in a folder; raises `CheckpointError`, also for one whose depth has no unit."""
        processor = load_pretrained("depth network", "AutoImageProcessor", name)
        network = load_network("depth network", "AutoModelForDepthEstimation", name, device)
        if getattr(network.config, "depth_estimation_type", "metric") != "metric":
            raise CheckpointError(f"depth network {os.fspath(name)!r} gives relative depth; metric depth is needed")
        return cls(os.fspath(name), network, processor)

    @torch.inference_mode()
    def __call__(self, pixels: np.ndarray) -> np.ndarray:
        """Depth f32 [H, W] [m] of pixels u8 [H, W, 3]; 0 where it is not known, as in the sky."""
        inputs = self.processor(images=pixels, return_tensors="pt").to(self.network.device)
        outputs = self.network(**inputs)
        (found,) = self.processor.post_process_depth_estimation(outputs, target_sizes=[pixels.shape[:2]])
        depth = found["predicted_depth"].float().cpu().numpy()
        known = np.isfinite(depth) & (depth > 0)
        if largest := getattr(self.network.config, "max_depth", None):
            known &= depth < _SATURATED * largest
        return np.where(known, depth, 0).astype(np.float32)
