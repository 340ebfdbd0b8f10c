"""The common part of all coarse layouts of one street: its ground, and its objects' coarse shapes as columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.drafting.cloud.rules import GROUND_PLANE_DROP, GROUND_PLANE_SIZE
from lidardraft.objects.coarse_shapes import CoarseShape
from lidardraft.objects.kinds import SENTENCE_KINDS, kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import SHAPES, Layout, Primitive, object_of
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.road import Road
from lidardraft.scene.road_surfaces import road_surfaces
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.semantics import BY_NAME, CLASSES, GROUND
from lidardraft.streets.coarse.solver_shapes import solver_shapes

_STEP = 4.0  # m along the road
_BESIDE = (*np.arange(1.5, 13.0, 2.5), *np.arange(14.0, 75.0, 5.0))  # m from the verge
_ASIDE = 0.1  # m from a kerb to the lines on its sides
_SKY = 200.0  # m
SEEN = 80.0  # m; ground further off returns next to nothing


class GroundMesh:
    """The ground `surfaces` of a street's detailed scene, seen from above in cells along the road.

    A cell has the class of its middle. A corner's height depends on its place only, so that neighbours meet without a
    gap. Below all cells lies the plane "ground".
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

    def around(self, pose: np.ndarray, reach: float) -> ShapeTable:
        """The ground within `reach` [m] of street_from_ego `pose` [4, 4]: a mesh for each class. Heights are over the
        plane of the pose; x and y are in the frame of the road."""
        near = np.hypot(*(self._middles - pose[:2, 3]).T) < reach
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
    """Height [m] and class id of the ground at places [..., 2]; terrain at z = 0 without any."""
    flat = places.reshape(-1, 2)
    origins = np.column_stack([flat, np.full(len(flat), _SKY)])
    hits = caster.cast(origins, np.tile([0.0, 0.0, -1.0], (len(flat), 1)), threads=1)
    height = np.where(hits.valid, _SKY - hits.distance.astype(float), 0.0)
    label = np.where(hits.valid, hits.label, BY_NAME["terrain"].id)
    return height.reshape(places.shape[:-1]), label.reshape(places.shape[:-1])


@dataclass(frozen=True, slots=True, eq=False)
class ShapeColumns:
    """M coarse shapes as columns: `owners` i64 [M], the index of the object of each; shape, `centers` and `sizes` f64
    [M, 3], label and instance, in the frame of that object; `lobes` i64 [M], as in `CoarseShape`; `places` f64 [M, 3],
    the x, y and yaw of the object; `ids` [M].
    """

    owners: np.ndarray
    shapes: np.ndarray
    centers: np.ndarray
    sizes: np.ndarray
    labels: np.ndarray
    instances: np.ndarray
    lobes: np.ndarray
    places: np.ndarray
    ids: np.ndarray

    @classmethod
    def from_rows(
        cls, objects: Sequence[PlacedObject], rows: list[tuple[int, CoarseShape, tuple[float, float, float]]]
    ) -> ShapeColumns:
        """From (index of the object, one of its shapes, x, y and yaw of the object)."""
        number: dict[tuple[int, int], int] = {}
        ids = []
        for index, mark, _ in rows:
            # the crowns of one object have the same ids for any number of lobes
            key = (index, mark.lobes)
            number[key] = number.get(key, number.get((index, 0), 0) if mark.lobes else 0) + 1
            ids.append(f"{objects[index].id}.{number[key] - 1}" if number[key] > 1 else objects[index].id)
        marks = [mark for _, mark, _ in rows]
        instances = [objects[i].instance + mark.instance_offset if objects[i].instance else 0 for i, mark, _ in rows]
        return cls(
            owners=np.array([index for index, _, _ in rows], dtype=np.int64),
            shapes=np.array([SHAPES.index(mark.shape) for mark in marks], dtype=np.uint8),
            centers=np.array([mark.center for mark in marks], dtype=float).reshape(-1, 3),
            sizes=np.array([mark.size for mark in marks], dtype=float).reshape(-1, 3),
            labels=np.array([BY_NAME[mark.label].id for mark in marks], dtype=np.uint8),
            instances=np.array(instances, dtype=np.uint32),
            lobes=np.array([mark.lobes for mark in marks], dtype=np.int64),
            places=np.array([place for _, _, place in rows], dtype=float).reshape(-1, 3),
            ids=np.array(ids, dtype=object),
        )


