"""The share of an object that others hide in a scan."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lidardraft.scene.box import Box
from lidardraft.scene.pose import moved_by_column
from lidardraft.scene.range_image import RangeImage

_BEFORE = 0.1  # m: a return nearer to the box than this is from the box


def occluded_shares(image: RangeImage, boxes: Sequence[Box], poses: np.ndarray | None = None) -> list[float]:
    """For each box, the share of the rays towards it that return from something else before it; 1 without such rays.

    Boxes are in the sensor frame; `poses` [W, 4, 4] are those of the columns in it, if the sensor moved.
    """
    pattern, shape = image.sensor.pattern, image.depth.shape
    one, two = (pattern.points(np.full(shape, distance, np.float32)) for distance in (1, 2))
    if poses is not None:
        one, two = moved_by_column(poses, one), moved_by_column(poses, two)
    directions, origins = two - one, 2 * one - two
    directions, origins = directions.reshape(-1, 3), origins.reshape(-1, 3)
    along, outwards = np.einsum("ni,ni->n", origins, directions), np.einsum("ni,ni->n", origins, origins)
    depth, instance = image.depth.ravel(), image.instance.ravel()
    shares = []
    for box in boxes:
        center, radius = np.array(box.center), np.linalg.norm(box.size) / 2
        ahead = directions @ center - along
        beside = center @ center - 2 * (origins @ center) + outwards - ahead**2
        near = np.flatnonzero((beside <= radius**2) & (ahead > -radius))
        entry = _entries(center - origins[near], directions[near], box)
        near, entry = near[np.isfinite(entry)], entry[np.isfinite(entry)]
        stopped = (depth[near] > 0) & (depth[near] < entry - _BEFORE) & (instance[near] != box.instance)
        shares.append(float(stopped.mean()) if len(near) else 1.0)
    return shares


def _entries(to_box: np.ndarray, directions: np.ndarray, box: Box) -> np.ndarray:
    """The distance along each ray [N, 3] to the box, f64 [N]; infinite for rays that miss it. `to_box` [N, 3] is the
    vector from the ray's start to the centre of the box."""
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    axes, half = np.array([(cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)]), np.array(box.size) / 2
    centre, ahead = to_box @ axes, directions @ axes
    ahead = np.where(ahead == 0, 1e-12, ahead)  # rays along a side
    enters = ((centre - np.sign(ahead) * half) / ahead).max(axis=1, initial=0.0)
    leaves = ((centre + np.sign(ahead) * half) / ahead).min(axis=1, initial=np.inf)
    return np.where(enters <= leaves, enters, np.inf)
