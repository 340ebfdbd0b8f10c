"""Pixels -> classes, by any network of transformers for semantic or universal segmentation."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from lidardraft.errors import CheckpointError
from lidardraft.formats.cityscapes import CLASS_FROM_TRAIN_ID
from lidardraft.perception.pretrained import auto_class, load_network, load_pretrained
from lidardraft.scene.class_names import class_of
from lidardraft.semantics import BY_NAME

_KIND = "semantic network"


@dataclass(frozen=True, slots=True, eq=False)
class SemanticNetwork:
    """A network with the processor of its pictures; `classes` u8 [L] holds the class id of each of its labels."""

    name: str
    network: Any
    processor: Any
    classes: np.ndarray

    @classmethod
    def from_pretrained(cls, name: str | os.PathLike[str], *, device: str = "cpu") -> SemanticNetwork:
        """That of an id or in a folder; raises `CheckpointError`, also for one whose labels name no class of ours.

        EoMT, Mask2Former, OneFormer, SegFormer and others; what its labels are called says their classes, and 19 labels
        without a name are the train ids of Cityscapes.
        """
        config = load_pretrained(_KIND, "AutoConfig", name)
        universal = type(config) in auto_class("MODEL_FOR_UNIVERSAL_SEGMENTATION_MAPPING")
        kind = f"AutoModelFor{'Universal' if universal else 'Semantic'}Segmentation"
        classes = _classes(os.fspath(name), config.id2label)
        # a processor of OneFormer tokenizes the task too
        processor = load_pretrained(_KIND, "AutoProcessor", name)
        return cls(os.fspath(name), load_network(_KIND, kind, name, device), processor, classes)

    @torch.inference_mode()
    def __call__(self, pixels: np.ndarray) -> np.ndarray:
        """Class ids u8 [H, W] of pixels u8 [H, W, 3]; 0 for the sky and for labels that are no class of ours."""
        task = {"task_inputs": ["semantic"]} if hasattr(self.processor, "tokenizer") else {}
        inputs = self.processor(images=pixels, return_tensors="pt", **task)
        offsets = inputs.pop("patch_offsets", None)  # of the squares that EoMT cuts a wide picture into
        outputs = self.network(**inputs.to(self.network.device))
        if offsets is not None:
            outputs.patch_offsets = offsets
        (found,) = self.processor.post_process_semantic_segmentation(outputs, target_sizes=[pixels.shape[:2]])
        return self.classes[found.cpu().numpy()]


def _classes(name: str, labels: dict[int, str]) -> np.ndarray:
    found = [class_of([labels[number]], {}) for number in sorted(labels)]
    if not any(found):
        if len(found) == 19:
            return CLASS_FROM_TRAIN_ID[:19]
        shown = ", ".join(list(labels.values())[:3])
        raise CheckpointError(f"{_KIND} {name!r}: its {len(labels)} labels ({shown}, ...) name no class of ours")
    return np.array([BY_NAME[one].id if one else 0 for one in found], dtype=np.uint8)
