"""Depth and classes of a picture become points: evenly thinned, without those that hang between two surfaces."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.drafting.cloud.ground import GROUND_IDS
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.semantics import CLASSES

# Angles and shares without a source are estimates.
CELL = math.radians(0.08)  # a cell with one point: about as dense as an HDL-64E's along its rows
_SIDE = math.radians(0.16)  # to either side of a point: depth that grows across both means a point between two surfaces
_STEEPEST = 27.0  # growth of depth for each radian, relative to the depth: more is no wall at any angle
_JUMP = 1.15  # of depth, from an object to the background beside it
_APART = 1.03  # of depth, from a cell to the next: more separates clusters
_BLUR = math.radians(0.32)  # the reach of a class over the edge of its object

_THINGS = np.array([row.is_thing for row in CLASSES])


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class PseudoCloud:
    """Points f64 [N, 3] in the frame of the camera (x forward, y left, z up), with the class and number of the
    object."""

    points: np.ndarray
    labels: np.ndarray
    instances: np.ndarray


def pseudo_cloud(depth: np.ndarray, labels: np.ndarray, instances: np.ndarray, camera: Pinhole) -> PseudoCloud:
    """The points of a picture with depth [H, W] along the axis of the camera; pixels with depth 0 or label 0 are left
    out.

    There is one a cell of `CELL`, the pixel nearest to its middle. At edges of objects, depth of networks runs smoothly
    from one surface to the other, and classes reach a little over the edge: such points are left out.
    """
    step = max(1, round(CELL * camera.fx))
    rows, columns = _one_a_cell((depth > 0) & (labels > 0), step)
    depth = np.where(rows >= 0, depth[rows, columns], 0.0)
    labels = np.where(rows >= 0, labels[rows, columns], 0)
    wrong = _between_surfaces(depth, step / camera.fx) | _over_the_edge(depth, labels, step / camera.fx)
    wrong |= _THINGS[labels] & _apart(depth, labels)
    kept = (depth > 0) & (np.isin(labels, GROUND_IDS) | ~wrong)
    rows, columns = rows[kept], columns[kept]
    points = camera.rays(rows, columns) * depth[kept][:, None]
    return PseudoCloud(points=points, labels=labels[kept], instances=instances[rows, columns])


def _one_a_cell(usable: np.ndarray, step: int) -> tuple[np.ndarray, np.ndarray]:
    """Row and column [H / step, W / step] of the usable pixel nearest to the middle of each cell; -1 if there is
    none."""
    height, width = (math.ceil(length / step) for length in usable.shape)
    padded = np.zeros((height * step, width * step), dtype=bool)
    padded[: usable.shape[0], : usable.shape[1]] = usable
    rows, columns = np.full((height, width), -1), np.full((height, width), -1)
    middle = (step - 1) / 2
    places = [(i, j) for i in range(step) for j in range(step)]
    for i, j in sorted(places, key=lambda place: math.hypot(place[0] - middle, place[1] - middle)):
        found = padded[i::step, j::step] & (rows < 0)
        rows[found] = np.nonzero(found)[0] * step + i
        columns[found] = np.nonzero(found)[1] * step + j
    return rows, columns


def _between_surfaces(depth: np.ndarray, cell: float) -> np.ndarray:
    """bool [H, W]: True if depth rises steeply from the surface on one side and on to that on the other; `cell` in
    rad."""
    found = np.zeros(depth.shape, dtype=bool)
    side = max(1, round(_SIDE / cell))
    steep = math.exp(_STEEPEST * side * cell)
    for image, result in ((depth, found), (depth.T, found.T)):
        before, here, after = image[:, : -2 * side], image[:, side:-side], image[:, 2 * side :]
        known = (before > 0) & (after > 0)
        rising = (here > steep * before) & (after > steep * here)
        falling = (before > steep * here) & (here > steep * after)
        result[:, side:-side] |= known & (rising | falling)
    return found


def _over_the_edge(depth: np.ndarray, labels: np.ndarray, cell: float) -> np.ndarray:
    """bool [H, W]: True if the same class is much nearer close by, so that the class may be that of the object
    there."""
    found = np.zeros(depth.shape, dtype=bool)
    for image, classes, result in ((depth, labels, found), (depth.T, labels.T, found.T)):
        for step in range(1, max(1, round(_BLUR / cell)) + 1):
            one, other = np.s_[:, :-step], np.s_[:, step:]
            same = (classes[one] == classes[other]) & (image[one] > 0) & (image[other] > 0)
            result[one] |= same & (image[one] > _JUMP * image[other])
            result[other] |= same & (image[other] > _JUMP * image[one])
    return found


def _apart(depth: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """bool [H, W]: True if the cells of its class above and below, or on both sides, are all much nearer or further.

    The last rows of a roof at a flat angle are such: apart from the rest they would be another object.
    """
    found = np.zeros(depth.shape, dtype=bool)
    for image, classes, result in ((depth, labels, found), (depth.T, labels.T, found.T)):
        one, other = image[:, :-1], image[:, 1:]
        same = (classes[:, :-1] == classes[:, 1:]) & (one > 0) & (other > 0)
        near = same & (np.maximum(one, other) <= _APART * np.minimum(one, other))
        has_near, has_any = np.zeros(image.shape, dtype=bool), np.zeros(image.shape, dtype=bool)
        for has, which in ((has_near, near), (has_any, same)):
            has[:, :-1] |= which
            has[:, 1:] |= which
        result |= has_any & ~has_near
    return found
