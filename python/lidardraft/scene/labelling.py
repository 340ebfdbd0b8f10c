"""Labels for a generated scan, from the condition image and the layout it was generated from."""

from __future__ import annotations

import dataclasses

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import BY_NAME

ABSOLUTE_TOLERANCE = 0.5  # m
RELATIVE_TOLERANCE = 0.05
_GROWTH = 0.3  # m; how far outside a shape of the layout a point still belongs to it


def agrees(scan: RangeImage, condition_image: RangeImage) -> np.ndarray:
    """bool [H, W]: where both have a return, and at the same distance within 0.5 m or 5 % of the condition image's."""
    if scan.sensor.shape != condition_image.sensor.shape:
        raise SensorError(
            f"the scan is {scan.sensor.shape}, the condition image {condition_image.sensor.shape}; both need one sensor"
        )
    tolerance = np.maximum(ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE * condition_image.depth)
    return scan.valid & condition_image.valid & (np.abs(scan.depth - condition_image.depth) <= tolerance)


def label_from_condition_image(
    scan: RangeImage, condition_image: RangeImage, layout: Layout, pose: np.ndarray
) -> RangeImage:
    """`scan` with label and instance: the condition image's where the ranges agree, else those of the smallest shape of
    the layout around the point (grown by 0.3 m), else none. `pose` is world_from_sensor [4, 4] of both images.

    A mesh is not known to fill the box around it, so it labels only where the ranges agree.
    """
    near = agrees(scan, condition_image)
    label = np.where(near, condition_image.label, 0).astype(np.uint8)
    instance = np.where(near, condition_image.instance, 0).astype(np.uint32)
    rest = scan.valid & ~near
    points = scan.sensor.pattern.points(scan.depth)[rest] @ pose[:3, :3].T + pose[:3, 3]
    rest_label, rest_instance = label[rest], instance[rest]
    # From the largest to the smallest, so that of nested shapes the smallest is written last.
    solids = [primitive for primitive in layout if primitive.mesh is None]
    for primitive in sorted(solids, key=lambda p: -float(np.prod(np.maximum(p.size, _GROWTH)))):
        inside = _inside(primitive, points)
        rest_label[inside], rest_instance[inside] = BY_NAME[primitive.label].id, primitive.instance
    label[rest], instance[rest] = rest_label, rest_instance
    return dataclasses.replace(scan, label=label, instance=instance)


def _inside(primitive: Primitive, points: np.ndarray) -> np.ndarray:
    offset = points - primitive.center
    cos, sin = np.cos(primitive.yaw), np.sin(primitive.yaw)
    x, y = cos * offset[:, 0] + sin * offset[:, 1], cos * offset[:, 1] - sin * offset[:, 0]
    local = np.stack([x, y, offset[:, 2]], axis=1)
    return (np.abs(local) <= np.asarray(primitive.size) / 2 + _GROWTH).all(axis=1)
