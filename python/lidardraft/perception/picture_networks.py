"""Pictures -> depth, classes and objects, by any such network of transformers, from an id or a folder.

Masks have no class: each gets that of most of its pixels, as in the Semantic Segment Anything project (Chen et al.,
2023). So touching things are separate, and their outlines are those of the masks.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from lidardraft.errors import CheckpointError, extra
from lidardraft.formats.cityscapes import CLASS_FROM_TRAIN_ID
from lidardraft.perception.mask_votes import THINGS, number_objects
from lidardraft.scene.class_names import class_of
from lidardraft.semantics import BY_NAME

with extra("image"):
    import torch

_FILES = "--depth FILE, --semantics FILE and --masks FILE need no network"
_DEPTH, _SEMANTIC, _MASK = "depth network", "semantic network", "mask network"
_PATIENCE = 10.0  # s, the time limit of the hub
_SATURATED = 0.95  # of the largest depth of a network; it cannot measure larger ones
# Estimates, except the score, which is a little below that of SAM's own generator of masks.
_SPACING = 16  # pixels between the points of prompts
_MOST_POINTS = 128
_POINTS_AT_ONCE = 16
_SCORE = 0.8  # a network's own estimate of the quality of a mask


@dataclass(frozen=True, slots=True, eq=False)
class DepthNetwork:
    """A network with the processor of its pictures."""

    name: str
    network: Any
    processor: Any

    @classmethod
    def from_pretrained(cls, name: str | os.PathLike[str], *, device: str = "cpu") -> DepthNetwork:
        """The network of an id or in a folder; raises `CheckpointError`, also for one whose depth has no unit."""
        processor = load_pretrained(_DEPTH, "AutoImageProcessor", name)
        network = load_network(_DEPTH, "AutoModelForDepthEstimation", name, device)
        if getattr(network.config, "depth_estimation_type", "metric") != "metric":
            raise CheckpointError(f"{_DEPTH} {os.fspath(name)!r} gives relative depth; metric depth is needed")
        return cls(os.fspath(name), network, processor)

    @torch.inference_mode()
    def __call__(self, pixels: np.ndarray) -> np.ndarray:
        """Depth f32 [H, W] [m] of pixels u8 [H, W, 3]; 0 if unknown, as in the sky."""
        inputs = self.processor(images=pixels, return_tensors="pt").to(self.network.device)
        outputs = self.network(**inputs)
        (found,) = self.processor.post_process_depth_estimation(outputs, target_sizes=[pixels.shape[:2]])
        depth = found["predicted_depth"].float().cpu().numpy()
        known = np.isfinite(depth) & (depth > 0)
        if largest := getattr(self.network.config, "max_depth", None):
            known &= depth < _SATURATED * largest
        return np.where(known, depth, 0).astype(np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class SemanticNetwork:
    """A network with the processor of its pictures; `classes` u8 [L] holds the class id of each of its labels."""

    name: str
    network: Any
    processor: Any
    classes: np.ndarray

    @classmethod
    def from_pretrained(cls, name: str | os.PathLike[str], *, device: str = "cpu") -> SemanticNetwork:
        """The network of an id or in a folder; raises `CheckpointError`, also for one whose labels name no known class.

        EoMT, Mask2Former, OneFormer, SegFormer and others; the names of its labels give their classes, and 19 labels
        without names are the train ids of Cityscapes.
        """
        config = load_pretrained(_SEMANTIC, "AutoConfig", name)
        universal = type(config) in auto_class("MODEL_FOR_UNIVERSAL_SEGMENTATION_MAPPING")
        kind = f"AutoModelFor{'Universal' if universal else 'Semantic'}Segmentation"
        classes = _classes(os.fspath(name), config.id2label)
        # a processor of OneFormer tokenizes the task too
        processor = load_pretrained(_SEMANTIC, "AutoProcessor", name)
        return cls(os.fspath(name), load_network(_SEMANTIC, kind, name, device), processor, classes)

    @torch.inference_mode()
    def __call__(self, pixels: np.ndarray) -> np.ndarray:
        """Class ids u8 [H, W] of pixels u8 [H, W, 3]; 0 for the sky and for labels of no known class."""
        task = {"task_inputs": ["semantic"]} if hasattr(self.processor, "tokenizer") else {}
        inputs = self.processor(images=pixels, return_tensors="pt", **task)
        offsets = inputs.pop("patch_offsets", None)  # of the squares into which EoMT cuts a wide picture
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
        raise CheckpointError(f"{_SEMANTIC} {name!r}: its {len(labels)} labels ({shown}, ...) name no known class")
    return np.array([BY_NAME[one].id if one else 0 for one in found], dtype=np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class MaskNetwork:
    """A network with the processor of its pictures and points."""

    name: str
    network: Any
    processor: Any

    @classmethod
    def from_pretrained(cls, name: str | os.PathLike[str], *, device: str = "cpu") -> MaskNetwork:
        """The network of an id or in a folder; raises `CheckpointError`."""
        processor = load_pretrained(_MASK, "AutoProcessor", name)
        return cls(os.fspath(name), load_network(_MASK, "AutoModelForMaskGeneration", name, device), processor)

    def __call__(self, pixels: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Class ids u8 [H, W] and numbers of objects u32 [H, W] of pixels u8 [H, W, 3] with class ids [H, W]."""
        points = _points_on_things(labels)
        masks, scores = (
            self._masks(pixels, points) if len(points) else (np.zeros((0, *labels.shape), bool), np.zeros(0))
        )
        return number_objects(labels, masks[np.argsort(-scores, kind="stable")])

    @torch.inference_mode()
    def _masks(self, pixels: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The best mask of each point, bool [M, H, W], with its score [M]; masks with a low score are left out."""
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
    """Places [M, 2] (column, row) on things, on a grid, which gets wider if there would be too many."""
    spacing = _SPACING
    while True:
        half = spacing // 2
        rows, columns = np.nonzero(THINGS[labels[half::spacing, half::spacing]])
        if len(rows) <= _MOST_POINTS:
            return np.column_stack([columns, rows]) * spacing + half
        spacing *= 2


def auto_class(name: str) -> Any:
    """A class of transformers such as "AutoModelForDepthEstimation"."""
    with extra():
        import transformers

    return getattr(transformers, name)


def load_pretrained(kind: str, class_name: str, name: str | os.PathLike[str], **options: Any) -> Any:
    """The object that a class of transformers loads from a folder or, if there is none, from the hub or its cache.

    `kind` is its name in the message. Weights are read from safetensors files alone, and foreign code is never run.
    Raises `CheckpointError` if it is missing or does not fit.
    """
    loader, source = auto_class(class_name), os.fspath(name)
    try:
        try:
            return loader.from_pretrained(source, local_files_only=True, **options)
        except OSError:
            if os.path.isdir(source):
                raise
        _find_on_hub(kind, source)
        return loader.from_pretrained(source, **options)
    except CheckpointError:
        raise
    except Exception as error:  # the library and those below it raise anything on foreign files
        raise CheckpointError(f"{kind} {source!r} cannot be loaded: {_first_line(error)}; {_FILES}") from None


def _find_on_hub(kind: str, source: str) -> None:
    """Raise `CheckpointError` if the hub does not have a network or cannot be reached: transformers itself would try
    six times, and log each."""
    with extra():
        import huggingface_hub

    try:
        huggingface_hub.model_info(source, timeout=_PATIENCE)
    except Exception as error:
        raise CheckpointError(
            f"{kind} {source!r} cannot be loaded: it is not on this machine, and the hub does not give it "
            f"({_first_line(error)}); {_FILES}"
        ) from None


def _first_line(error: Exception) -> str:
    return next((line.strip() for line in str(error).splitlines() if line.strip()), type(error).__name__)


def load_network(kind: str, class_name: str, name: str | os.PathLike[str], device: str) -> torch.nn.Module:
    """A model of transformers, in evaluation mode on a device."""
    network = load_pretrained(kind, class_name, name, use_safetensors=True)
    try:
        placed: torch.nn.Module = network.to(device).eval()
    except (RuntimeError, AssertionError) as error:  # torch's, for a device it does not have
        raise CheckpointError(f"device is {device!r}: {str(error).splitlines()[0]}") from None
    return placed
