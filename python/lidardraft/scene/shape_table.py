"""Shapes as columns of numbers, for code that makes hundreds of shapes in a millisecond."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lidardraft import _core
from lidardraft.errors import LayoutError
from lidardraft.scene.intent import NOTHING_ASKED, Intent
from lidardraft.scene.layout import SHAPES, Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.pose import as_array
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import cast_scans, columns_of
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import CLASSES, NUM_CLASSES

_MESH = SHAPES.index("mesh")
_COLUMNS: dict[str, tuple[type[np.generic], tuple[int, ...]]] = {
    "shapes": (np.uint8, ()),
    "centers": (np.float64, (3,)),
    "sizes": (np.float64, (3,)),
    "yaws": (np.float64, ()),
    "labels": (np.uint8, ()),
    "instances": (np.uint32, ()),
}


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class ShapeTable:
    """P solid shapes, with a column for each field of a `Primitive`.

    `shapes` u8 [P] indices of `SHAPES`, `centers` and `sizes` f64 [P, 3] [m], `yaws` f64 [P] [rad], `labels` u8 [P]
    class ids, `instances` u32 [P], `ids` distinct names, `meshes` those of the shapes that are meshes, in their order.

    Columns of different lengths, unknown labels and repeated ids raise `LayoutError` here. Invalid sizes and places
    raise it in `scan`, in which the core checks every number, and in `layout`.
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
        for name, (dtype, axes) in _COLUMNS.items():
            column = np.ascontiguousarray(getattr(self, name), dtype=dtype)
            if column.shape != (count, *axes):
                raise LayoutError(f"{name} has shape {column.shape}; {count} ids need {(count, *axes)}")
            object.__setattr__(self, name, column)
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

    def __len__(self) -> int:
        return len(self.ids)

    def __repr__(self) -> str:
        return f"ShapeTable({len(self)} shapes)"

    @classmethod
    def from_primitives(cls, primitives: Iterable[Primitive]) -> ShapeTable:
        """The columns of primitives, without materials."""
        rows = list(primitives)
        meshes = tuple(p.mesh for p in rows if p.mesh is not None)
        return cls(**columns_of(rows), ids=tuple(p.id for p in rows), meshes=meshes)

    @classmethod
    def join(cls, *tables: ShapeTable) -> ShapeTable:
        """The shapes of several tables, in order."""
        columns = {name: np.concatenate([getattr(table, name) for table in tables]) for name in _COLUMNS}
        ids = tuple(id for table in tables for id in table.ids)
        return cls(**columns, ids=ids, meshes=tuple(mesh for table in tables for mesh in table.meshes))

    def select(self, chosen: np.ndarray) -> ShapeTable:
        """The table of the chosen shapes, bool [P]."""
        meshes = [mesh for mesh, kept in zip(self.meshes, chosen[self.shapes == _MESH].tolist(), strict=True) if kept]
        columns = {name: getattr(self, name)[chosen] for name in _COLUMNS}
        ids = tuple(id for id, kept in zip(self.ids, chosen.tolist(), strict=True) if kept)
        return ShapeTable(**columns, ids=ids, meshes=tuple(meshes))

    def seen_from(self, x: float, y: float, yaw: float) -> ShapeTable:
        """The shapes in an upright frame at (x, y) [m] with heading `yaw` [rad]."""
        cos, sin = math.cos(yaw), math.sin(yaw)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return replace(self, centers=(self.centers - (x, y, 0.0)) @ turn, yaws=self.yaws - yaw)

    def layout(
        self,
        provenance: dict[str, Any],
        coverage: tuple[float, float] | None = None,
        intent: Intent = NOTHING_ASKED,
    ) -> Layout:
        """The same shapes as a layout; raises `LayoutError` on the first invalid one."""
        meshes = iter(self.meshes)
        columns = [getattr(self, name).tolist() for name in _COLUMNS]
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
            for shape, center, size, yaw, label, instance, id in zip(*columns, self.ids, strict=True)
        )
        return Layout(primitives=tuple(primitives), provenance=provenance, coverage=coverage, intent=intent)

    def scan(self, sensor: Sensor, poses: np.ndarray, *, threads: int | None = None) -> RangeImage:
        """The scan of these shapes from one pose [4, 4] or one for each column [W, 4, 4]; bit for bit `raycast` of
        `self.layout({})`."""
        axes = ("N", 4, 4) if np.ndim(poses) == 3 else (4, 4)
        poses = as_array("poses", poses, *axes)
        columns = {name: getattr(self, name) for name in _COLUMNS}
        scene = _core.Scene(**columns, meshes=[(mesh.vertices, mesh.faces) for mesh in self.meshes])
        return cast_scans(scene, sensor, poses.reshape(1, -1, 4, 4), threads=threads)[0]
