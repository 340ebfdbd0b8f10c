"""What a picture does not show, as a mirror image of what it shows.

No guess at what is there: a road goes on as it came, with the same sides, so that a scan has something all around.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.sparse.csgraph import connected_components

from lidardraft.drafting.cloud.ground import GROUND_IDS
from lidardraft.drafting.cloud.layout import layout_from_cloud
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.semantics import GROUND

_CLEAR = 3.0  # m from the middle of the ego vehicle, which is about 2 m wide and 5 m long
_GAP = 0.3  # m; shapes no further apart stay together
_TOUCH = math.radians(2)  # as far as this a mirrored object may reach over the edge of the picture


def mirrored_surroundings(layout: Layout, points: np.ndarray, labels: np.ndarray, height: float) -> Layout:
    """The layout of the points [N, 3] that the picture shows, and its mirror image all around it.

    At each distance y from the axis what is at x goes to 2 e - x, where e is where the picture begins: the road goes on
    without a break. Objects that would stand in the picture or on the ego vehicle are left out.
    """
    ground = np.isin(labels, GROUND_IDS)
    points, labels = points[ground], labels[ground]
    begin = _Begin(layout, points)
    behind = points.copy()
    behind[:, 0] = 2 * begin.at(points[:, 1]) - points[:, 0]
    whole = layout_from_cloud(np.concatenate([points, behind]), np.tile(labels, 2), sensor_height=height)
    objects = [primitive for primitive in layout if primitive.label not in GROUND]
    return replace(layout, primitives=(*whole.primitives, *objects, *_mirrored(objects, begin)))


class _Begin:
    """Where a picture begins: at its edges, and where the ground comes out from below it."""

    def __init__(self, layout: Layout, ground: np.ndarray) -> None:
        assert layout.coverage is not None
        self.right, self.left = layout.coverage
        self.nearest = float(np.percentile(ground[:, 0], 0.5))

    def at(self, y: np.ndarray) -> np.ndarray:
        """x [N] at y [N]."""
        x: np.ndarray = np.maximum(np.abs(y) / np.tan(np.where(y > 0, self.left, -self.right)), self.nearest)
        return x


def _mirrored(objects: list[Primitive], begin: _Begin) -> list[Primitive]:
    number = max((primitive.instance for primitive in objects), default=0)
    numbers: dict[int, int] = {}
    found: list[Primitive] = []
    for primitive, y in zip(objects, _distances(objects), strict=True):
        center = (2 * float(begin.at(y)) - primitive.center[0], *primitive.center[1:])
        # The mirror image of a shape turned by a yaw is its own mirror image turned the other way.
        mesh = primitive.mesh and TriangleMesh(primitive.mesh.vertices * (-1, 1, 1), primitive.mesh.faces[:, ::-1])
        image = replace(primitive, center=center, yaw=-primitive.yaw, mesh=mesh, id=f"mirrored_{primitive.id}")
        if not _is_free(image, begin):
            continue
        if primitive.instance:
            numbers.setdefault(primitive.instance, number + len(numbers) + 1)
            image = replace(image, instance=numbers[primitive.instance])
        found.append(image)
    return found


def _distances(objects: list[Primitive]) -> np.ndarray:
    """How far [P] from the axis shapes stand: those that touch, as parts of a crown do, all as far as their middle."""
    if not objects:
        return np.zeros(0)
    centers = np.array([primitive.center[:2] for primitive in objects])
    sizes = np.array([primitive.size[:2] for primitive in objects])
    yaws = np.array([primitive.yaw for primitive in objects])
    cos, sin = np.abs(np.cos(yaws)), np.abs(np.sin(yaws))
    half = np.column_stack([cos * sizes[:, 0] + sin * sizes[:, 1], sin * sizes[:, 0] + cos * sizes[:, 1]]) / 2
    touching = (np.abs(centers[:, None] - centers) < half[:, None] + half + _GAP).all(axis=2)
    number, group = connected_components(touching, directed=False)
    middles = np.array([np.mean(centers[group == one, 1]) for one in range(number)])
    distances: np.ndarray = middles[group]
    return distances


def _is_free(primitive: Primitive, begin: _Begin) -> bool:
    """Whether the shape stands outside of the picture and off the ego vehicle."""
    half = np.array(primitive.size[:2]) / 2
    cos, sin = math.cos(primitive.yaw), math.sin(primitive.yaw)
    to_layout, center = np.array([[cos, sin], [-sin, cos]]), np.array(primitive.center[:2])
    beside = np.maximum(np.abs(to_layout @ center) - half, 0.0)  # from its outline to the ego vehicle, along its sides
    outline = np.array([(1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1), (0, 1)]) * half
    x, y = (outline @ to_layout + center).T
    azimuth = np.arctan2(y, x)
    in_picture = (azimuth > begin.right + _TOUCH) & (azimuth < begin.left - _TOUCH) & (x > begin.nearest)
    return bool(np.hypot(*beside) > _CLEAR and not in_picture.any())
