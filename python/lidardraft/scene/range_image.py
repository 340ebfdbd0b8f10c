"""Range images, cast or generated: one scan, or a batch with one array for each image."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from operator import index
from typing import Any

import numpy as np

from lidardraft import array_files
from lidardraft.errors import LayoutError, SensorError
from lidardraft.files import written_whole
from lidardraft.scene.pose import finite_array, moved_by_column
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import NUM_CLASSES

# The images a scan can have and their types; all are [H, W] but the normal, which is [H, W, 3].
IMAGES: dict[str, np.dtype[Any]] = {
    "depth": np.dtype(np.float32),
    "label": np.dtype(np.uint8),
    "instance": np.dtype(np.uint32),
    "intensity": np.dtype(np.float32),
    "incidence": np.dtype(np.float32),
    "primitive": np.dtype(np.int32),
    "normal": np.dtype(np.float32),
}
_REQUIRED = ("depth", "label", "instance")


@dataclass(frozen=True, kw_only=True, eq=False)
class RangeImage:
    """Images of shape [H, W] of one scan of `sensor`.

    `depth` f32 is the distance along the ray [m], `label` u8 a class id, `instance` u32 the object. Optional:
    `intensity` f32 in [0, 1]; `incidence` f32, the cosine between ray and surface normal; `primitive` i32, the index
    of the primitive hit; `normal` f32 [H, W, 3], the unit normal of the surface in the world frame, turned towards the
    sensor. No return is depth 0, label 0, instance 0, intensity 0, incidence 0, primitive -1, normal 0, and False in
    `valid`.

    In an image with a pose for each column (rolling shutter), the sensor frame is that of each column: `points()` are
    as skewed as those of a real sensor on the move.
    """

    sensor: Sensor
    depth: np.ndarray
    label: np.ndarray
    instance: np.ndarray
    intensity: np.ndarray | None = None
    incidence: np.ndarray | None = None
    primitive: np.ndarray | None = None
    normal: np.ndarray | None = None

    def __post_init__(self) -> None:
        _check_images(self)

    @classmethod
    def unchecked(cls, sensor: Sensor, **images: np.ndarray) -> RangeImage:
        """The image of arrays known to fit `sensor`; to check every pixel would take longer than the scan."""
        image = object.__new__(cls)
        image.__dict__.update(images, sensor=sensor)
        return image

    @classmethod
    def empty(
        cls, sensor: Sensor, *, primitive: bool = False, incidence: bool = False, normal: bool = False
    ) -> RangeImage:
        """An image without returns, with these optional images: buffers for `Raycaster.scan(out=...)`."""
        return cls.unchecked(sensor, **blank_images(sensor.shape, primitive, incidence, normal))

    def __repr__(self) -> str:
        returns = np.count_nonzero(self.depth)
        return f"RangeImage({self.sensor!r}, {returns} returns with {', '.join(images_of(self))})"

    @property
    def valid(self) -> np.ndarray:
        """bool [H, W]: True for each pixel with a return."""
        return self.depth > 0

    def points(self, poses: np.ndarray | None = None) -> np.ndarray:
        """The returns in the sensor frame, f32 [N, 3], row by row; `image.label[image.valid]` is in the same order.

        With `poses`, the world_from_sensor [W, 4, 4] of each column, the points are in the world frame, f64 [N, 3]; the
        sensor moved, not the world. Raises `LayoutError` if `poses` has another shape.
        """
        points, returns = self.sensor.pattern.points(self.depth), np.flatnonzero(self.depth > 0)
        if poses is not None:
            points = moved_by_column(finite_array("poses", poses, self.sensor.columns, 4, 4), points)
        points = points.reshape(-1, 3).take(returns, axis=0)
        return points.astype(np.float32) if poses is None else points

    def keep(self, where: np.ndarray) -> RangeImage:
        """The image with the returns for which the mask [H, W] is True."""
        kept = {name: image.copy() for name, image in images_of(self).items()}
        blank_pixels(kept, ~where)
        return RangeImage.unchecked(self.sensor, **kept)

    def times(self) -> np.ndarray:
        """The time [s] of each return after the first column, f32 [N], in the order of `points`."""
        times: np.ndarray = self.sensor.column_times().astype(np.float32)[np.nonzero(self.valid)[1]]
        return times

    def beams(self) -> np.ndarray:
        """The beam (ring) of each return, u16 [N], in the order of `points`; beam 0 is the highest, the image's row 0.

        Other software often counts rings from the lowest beam: its ring is H - 1 - ring.
        """
        return np.nonzero(self.valid)[0].astype(np.uint16)

    @classmethod
    def project(
        cls,
        points: np.ndarray,
        sensor: Sensor,
        *,
        label: np.ndarray | None = None,
        instance: np.ndarray | None = None,
        intensity: np.ndarray | None = None,
    ) -> RangeImage:
        """The image of sensor-frame points [N, 3]. A pixel keeps its nearest point; points out of view are left out.

        The inverse of `points`. `label`, `instance` and `intensity` hold one value a point [N].
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise LayoutError(f"points have shape {points.shape}; they must be [N, 3]")
        if not np.isfinite(points).all():
            raise LayoutError(f"point {np.flatnonzero(~np.isfinite(points).all(axis=1))[0]} is not finite")
        row, column, depth = sensor.pattern.project(points)
        # Written from far to near: the nearest of several points in a pixel is written last and stays.
        order = np.argsort(-depth, kind="stable")
        order = order[row[order] >= 0]
        pixels = row[order], column[order]

        def image(name: str, values: np.ndarray | None) -> np.ndarray:
            picture = np.zeros(sensor.shape, dtype=IMAGES[name])
            if values is not None:
                if len(values) != len(points):
                    raise LayoutError(f"{name} has {len(values)} values for {len(points)} points")
                values = np.asarray(values)
                most = {"label": NUM_CLASSES - 1, "instance": 2**32 - 1}.get(name)
                wrong = values[:0] if most is None else values[~((values >= 0) & (values <= most) & (values % 1 == 0))]
                if len(wrong):
                    raise LayoutError(f"{name} holds {wrong[0]}; it must be whole numbers of 0 to {most}")
                if name == "intensity" and not np.isfinite(values).all():
                    raise LayoutError("an intensity is not finite")
                picture[pixels] = values[order]
            return picture

        return cls(
            sensor=sensor,
            depth=image("depth", depth),
            label=image("label", label),
            instance=image("instance", instance),
            intensity=None if intensity is None else image("intensity", intensity),
        )

    def save(self, path: str | os.PathLike[str], **more: Any) -> None:
        """Write sensor and images, and the arrays `more`, to a .npz file."""
        arrays: dict[str, Any] = {"sensor": np.array(self.sensor.to_json()), **images_of(self), **more}
        with written_whole(path) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, **arrays)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> RangeImage:
        """Raises `FormatError` if the file is not a range image, `SensorError` on an invalid value in an image."""
        with array_files.opened(path) as archive:
            sensor = Sensor.from_json(array_files.read_text(archive, "sensor"))
            images = {
                name: array_files.read_array(archive, name, dtype, _shape(sensor, name))
                for name, dtype in IMAGES.items()
                if name in _REQUIRED or array_files.holds(archive, name)
            }
            return cls(sensor=sensor, **images)


