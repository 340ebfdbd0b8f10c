"""Shapes as columns of numbers: what a layout is where there are hundreds of shapes a millisecond."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lidardraft import _core
from lidardraft.errors import LayoutError
from lidardraft.scene.layout import SHAPES, Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.pose import as_array
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import cast_scans
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, CLASSES, NUM_CLASSES

_MESH = SHAPES.index("mesh")
_COLUMNS = ("shapes", "centers", "sizes", "yaws", "labels", "instances")


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class ShapeTable:
    """P solid shapes, a column each for what a `Primitive` has.

    `shapes` u8 [P] indices of `SHAPES`, `centers` and `sizes` f64 [P, 3] [m], `yaws` f64 [P] [rad], `labels` u8 [P]
    class ids, `instances` u32 [P], `ids` distinct names, `meshes` those of the shapes that are meshes, in their order.

    Columns of different lengths, labels that are no class and ids that are not distinct raise `LayoutError` here, and
    numbers that are no shape when it is cast: the core looks at every one of them. `layout` checks all of it again.
    """

    shapes: np.ndarray
    centers: np.ndarray
    sizes: np.ndarray
    yaws: np.ndarray
    labels: np.ndarray
    instances: np.ndarray
    ids: tuple[str, ...]
    meshes: tuple[TriangleMesh, ...] = ()

    def __post_init__(self) -> None:
        count = len(self.ids)
        for name, shape in (("centers", (count, 3)), ("sizes", (count, 3)), ("yaws", (count,))):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=np.float64))
            self._check_column(name, shape)
        for name, dtype in (("shapes", np.uint8), ("labels", np.uint8), ("instances", np.uint32)):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=dtype))
            self._check_column(name, (count,))
        bad = np.flatnonzero((self.labels == 0) | (self.labels >= NUM_CLASSES))
        if len(bad):
            raise LayoutError(f"{self.ids[bad[0]]}: label is {self.labels[bad[0]]}; it must be 1 to {NUM_CLASSES - 1}")
        if len(set(self.ids)) != count:
            seen: set[str] = set()
            twice = next(name for name in self.ids if name in seen or seen.add(name))  # type: ignore[func-returns-value]
            raise LayoutError(f"{twice}: two shapes have this id; ids must be distinct")
        meshes = np.count_nonzero(self.shapes == _MESH)
        if meshes != len(self.meshes):
            raise LayoutError(f"{meshes} shapes are meshes; there are {len(self.meshes)} meshes for them")

    def _check_column(self, name: str, shape: tuple[int, ...]) -> None:
        found = getattr(self, name).shape
        if found != shape:
            raise LayoutError(f"{name} has shape {found}; {len(self.ids)} ids need {shape}")

    def __len__(self) -> int:
        return len(self.ids)

    @classmethod
    def from_primitives(cls, primitives: Iterable[Primitive]) -> ShapeTable:
        """The columns of primitives; materials are not among them."""
        rows = list(primitives)
        return cls(
            shapes=np.array([SHAPES.index(p.shape) for p in rows], dtype=np.uint8),
            centers=np.array([p.center for p in rows], dtype=np.float64).reshape(-1, 3),
            sizes=np.array([p.size for p in rows], dtype=np.float64).reshape(-1, 3),
            yaws=np.array([p.yaw for p in rows], dtype=np.float64),
            labels=np.array([BY_NAME[p.label].id for p in rows], dtype=np.uint8),
            instances=np.array([p.instance for p in rows], dtype=np.uint32),
            ids=tuple(p.id for p in rows),
            meshes=tuple(p.mesh for p in rows if p.mesh is not None),
        )

    @classmethod
    def join(cls, *tables: ShapeTable) -> ShapeTable:
        """The shapes of several tables, one after the other."""
        columns = {name: np.concatenate([getattr(table, name) for table in tables]) for name in _COLUMNS}
        ids = tuple(id for table in tables for id in table.ids)
        return cls(**columns, ids=ids, meshes=tuple(mesh for table in tables for mesh in table.meshes))

    def select(self, chosen: np.ndarray) -> ShapeTable:
        """The chosen shapes, bool [P], alone."""
        meshes = [mesh for mesh, kept in zip(self.meshes, chosen[self.shapes == _MESH].tolist(), strict=True) if kept]
        columns = {name: getattr(self, name)[chosen] for name in _COLUMNS}
        ids = tuple(id for id, kept in zip(self.ids, chosen.tolist(), strict=True) if kept)
        return ShapeTable(**columns, ids=ids, meshes=tuple(meshes))

    def seen_from(self, x: float, y: float, yaw: float) -> ShapeTable:
        """The shapes in the frame of who stands upright at (x, y) [m] and looks along `yaw` [rad]."""
        cos, sin = math.cos(yaw), math.sin(yaw)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return replace(self, centers=(self.centers - (x, y, 0.0)) @ turn, yaws=self.yaws - yaw)

    def layout(self, provenance: dict[str, Any], coverage: tuple[float, float] | None = None) -> Layout:
        """The same shapes as a layout; raises `LayoutError` on the first that is none."""
        meshes = iter(self.meshes)
        columns = zip(
            self.shapes.tolist(),
            self.centers.tolist(),
            self.sizes.tolist(),
            self.yaws.tolist(),
            self.labels.tolist(),
            self.instances.tolist(),
            self.ids,
            strict=True,
        )
        primitives = (
            Primitive(
                shape=SHAPES[shape],
                center=center,
                size=size,
                yaw=yaw,
                label=CLASSES[label].name,
                instance=instance,
                id=id,
                mesh=next(meshes) if shape == _MESH else None,
            )
            for shape, center, size, yaw, label, instance, id in columns
        )
        return Layout(primitives=tuple(primitives), provenance=provenance, coverage=coverage)

    def scan(self, sensor: Sensor, poses: np.ndarray, *, threads: int | None = None) -> RangeImage:
        """What `sensor` sees from one pose [4, 4] or from one for each column [W, 4, 4].

        It is what `raycast` has of `self.layout({})`, bit for bit.
        """
        axes = ("N", 4, 4) if np.ndim(poses) == 3 else (4, 4)
        poses = as_array("poses", poses, *axes)
        scene = _core.Scene(
            shapes=self.shapes,
            centers=self.centers,
            sizes=self.sizes,
            yaws=self.yaws,
            labels=self.labels,
            instances=self.instances,
            meshes=[(mesh.vertices, mesh.faces) for mesh in self.meshes],
        )
        return cast_scans(scene, sensor, poses.reshape(1, -1, 4, 4), threads=threads)[0]
