"""Casts of a layout: scans of sensors, and single rays. The rays are in the core."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any
from zlib import crc32

import numpy as np

from lidardraft import _core
from lidardraft.errors import LayoutError, SensorError, check_seed, check_type
from lidardraft.scene.layout import SHAPES, Layout, Primitive, box_around, object_of
from lidardraft.scene.pose import as_array, finite_array, inverse, upright
from lidardraft.scene.range_image import RangeImage, RangeImageBatch, blank_pixels, images_of, new_images
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME

_OPTIONAL = ("primitive", "incidence", "normal")


def backends() -> list[str]:
    """The backends that this machine can cast scans with, the fastest first: some of "avx512", "avx2", "portable", and
    always "reference".
    """
    return _core.backends()


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """The closest hits of R rays, in the world frame.

    `distance` f32 [R] is that from the ray's origin [m], `label` u8 a class id, `instance` u32 the object, `primitive`
    i32 the index of the primitive; `normal` f32 [R, 3] is the unit normal of the surface, turned towards the origin. No
    hit is distance 0, label 0, instance 0, primitive -1, normal 0, and False in `valid`.
    """

    origins: np.ndarray
    directions: np.ndarray
    distance: np.ndarray
    label: np.ndarray
    instance: np.ndarray
    primitive: np.ndarray
    normal: np.ndarray

    def __len__(self) -> int:
        return len(self.distance)

    @property
    def valid(self) -> np.ndarray:
        """bool [R]: True for each ray that hits something."""
        return self.primitive >= 0

    def points(self) -> np.ndarray:
        """The hit points of the rays that are `valid`, f64 [N, 3], in their order."""
        hit = self.valid
        along = self.directions[hit] / np.linalg.norm(self.directions[hit], axis=1, keepdims=True)
        points: np.ndarray = self.origins[hit] + along * self.distance[hit, None]
        return points

    def keep(self, where: np.ndarray) -> Hits:
        """The hits of the rays for which the mask [R] is True."""
        return Hits(*(getattr(self, field.name)[where] for field in fields(self)))


class Raycaster:
    """A layout compiled once, to be scanned from many poses.

    `layout` is the layout as compiled: `move` changes the casts, but not `layout`. Copies, also those in other
    processes, are compiled again, with all moves.

    `seed` decides how far rays travel in media (`Primitive.extinction`), as a pure function of seed, primitive, and row
    and column of a scan or number of a ray. A primitive counts by its number in the layout or, with `by_id`, by its id:
    then free paths in it stay the same when other primitives come and go. `threads` is the largest number of threads of
    a call, by default the number of cores (`RAYON_NUM_THREADS`); results are the same bit for bit for any number.

    Images are written into `out` and `out` is returned. It is an image or batch of the same sensor, made by an earlier
    call or by `empty`, and decides which optional images are written. Everything is checked before anything is written.
    Raises `LayoutError` on poses of another shape or not rigid, `SensorError` on an `out` that does not fit the
    call, and `TypeError` on one whose arrays cannot be written in place.
    """

    def __init__(self, layout: Layout, *, by_id: bool = False) -> None:
        check_type("layout", layout, Layout)
        self.layout, self._by_id = layout, by_id
        self._places: dict[int, np.ndarray] = {}  # world_from_primitive of those that `move` has moved
        self._scene = compiled(layout.primitives, by_id=by_id)

    def scan(
        self,
        sensor: Sensor,
        pose: np.ndarray | None = None,
        *,
        poses: np.ndarray | None = None,
        out: RangeImage | None = None,
        primitive: bool = False,
        incidence: bool = False,
        normal: bool = False,
        seed: int = 0,
        threads: int | None = None,
    ) -> RangeImage:
        """The scan of `sensor` at `pose`, world_from_sensor [4, 4]; by default on its mount over the origin.

        `poses` [W, 4, 4] gives each column its own pose instead: a rolling shutter, as of a sensor that moves while it
        sweeps (`Sensor.poses_in_motion`). The image has depth, label, instance and the requested optional images; they
        share one block of memory, which each of them keeps alive.
        """
        world_from_sensor = _pose_of_scan(sensor, pose, poses)
        optional = (primitive, incidence, normal)
        one = None if out is None else _batch_of_one(out)
        batch = cast_scans(self._scene, sensor, world_from_sensor, one, optional, seed, threads)
        return batch[0] if out is None else out

    def scan_batch(
        self,
        sensor: Sensor,
        poses: np.ndarray,
        *,
        out: RangeImageBatch | None = None,
        primitive: bool = False,
        incidence: bool = False,
        normal: bool = False,
        seed: int = 0,
        threads: int | None = None,
    ) -> RangeImageBatch:
        """The scans of `sensor` at `poses` [N, 4, 4], or [N, W, 4, 4] with one for each column.

        Image i is that of `scan` with pose i and `seed` + i, bit for bit; the threads share the scans.
        """
        world_from_sensor = _poses_of_batch(sensor, poses)
        if out is not None:
            check_type("out", out, RangeImageBatch)
        return cast_scans(self._scene, sensor, world_from_sensor, out, (primitive, incidence, normal), seed, threads)

    def cast(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        *,
        max_range: float = math.inf,
        seed: int = 0,
        threads: int | None = None,
    ) -> Hits:
        """The first hits of any rays, up to `max_range` [m].

        `directions` are [R, 3], `origins` one for all of them [3], or one for each [R, 3], in the world frame.
        Directions need not have length 1. Raises `LayoutError` on a ray that is not finite or has no direction, and on
        a `max_range` that is not more than 0.
        """
        directions = as_array("directions", directions, "R", 3)
        if _axes(origins) == 1:
            origins = np.tile(as_array("origins", origins, 3), (len(directions), 1))
        else:
            origins = as_array("origins", origins, "R", 3)
        if len(origins) != len(directions):
            raise LayoutError(f"{len(origins)} origins and {len(directions)} directions; a ray has one of each")
        found = self._scene.cast(origins, directions, max_range=max_range, seed=check_seed(seed), threads=threads or 0)
        return Hits(origins, directions, *found)

    def move(self, id: str, pose: np.ndarray) -> None:
        """Move an object (all parts that share `id` up to the dot), or the one primitive `id`.

        `pose` is its new pose in the world, world_from_object [4, 4], rigid; it may be tilted. The object's frame is
        that of its box: the centre and yaw of a primitive, or of the box around several parts in `layout`, as
        `Layout.boxes` gives it. Nothing else is compiled again. Raises `LayoutError` on an id that the layout does not
        have and on a pose that is not rigid.
        """
        pose = finite_array("pose", pose, 4, 4)
        indices = self._indices(id)
        parts = [self.layout.primitives[i] for i in indices]
        poses = pose[None] if len(parts) == 1 else pose @ _parts_in_object(parts)
        self._put(dict(zip(indices, poses, strict=True)))

    def _put(self, places: dict[int, np.ndarray]) -> None:
        self._scene = self._scene.moved(np.array(list(places), dtype=np.uint32), np.array(list(places.values())))
        self._places |= places

    def __getstate__(self) -> dict[str, Any]:
        # the core's scene cannot go to another process; it is compiled again there
        return {"layout": self.layout, "by_id": self._by_id, "places": self._places}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["layout"], by_id=state["by_id"])  # type: ignore[misc]
        if state["places"]:
            self._put(state["places"])

    def _indices(self, id: str) -> list[int]:
        found = self._parts.get(id) or [i for i, p in enumerate(self.layout) if p.id == id]
        if not found:
            raise self.layout.unknown(id)
        return found

    @cached_property
    def _parts(self) -> dict[str, list[int]]:
        """The indices of the parts of each object, by its name."""
        parts: dict[str, list[int]] = {}
        for index, primitive in enumerate(self.layout):
            parts.setdefault(object_of(primitive), []).append(index)
        return parts


def compiled(primitives: Sequence[Primitive], *, by_id: bool) -> _core.Scene:
    """The core's scene of the shapes; `by_id` is that of `Raycaster`."""
    return _core.Scene(
        **columns_of(primitives),
        meshes=[(p.mesh.vertices, p.mesh.faces) for p in primitives if p.mesh is not None],
        extinctions=np.array([p.extinction or 0.0 for p in primitives], dtype=np.float64),
        media=np.array([crc32(p.id.encode()) for p in primitives], dtype=np.uint32) if by_id else None,
    )


