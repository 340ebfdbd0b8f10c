"""The ground of a street as a clustering finds it: a coarse mesh for each class, with its relief."""

from __future__ import annotations

import numpy as np

from lidardraft.drafting.cloud.rules import GROUND_PLANE_DROP, GROUND_PLANE_SIZE
from lidardraft.scene.layout import SHAPES, Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.road import Road
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.semantics import BY_NAME, CLASSES

_STEP = 4.0  # m along the road
_BESIDE = (*np.arange(1.5, 13.0, 2.5), *np.arange(14.0, 75.0, 5.0))  # m from the verge
_ASIDE = 0.1  # m from a kerb to the lines on its sides
_SKY = 200.0  # m
_SEEN = 80.0  # m; ground further off returns next to nothing


class GroundMesh:
    """The ground `surfaces` of a street's detailed scene, looked at from above in cells along the road.

    A cell has the class of its middle; a corner's height depends on its place only, so that neighbours meet without a
    gap. Below all of it lies the plane "ground".
    """

    def __init__(self, road: Road, surfaces: list[Primitive]) -> None:
        caster = Raycaster(Layout(primitives=tuple(surfaces)))
        along, across = _lines(road)
        corners = road.points(*np.meshgrid(along, across, indexing="ij"))
        middles = road.points(*np.meshgrid(_middles(along), _middles(across), indexing="ij"))
        height, label = _looked_down(caster, corners)[0], _looked_down(caster, middles)[1]
        corner = np.arange(height.size).reshape(height.shape)
        quads = np.stack([corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]], axis=-1)
        self._vertices = np.column_stack([corners.reshape(-1, 2), height.ravel()])
        self._quads, self._labels, self._middles = quads.reshape(-1, 4), label.ravel(), middles.reshape(-1, 2)

    def around(self, pose: np.ndarray) -> ShapeTable:
        """The ground near street_from_ego `pose` [4, 4]: a mesh for each class, with heights over the plane that stands
        there, and else in the frame of the road."""
        near = np.hypot(*(self._middles - pose[:2, 3]).T) < _SEEN
        quads, labels = self._quads[near], self._labels[near]
        found = np.flatnonzero(np.bincount(labels, minlength=1))
        vertices = np.column_stack([self._vertices[:, :2], (self._vertices - pose[:3, 3]) @ pose[:3, 2]])
        rows, meshes, bottom = [], [], 0.0
        for number in found.tolist():
            mine = quads[labels == number]
            used = np.zeros(len(vertices), dtype=bool)
            used[mine] = True
            corners, faces = vertices[used], (np.cumsum(used) - 1)[mine]
            low, high = corners.min(axis=0), corners.max(axis=0)
            size = np.maximum(high - low, 0.1)
            rows.append((low + size / 2, size))
            triangles = np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
            meshes.append(TriangleMesh((corners - low) / size - 0.5, triangles))
            bottom = min(bottom, float(low[2]))
        count = len(found)
        return ShapeTable(
            shapes=np.array([SHAPES.index("plane"), *[SHAPES.index("mesh")] * count]),
            centers=np.array([(0.0, 0.0, bottom - GROUND_PLANE_DROP), *(center for center, _ in rows)]),
            sizes=np.array([(GROUND_PLANE_SIZE, GROUND_PLANE_SIZE, 0.0), *(size for _, size in rows)]),
            yaws=np.zeros(1 + count),
            labels=np.array([BY_NAME["terrain"].id, *found]),
            instances=np.zeros(1 + count),
            ids=("ground", *(CLASSES[number].name for number in found)),
            meshes=tuple(meshes),
        )


def _lines(road: Road) -> tuple[np.ndarray, np.ndarray]:
    end = road.half_length + 2 * _STEP
    along = np.linspace(-end, end, round(2 * end / _STEP) + 1)
    # on either side of a kerb is a line, or else it would be a slope as wide as a lane
    kerb = [road.edge - _ASIDE, road.edge + _ASIDE]
    ends = [road.verge - _ASIDE, road.verge + _ASIDE] if road.sidewalk > 4 * _ASIDE else []
    if road.junction is not None:
        # the lines of the side road take the place of those near them
        half = np.array([*kerb, *ends])
        sides = road.junction + np.concatenate([-half, half])
        near = np.abs(along[:, None] - sides).min(axis=1) < _STEP / 3
        along = np.unique(np.concatenate([along[~near], sides]))
    # the land inside a bend ends before the bend's centre
    limit = 0.8 / abs(road.curvature) if road.curvature else np.inf
    offs = [off for off in (*kerb, *ends, *(road.verge + np.array(_BESIDE))) if off < limit]
    return along, np.array([*(-off for off in reversed(offs)), 0.0, *offs])


def _middles(lines: np.ndarray) -> np.ndarray:
    middles: np.ndarray = (lines[1:] + lines[:-1]) / 2
    return middles


def _looked_down(caster: Raycaster, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Height [m] and class id of the ground at places [..., 2]; terrain at z = 0 where there is none."""
    flat = places.reshape(-1, 2)
    origins = np.column_stack([flat, np.full(len(flat), _SKY)])
    hits = caster.cast(origins, np.tile([0.0, 0.0, -1.0], (len(flat), 1)), threads=1)
    height = np.where(hits.valid, _SKY - hits.distance.astype(float), 0.0)
    label = np.where(hits.valid, hits.label, BY_NAME["terrain"].id)
    return height.reshape(places.shape[:-1]), label.reshape(places.shape[:-1])
