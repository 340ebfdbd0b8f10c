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
    """How far along each ray [N, 3] the box begins, whose centre is `to_box` [N, 3] from its start: f64 [N]; infinite
    for rays that miss it."""
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    axes, half = np.array([(cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)]), np.array(box.size) / 2
    centre, ahead = to_box @ axes, directions @ axes
    ahead = np.where(ahead == 0, 1e-12, ahead)  # a ray along a side
    enters = ((centre - np.sign(ahead) * half) / ahead).max(axis=1, initial=0.0)
    leaves = ((centre + np.sign(ahead) * half) / ahead).min(axis=1, initial=np.inf)
    return np.where(enters <= leaves, enters, np.inf)
