"""Pixels and classes -> numbered objects, by networks of transformers that cut out whatever lies under a point (SAM).

Masks have no class: each takes the one that most of its pixels have, as in the Semantic Segment Anything project
(Chen et al., 2023). So things that touch are told apart, and their outlines are those of the masks.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from lidardraft.perception.mask_votes import THINGS, number_objects
from lidardraft.perception.pretrained import load_network, load_pretrained

_KIND = "mask network"
# Estimates of ours, but for the score, which is a little less than that of SAM's own generator of masks.
_SPACING = 16  # pixels between points that are asked for
_MOST_POINTS = 128
_POINTS_AT_ONCE = 16
_SCORE = 0.8  # a network's own estimate of how right a mask is


@dataclass(frozen=True, slots=True, eq=False)
class MaskNetwork:
    """A network with the processor of its pictures and points."""

    name: str
    network: Any
    processor: Any

    @classmethod
    def from_pretrained(cls, name: str | os.PathLike[str], *, device: str = "cpu") -> MaskNetwork:
        """That of an id or in a folder; raises `CheckpointError`."""
        processor = load_pretrained(_KIND, "AutoProcessor", name)
        return cls(os.fspath(name), load_network(_KIND, "AutoModelForMaskGeneration", name, device), processor)

    def __call__(self, pixels: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Class ids u8 [H, W] and numbers of objects u32 [H, W] of pixels u8 [H, W, 3] with class ids [H, W]."""
        points = _points_on_things(labels)
        masks, scores = (
            self._masks(pixels, points) if len(points) else (np.zeros((0, *labels.shape), bool), np.zeros(0))
        )
        return number_objects(labels, masks[np.argsort(-scores, kind="stable")])

    @torch.inference_mode()
    def _masks(self, pixels: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The best mask of each point, bool [M, H, W], with its score [M]; without those of a low score."""
        masks, scores = [], []
        embeddings = None
        for first in range(0, len(points), _POINTS_AT_ONCE):
            asked = [[[point] for point in points[first : first + _POINTS_AT_ONCE].tolist()]]
            inputs = self.processor(images=pixels, input_points=asked, return_tensors="pt").to(self.network.device)
            picture = inputs.pop("pixel_values")
            if embeddings is None:
                embeddings = self.network.get_image_embeddings(picture)
            sizes = [inputs.pop("original_sizes")]
            if "reshaped_input_sizes" in inputs:  # of SAM, not of its successors
                sizes.append(inputs.pop("reshaped_input_sizes"))
            outputs = self.network(image_embeddings=embeddings, **inputs)
            (found,) = self.processor.post_process_masks(outputs.pred_masks.cpu(), *sizes)
            score, best = outputs.iou_scores[0].cpu().max(dim=-1)
            kept = score >= _SCORE
            masks.append(found[torch.arange(len(best)), best][kept].bool().numpy())
            scores.append(score[kept].numpy())
        return np.concatenate(masks), np.concatenate(scores)


def _points_on_things(labels: np.ndarray) -> np.ndarray:
    """Places [M, 2] (column, row) on things, on a grid, which is wider where there would be too many."""
    spacing = _SPACING
    while True:
        half = spacing // 2
        rows, columns = np.nonzero(THINGS[labels[half::spacing, half::spacing]])
        if len(rows) <= _MOST_POINTS:
            return np.column_stack([columns, rows]) * spacing + half
        spacing *= 2
