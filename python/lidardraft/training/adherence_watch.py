"""Does a network obey its condition? Fixed unseen streets, sampled while it learns."""

from __future__ import annotations

import itertools

import numpy as np
import torch

from lidardraft.diffusion.codec import decode_scan, encode_condition
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.sampler import sample
from lidardraft.errors import TrainingError
from lidardraft.metrics.adherence import adherence
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig, streets

OWN, OTHER = "objects", "objects of the other street"
_SEED = 2_000_000  # of streets that no training learns from
_STREETS = 2
_CALLS = 8  # of the network a scan, from noise
_DEADLINE = 1_000  # steps after which a network must heed its condition


class AdherenceWatch:
    """Two unseen streets, each sampled from the same noise.

    A scan is scored against its own condition image and against the other one: a network that ignores its condition
    makes one scan for both streets, so that both scores are equal.
    """

    def __init__(self, sensor: Sensor) -> None:
        config = StreetConfig(sensor=sensor, poses_per_street=1, simulated=True)
        pairs = list(itertools.islice(streets(_SEED, config), _STREETS))
        self.sensor = sensor
        self.condition_images = [pair.condition_image for pair in pairs]
        encoded = [encode_condition(pair.condition_image, pair.simulated) for pair in pairs if pair.simulated]
        self.condition = torch.from_numpy(np.stack(encoded))

    @torch.no_grad()
    def measure(self, denoiser: Denoiser) -> dict[str, float]:
        """Mean adherence on objects, of the scans to their own condition images and to those of the other street."""
        condition = self.condition
        *_, states = sample(
            denoiser, self.sensor, seeds=[0] * len(condition), condition=condition, steps=_CALLS, guidance=1
        )
        scans = [decode_scan(state, self.sensor) for state in states.cpu().numpy()]
        images = self.condition_images
        own = [adherence(scan, image).objects for scan, image in zip(scans, images, strict=True)]
        other = [adherence(scan, image).objects for scan, image in zip(scans, reversed(images), strict=True)]
        return {OWN: float(np.mean(np.nan_to_num(own))), OTHER: float(np.mean(np.nan_to_num(other)))}

    def check(self, measured: dict[str, float], step: int) -> None:
        """Raise `TrainingError` where the condition is still ignored after 1,000 steps: hours would be wasted."""
        if step >= _DEADLINE and not measured[OWN] > measured[OTHER]:
            raise TrainingError(
                f"the network ignores its condition after {step} steps: of its returns on objects "
                f"{measured[OWN]:.1%} agree with the layout, and {measured[OTHER]:.1%} with another one"
            )
