"""Masks of unknown content become numbered objects, each with the class of most of its pixels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lidardraft.semantics import CLASSES

# Estimates.
_MAJORITY = 0.5  # of the pixels of a mask have its class
_NEW = 0.5  # of the pixels of a mask must not be in a better mask
THINGS = np.array([row.is_thing for row in CLASSES])


def number_objects(labels: np.ndarray, masks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Classes u8 and numbers of objects u32 [H, W].

    The inputs are class ids [H, W] and masks: bool [M, H, W], the best first, or their numbers [H, W], 0 for none.

    A mask is one thing if most of its pixels are of one class of things, and are not in a better mask.
    """
    classes, numbers = labels.astype(np.uint8), np.zeros(labels.shape, dtype=np.uint32)
    for mask in _each(masks):
        free = mask & (numbers == 0)
        if not mask.any() or np.count_nonzero(free) < _NEW * np.count_nonzero(mask):
            continue
        votes = np.bincount(labels[mask], minlength=len(CLASSES))
        winner = int(votes.argmax())
        if THINGS[winner] and votes[winner] > _MAJORITY * votes.sum():
            classes[free] = winner
            numbers[free] = numbers.max() + 1
    return classes, numbers


def _each(masks: np.ndarray) -> Iterator[np.ndarray]:
    """The masks [H, W] one by one; among numbered ones, 0 is none."""
    if masks.ndim == 3:
        yield from masks
    else:
        yield from (masks == number for number in np.unique(masks[masks > 0]))
