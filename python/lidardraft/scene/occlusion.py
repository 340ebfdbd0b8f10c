"""How much of an object the things before it hide from a sensor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lidardraft.scene.box import Box
from lidardraft.scene.range_image import RangeImage

_BEFORE = 0.1  # m: what is nearer to the box than this stands in it


def occluded_shares(image: RangeImage, boxes: Sequence[Box], moved: np.ndarray | None = None) -> list[float]:
    """For each box, the share of the rays towards it that return from something else before it; 1 without such rays.

    Boxes are in the sensor frame; `moved` [W, 3] is where the sensor stood in it at each column, if it moved.
    """
    one = image.sensor.pattern.points(np.ones(image.depth.shape, np.float32))
    two = image.sensor.pattern.points(np.full(image.depth.shape, 2, np.float32))
    directions = (two - one).reshape(-1, 3)
    origins = (2 * one - two + (0.0 if moved is None else moved)).reshape(-1, 3)
    depth, instance = image.depth.ravel(), image.instance.ravel()
    shares = []
    for box in boxes:
        entry = _entries(origins, directions, box)
        towards = np.isfinite(entry)
        stopped = (depth > 0) & (depth < entry - _BEFORE) & (instance != box.instance) & towards
        shares.append(float(stopped.sum() / towards.sum()) if towards.any() else 1.0)
    return shares


def _entries(origins: np.ndarray, directions: np.ndarray, box: Box) -> np.ndarray:
    """How far along each ray [N, 3] the box begins, f64 [N]; infinite for rays that miss it."""
    entries = np.full(len(origins), np.inf)
    to_box = np.array(box.center) - origins
    along = np.einsum("ni,ni->n", to_box, directions)
    beside = np.einsum("ni,ni->n", to_box, to_box) - along**2
    radius = np.linalg.norm(box.size) / 2
    near = np.flatnonzero((beside <= radius**2) & (along > -radius))
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    axes = np.array([(cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)])
    centre, ahead = to_box[near] @ axes, directions[near] @ axes
    with np.errstate(divide="ignore", invalid="ignore"):  # a ray along a side of the box
        first = (centre - np.sign(ahead) * np.array(box.size) / 2) / ahead
        last = (centre + np.sign(ahead) * np.array(box.size) / 2) / ahead
    enters = np.nanmax(np.where(ahead == 0, -np.inf, first), axis=1, initial=0.0)
    leaves = np.nanmin(np.where(ahead == 0, np.inf, last), axis=1, initial=np.inf)
    level = ((ahead != 0) | (np.abs(centre) <= np.array(box.size) / 2)).all(axis=1)
    hit = level & (enters <= leaves)
    entries[near[hit]] = enters[hit]
    return entries
