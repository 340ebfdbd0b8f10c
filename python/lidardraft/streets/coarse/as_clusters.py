"""A street as clustering its scan would find it: only what was seen, with unseen sides completed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lidardraft.scene.shape_table import ShapeTable
from lidardraft.semantics import BY_NAME, CLASSES, NUM_CLASSES
from lidardraft.streets.coarse.cluster_shapes import cluster_shapes
from lidardraft.streets.coarse.coarse_street import CoarseStreet
from lidardraft.streets.coarse.visible import VisibleObjects

_RIDER = BY_NAME["rider"].id
_IS_THING = np.array([row.is_thing for row in CLASSES])


@dataclass(frozen=True, kw_only=True, slots=True)
class ClusterStyle:
    """`numbered` is whether the points come with the numbers of their objects."""

    source: ClassVar[str] = "cloud"
    coverage: ClassVar[tuple[float, float] | None] = None
    numbered: bool = True


def as_clusters(
    street: CoarseStreet, style: ClusterStyle, rng: np.random.Generator, pose: np.ndarray, visible: VisibleObjects
) -> ShapeTable:
    """What was seen of the objects on ground that rises and falls, in the frame of the ego vehicle at `pose` [4, 4]."""
    yaws = street.places[:, 2] - visible.place[2]
    found = cluster_shapes(visible, yaws, street.heights_over(pose), street.diameters, rng, numbered=style.numbered)
    order = np.argsort(found.keys % NUM_CLASSES, kind="stable")
    labels, owners = found.keys[order] % NUM_CLASSES, found.keys[order] // NUM_CLASSES
    # what is ridden has the instance after its rider's
    ridden = street.ridden[owners] & (labels != _RIDER)
    number = np.arange(len(labels)) - np.searchsorted(labels, labels)
    shapes = ShapeTable(
        shapes=found.shapes[order],
        centers=found.centers[:, order].T,
        sizes=found.sizes[:, order].T,
        yaws=found.yaws[order],
        labels=labels,
        instances=np.where(_IS_THING[labels], street.instances[owners] + ridden, 0),
        ids=tuple(f"{CLASSES[k].name}_{n + 1}" for k, n in zip(labels.tolist(), number.tolist(), strict=True)),
    )
    return ShapeTable.join(street.ground(pose, relief=True), shapes)