@dataclass(frozen=True, kw_only=True, eq=False)
class RangeImageBatch:
    """The images [N, H, W] of N scans of `sensor`; `batch[i]` is scan i, a view.

    The images are those of `RangeImage`: depth, label and instance; optional primitive, incidence and normal.
    """

    sensor: Sensor
    depth: np.ndarray
    label: np.ndarray
    instance: np.ndarray
    incidence: np.ndarray | None = None
    primitive: np.ndarray | None = None
    normal: np.ndarray | None = None

    def __post_init__(self) -> None:
        if self.depth.ndim != 3:
            raise SensorError(f"depth has shape {self.depth.shape}; a batch of {self.sensor.name} needs [N, H, W]")
        _check_images(self, self.depth.shape[:1])

    @classmethod
    def unchecked(cls, sensor: Sensor, **images: np.ndarray) -> RangeImageBatch:
        """The batch of arrays known to fit `sensor`, as in `RangeImage.unchecked`."""
        batch = object.__new__(cls)
        batch.__dict__.update(images, sensor=sensor)
        return batch

    @classmethod
    def empty(
        cls, sensor: Sensor, count: int, *, primitive: bool = False, incidence: bool = False, normal: bool = False
    ) -> RangeImageBatch:
        """`count` images without returns, with these optional images: buffers for `Raycaster.scan_batch(out=...)`."""
        if count < 0:
            raise SensorError(f"count is {count}; it must be 0 or more")
        return cls.unchecked(sensor, **blank_images((count, *sensor.shape), primitive, incidence, normal))

    def __len__(self) -> int:
        return len(self.depth)

    def __repr__(self) -> str:
        return f"RangeImageBatch({len(self)} of {self.sensor!r} with {', '.join(images_of(self))})"

    def __getitem__(self, i: int) -> RangeImage:
        i = index(i)
        return RangeImage.unchecked(self.sensor, **{name: array[i] for name, array in images_of(self).items()})

    def __iter__(self) -> Iterator[RangeImage]:
        return (self[i] for i in range(len(self)))