class CoarseStreet:
    """The ground of a street and the coarse shapes of its objects, in the frame of the road.

    `scene` is the detailed scene of the `objects` along `road`, `middles` are those of the lanes across the road [m].
    Columns of the T objects: `places` f64 [T, 3] x, y, yaw; `levels` and `heights` f64 [T], of the ground under them
    without and with its relief; `instances` u32 [T]; `small` and `poles` bool [T]; `families` str [T], of `FAMILIES` or
    empty. `exact` are their true shapes, `solved` the nearest ones that the solver of sentences could have placed.
    `owners` i32 [P + 1] is the index of the object of each primitive of the scene: -1 for ground, and last for no
    primitive.
    """

    def __init__(self, road: Road, objects: Sequence[PlacedObject], scene: Layout, middles: Sequence[float]) -> None:
        self.objects = tuple(objects)
        number_of = {placed.id: number for number, placed in enumerate(self.objects)}
        self.owners = np.array([*(number_of.get(object_of(primitive), -1) for primitive in scene), -1], dtype=np.int32)
        self._flat = ShapeTable.from_primitives(road_surfaces(road))
        self._mesh = GroundMesh(road, [p for p in scene if p.label in GROUND and object_of(p) not in number_of])
        kinds = [kind_of(t.kind) for t in self.objects]
        exact = [
            (i, shape, t.place)
            for i, (t, kind) in enumerate(zip(self.objects, kinds, strict=True))
            for shape in kind.coarse(t)
        ]
        self.exact = ShapeColumns.from_rows(self.objects, exact)
        self.solved = ShapeColumns.from_rows(self.objects, solver_shapes(self.objects, road, middles))
        self.places = np.array([t.place for t in self.objects], dtype=float).reshape(-1, 3)
        self.levels = np.array([t.level for t in self.objects], dtype=float)
        self.heights = np.array([t.z for t in self.objects], dtype=float)
        self.instances = np.array([t.instance for t in self.objects], dtype=np.uint32)
        self.small = np.array([kind.is_small for kind in kinds], dtype=bool)
        self.poles = np.array([kind.on_pole for kind in kinds], dtype=bool)
        self.families = np.array([SENTENCE_KINDS[kind.word].family if kind.word else "" for kind in kinds], dtype=str)

    def ground(self, pose: np.ndarray, *, relief: bool, sidewalks: bool = True, reach: float = SEEN) -> ShapeTable:
        """The ground in the frame of the ego vehicle at street_from_ego `pose` [4, 4].

        With `relief` it rises and falls within `reach` [m], without it is the plane of the road under the ego vehicle.
        """
        ground = (self._mesh.around(pose, reach) if relief else self._flat).seen_from(*place_of(pose))
        return ground if sidewalks else ground.select(ground.labels != BY_NAME["sidewalk"].id)

    def heights_over(self, pose: np.ndarray) -> np.ndarray:
        """Heights [T] of the ground under the objects over the plane of the road under the ego vehicle [m]."""
        heights: np.ndarray = (np.column_stack([self.places[:, :2], self.heights]) - pose[:3, 3]) @ pose[:3, 2]
        return heights

    def standing(
        self,
        columns: ShapeColumns,
        chosen: np.ndarray,
        pose: np.ndarray,
        *,
        relief: bool,
        lobes: int = 1,
        errors: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> ShapeTable:
        """The shapes of the `chosen` objects, bool [T], on the ground, in the frame of the ego vehicle.

        `lobes` is the number of ellipsoids in a crown; `errors` are added to the places [T, 3] and multiply the extents
        [T, 3].
        """
        kept = np.flatnonzero(chosen[columns.owners] & ((columns.lobes == 0) | (columns.lobes == lobes)))
        owners = columns.owners[kept]
        centers, sizes, places = columns.centers[kept], columns.sizes[kept], columns.places[kept]
        if errors is not None:
            off, scale = errors
            places = places + off[owners]
            centers, sizes = centers * scale[owners], sizes * scale[owners]
        cos, sin = np.cos(places[:, 2]), np.sin(places[:, 2])
        x = places[:, 0] + cos * centers[:, 0] - sin * centers[:, 1]
        y = places[:, 1] + sin * centers[:, 0] + cos * centers[:, 1]
        heights = self.heights_over(pose) if relief else self.levels
        return ShapeTable(
            shapes=columns.shapes[kept],
            centers=np.column_stack([x, y, heights[owners] + centers[:, 2]]),
            sizes=sizes,
            yaws=places[:, 2],
            labels=columns.labels[kept],
            instances=columns.instances[kept],
            ids=tuple(columns.ids[kept].tolist()),
        ).seen_from(*place_of(pose))


def place_of(pose: np.ndarray) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad] of a pose [4, 4]."""
    return float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0])