def columns_of(primitives: Sequence[Primitive]) -> dict[str, np.ndarray]:
    """The P shapes as the core takes them: a column [P] or [P, 3] for each field but meshes and media."""
    return {
        "shapes": np.array([SHAPES.index(p.shape) for p in primitives], dtype=np.uint8),
        "centers": np.array([p.center for p in primitives], dtype=np.float64).reshape(-1, 3),
        "sizes": np.array([p.size for p in primitives], dtype=np.float64).reshape(-1, 3),
        "yaws": np.array([p.yaw for p in primitives], dtype=np.float64),
        "labels": np.array([BY_NAME[p.label].id for p in primitives], dtype=np.uint8),
        "instances": np.array([p.instance for p in primitives], dtype=np.uint32),
    }


def raycast(
    layout: Layout,
    sensor: Sensor,
    pose: np.ndarray | None = None,
    *,
    poses: np.ndarray | None = None,
    out: RangeImage | None = None,
    primitive: bool = False,
    incidence: bool = False,
    normal: bool = False,
    seed: int = 0,
    threads: int | None = None,
) -> RangeImage:
    """The scan of `layout` by `sensor`: `Raycaster(layout).scan(sensor, pose, ...)`."""
    return Raycaster(layout).scan(
        sensor,
        pose,
        poses=poses,
        out=out,
        primitive=primitive,
        incidence=incidence,
        normal=normal,
        seed=seed,
        threads=threads,
    )


