"""Layout adherence: the share of a scan that agrees with the condition image, the cast of its layout.

The definition is our own; no published score compares a scan with the layout it was generated from. A return agrees
with the condition if `scene.labelling.agrees` says so: within 0.5 m or 5 % of its depth, whichever is more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.scene.labelling import agrees
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import BY_NAME, CLASSES, GROUND

_NO_OBJECT = [BY_NAME[name].id for name in ("none", *GROUND)]


@dataclass(frozen=True, kw_only=True, slots=True)
class Adherence:
    """Shares in [0, 1]; NaN without a pixel to count.

    `objects`, `overall` and `by_class` are the shares of the scan's returns that agree with the condition image. They
    are among returns whose ray hits an object there (not road, sidewalk or terrain), anything, or a class by name.
    `drop` is the share of the condition's hits without a return.
    """

    objects: float
    overall: float
    by_class: dict[str, float]
    drop: float


def adherence(scan: RangeImage, condition_image: RangeImage) -> Adherence:
    """The adherence of `scan` to `condition_image`, the layout cast by the same sensor."""
    good = agrees(scan, condition_image)
    both = scan.valid & condition_image.valid
    objects = both & ~np.isin(condition_image.label, _NO_OBJECT)
    present = np.unique(condition_image.label[both])
    return Adherence(
        objects=_share(good, objects),
        overall=_share(good, both),
        by_class={CLASSES[label].name: _share(good, both & (condition_image.label == label)) for label in present},
        drop=_share(~scan.valid, condition_image.valid),
    )


def _share(part: np.ndarray, whole: np.ndarray) -> float:
    count = np.count_nonzero(whole)
    return float(np.count_nonzero(part & whole) / count) if count else float("nan")