def images_of(scan: RangeImage | RangeImageBatch) -> dict[str, np.ndarray]:
    """The images that are not None, by name."""
    return {name: image for name in IMAGES if (image := getattr(scan, name, None)) is not None}


def _check_images(scan: RangeImage | RangeImageBatch, count: tuple[int, ...] = ()) -> None:
    """Raises `SensorError` if images [*count, H, W] do not fit the sensor or hold invalid values."""
    for name, image in images_of(scan).items():
        shape = (*count, *_shape(scan.sensor, name))
        if image.shape != shape or image.dtype != IMAGES[name]:
            raise SensorError(f"{name} is {image.dtype} {image.shape}; {scan.sensor.name} needs {IMAGES[name]} {shape}")
    if not np.isfinite(scan.depth).all() or scan.depth.min(initial=0) < 0:
        wrong = scan.depth[~(np.isfinite(scan.depth) & (scan.depth >= 0))]
        raise SensorError(f"depth holds {wrong[0]}; it must be finite and 0 or more")
    if scan.label.max(initial=0) >= NUM_CLASSES:
        raise SensorError(f"label holds {scan.label.max()}; class ids are 0 to {NUM_CLASSES - 1}")


def _shape(sensor: Sensor, name: str) -> tuple[int, ...]:
    return (*sensor.shape, 3) if name == "normal" else sensor.shape


# The core writes a cache line at once; images aligned to one need no second line.
_LINE = 64  # bytes


def new_images(shape: tuple[int, ...], primitive: bool, incidence: bool, normal: bool) -> dict[str, np.ndarray]:
    """Uninitialised buffers of a scan: depth, label, instance and the requested optional images, each [*shape]."""
    pixels = math.prod(shape)
    # One block of memory for all: the allocator reuses one block of this size again and again, but returns several to
    # the system, which then takes longer to make new pages of zeros than the core takes to scan.
    block = np.empty(pixels * (9 + 4 * primitive + 4 * incidence + 12 * normal) + _LINE, np.uint8)
    images, start = {}, -block.__array_interface__["data"][0] % _LINE
    optional = [n for n, wanted in (("primitive", primitive), ("incidence", incidence), ("normal", normal)) if wanted]
    for name in ("depth", "instance", *optional, "label"):  # the label is one byte wide and would leave others askew
        image = np.ndarray((*shape, 3) if name == "normal" else shape, IMAGES[name], block, start)
        images[name], start = image, start + image.nbytes
    return images


def blank_images(shape: tuple[int, ...], primitive: bool, incidence: bool, normal: bool) -> dict[str, np.ndarray]:
    """The images of `new_images`, all pixels without a return."""
    images = new_images(shape, primitive, incidence, normal)
    for name, image in images.items():
        image.fill(-1 if name == "primitive" else 0)
    return images


def blank_pixels(images: Mapping[str, np.ndarray], pixels: np.ndarray) -> None:
    """Clear the returns of `images` [..., H, W] and [..., H, W, 3] for which `pixels` [H, W] is True."""
    for name, image in images.items():
        where = pixels[..., None] if name == "normal" else pixels
        np.copyto(image, image.dtype.type(-1 if name == "primitive" else 0), where=where)