def cast_scans(
    scene: _core.Scene,
    sensor: Sensor,
    world_from_sensor: np.ndarray,
    out: RangeImageBatch | None = None,
    optional: tuple[bool, bool, bool] = (False, False, False),
    seed: int = 0,
    threads: int | None = None,
) -> RangeImageBatch:
    """The scans from poses [N, K, 4, 4], in `out` or in a new batch with the `optional` images: primitive, incidence
    and normal.
    """
    count = len(world_from_sensor)
    seed = check_seed(seed)
    if out is None:
        out = RangeImageBatch.unchecked(sensor, **new_images((count, *sensor.shape), *optional))
    else:
        _check_out(out, sensor, optional)
        if len(out) != count:
            raise SensorError(f"out holds {len(out)} images; there are {count} poses")
    images: dict[str, Any] = images_of(out)
    if count:  # images without a pixel all have one address, which looks like shared memory
        scene.scan(sensor.pattern, world_from_sensor, **images, seed=seed, threads=threads or 0)
    if sensor.blocked:
        blank_pixels(images, sensor.blocked_pixels)
    return out


def _pose_of_scan(sensor: Sensor, pose: np.ndarray | None, poses: np.ndarray | None) -> np.ndarray:
    check_type("sensor", sensor, Sensor)
    if poses is None:
        return as_array("pose", sensor.pose() if pose is None else pose, 4, 4)[None, None]
    if pose is not None:
        raise LayoutError("pose and poses are both given; a scan has one pose, or one for each column")
    return as_array("poses", poses, sensor.columns, 4, 4)[None]


def _poses_of_batch(sensor: Sensor, poses: np.ndarray) -> np.ndarray:
    check_type("sensor", sensor, Sensor)
    if _axes(poses) == 4:
        return as_array("poses", poses, "N", sensor.columns, 4, 4)
    return as_array("poses", poses, "N", 4, 4)[:, None]


def _axes(values: np.ndarray) -> int:
    try:
        return np.ndim(values)
    except ValueError:  # a ragged list, which `as_array` reports
        return 0


def _batch_of_one(out: RangeImage) -> RangeImageBatch:
    """An image as a batch, in the same memory."""
    check_type("out", out, RangeImage)
    if out.intensity is not None:
        raise SensorError("out has an intensity; a scan writes none, and would leave that of another scan")
    return RangeImageBatch.unchecked(out.sensor, **{name: array[None] for name, array in images_of(out).items()})


def _check_out(out: RangeImageBatch, sensor: Sensor, asked: tuple[bool, bool, bool]) -> None:
    if out.sensor is not sensor and out.sensor != sensor:
        which = "another sensor of that name" if out.sensor.name == sensor.name else out.sensor.name
        raise SensorError(f"out is of {which}; the scan is of {sensor.name}")
    for name, wanted in zip(_OPTIONAL, asked, strict=True):
        if wanted and getattr(out, name) is None:
            raise SensorError(f"out has no {name}, and {name}=True asks for it")


def _parts_in_object(parts: list[Primitive]) -> np.ndarray:
    """object_from_part [M, 4, 4] of the parts, as in the layout."""
    box = box_around(parts)
    poses: np.ndarray = inverse(upright(box.center, box.yaw)) @ np.array([upright(p.center, p.yaw) for p in parts])
    return poses
