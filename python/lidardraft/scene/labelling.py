"""Labels for a generated scan, from scans of its layout and from the layout itself."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.pose import in_upright_frame
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import BY_NAME

ABSOLUTE_TOLERANCE = 0.5  # m
RELATIVE_TOLERANCE = 0.05
_GROWTH = 0.3  # m; how far outside a shape of the layout a point still belongs to it


def agrees(scan: RangeImage, other: RangeImage) -> np.ndarray:
    """bool [H, W]: True if both have a return, at the same distance within 0.5 m or 5 % of the other's."""
    if scan.sensor.shape != other.sensor.shape:
        raise SensorError(f"one scan is {scan.sensor.shape}, the other {other.sensor.shape}; both need one sensor")
    tolerance = np.maximum(ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE * other.depth)
    return scan.valid & other.valid & (np.abs(scan.depth - other.depth) <= tolerance)


def label_by_agreement(scan: RangeImage, known: Sequence[RangeImage], layout: Layout, pose: np.ndarray) -> RangeImage:
    """`scan` with label and instance of the first of the `known` images whose range agrees. Other points get those of
    the smallest shape of the layout whose box, grown by 0.3 m, holds them; the rest keep their own. `pose` is
    world_from_sensor of all images: [4, 4], or one for each column [W, 4, 4].

    An ellipsoid or a cylinder counts as its box, whose corners are close to it. A mesh may be hollow in its box, so it
    labels points only where the ranges agree.
    """
    near = np.zeros(scan.sensor.shape, dtype=bool)
    label, instance = scan.label.copy(), scan.instance.copy()
    for image in known:
        new = agrees(scan, image) & ~near
        label[new], instance[new] = image.label[new], image.instance[new]
        near |= new
    rest = scan.valid & ~near
    poses = np.broadcast_to(pose, (scan.sensor.columns, 4, 4))
    points = scan.points(poses)[rest[scan.valid]]
    rest_label, rest_instance = label[rest], instance[rest]
    # From the largest to the smallest, so that of nested shapes the smallest is written last.
    solids = [primitive for primitive in layout if primitive.mesh is None]
    for primitive in sorted(solids, key=lambda p: -float(np.prod(np.maximum(p.size, _GROWTH)))):
        inside = _inside(primitive, points)
        rest_label[inside], rest_instance[inside] = BY_NAME[primitive.label].id, primitive.instance
    label[rest], instance[rest] = rest_label, rest_instance
    return dataclasses.replace(scan, label=label, instance=instance)


def _inside(primitive: Primitive, points: np.ndarray) -> np.ndarray:
    away = np.abs(in_upright_frame(points, primitive.center, primitive.yaw))
    return np.asarray((away <= np.array(primitive.size) / 2 + _GROWTH).all(axis=1))
