"""Intersection over union of labels: how well a segmentation agrees with the truth, class by class.

IoU = TP / (TP + FP + FN), counted over all scans together (PASCAL VOC, Everingham et al., IJCV 2010). Returns whose
truth is unlabelled count for nothing, and the mean is over all classes asked for, with 0 for those that are neither
there nor found: as the evaluator of SemanticKITTI does it (Behley et al., ICCV 2019).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LidarDraftError


def confusion_matrix(truth: np.ndarray, found: np.ndarray, classes: int) -> np.ndarray:
    """How often class t was labelled f, i64 [K, K] at [t, f], of class ids [...] from 0 to `classes` - 1.

    Class 0 is "unlabelled". Matrices of several scans are added. Raises `LidarDraftError` where ids or shapes do not
    fit.
    """
    if truth.shape != found.shape:
        raise LidarDraftError(f"truth is {truth.shape} and the labels found are {found.shape}; they must be the same")
    for name, ids in (("truth", truth), ("label found", found)):
        if ids.size and not 0 <= ids.min() <= ids.max() < classes:
            raise LidarDraftError(f"a {name} is {ids.min()} or {ids.max()}; ids are 0 to {classes - 1}")
    pairs = truth.ravel().astype(np.int64) * classes + found.ravel()
    return np.bincount(pairs, minlength=classes * classes).reshape(classes, classes)


@dataclass(frozen=True, slots=True, eq=False)
class ClassScores:
    """Of each class [K]: `iou`, NaN where it is neither there nor found, and `truth`, how many returns are of it."""

    iou: np.ndarray
    truth: np.ndarray

    @classmethod
    def from_confusion(cls, confusion: np.ndarray) -> ClassScores:
        """The scores of a matrix [K, K] of `confusion_matrix`; class 0 of the truth counts for nothing."""
        counted = confusion.copy()
        counted[0] = 0
        both, truth = np.diagonal(counted), counted.sum(axis=1)
        either = truth + counted.sum(axis=0) - both
        return cls(np.where(either > 0, both / np.maximum(either, 1), np.nan), truth)

    def mean(self, classes: Sequence[int]) -> float:
        """mIoU over these classes; one that is neither there nor found counts 0."""
        return float(np.nan_to_num(self.iou[list(classes)]).mean()) if len(classes) else float("nan")
