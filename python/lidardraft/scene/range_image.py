"""The range image: what a sensor saw, drawn or generated alike."""

from __future__ import annotations

import os
import zipfile
import zlib
from dataclasses import dataclass, fields

import numpy as np

from lidardraft.errors import FormatError, LayoutError, SensorError
from lidardraft.files import written_whole
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import NUM_CLASSES

_DTYPES = {
    "depth": np.float32,
    "label": np.uint8,
    "instance": np.uint32,
    "intensity": np.float32,
    "incidence": np.float32,
    "primitive": np.int32,
}
# What numpy raises on a file that is missing, truncated, corrupt or another kind of file.
_BROKEN = (OSError, EOFError, KeyError, TypeError, ValueError, AttributeError, zipfile.BadZipFile, zlib.error)


@dataclass(frozen=True, kw_only=True, eq=False)
class RangeImage:
    """Images of shape [H, W] of one scan of `sensor`.

    `depth` f32 is the distance along the ray [m], `label` u8 a class id, `instance` u32 the object. Optional:
    `intensity` f32 in [0, 1]; `incidence` f32, the cosine between ray and surface normal; `primitive` i32, the index
    of the primitive hit. No return is depth 0, label 0, instance 0, intensity 0, incidence 0, primitive -1, and False
    in `valid`.
    """

    sensor: Sensor
    depth: np.ndarray
    label: np.ndarray
    instance: np.ndarray
    intensity: np.ndarray | None = None
    incidence: np.ndarray | None = None
    primitive: np.ndarray | None = None

    def __post_init__(self) -> None:
        for name, dtype in _DTYPES.items():
            image = getattr(self, name)
            if image is None:
                continue
            if image.shape != self.sensor.shape or image.dtype != dtype:
                needed = f"{np.dtype(dtype)} {self.sensor.shape}"
                raise SensorError(f"{name} is {image.dtype} {image.shape}; {self.sensor.name} needs {needed}")
        if not np.isfinite(self.depth).all() or self.depth.min(initial=0) < 0:
            raise SensorError("depth holds what is no distance; it must be finite and 0 or more")
        if self.label.max(initial=0) >= NUM_CLASSES:
            raise SensorError(f"label holds {self.label.max()}; class ids are 0 to {NUM_CLASSES - 1}")

    @property
    def valid(self) -> np.ndarray:
        """bool [H, W]: where there is a return."""
        return self.depth > 0

    def points(self) -> np.ndarray:
        """The returns in the sensor frame, f32 [N, 3], row by row; `image.label[image.valid]` is in the same order."""
        return self.sensor.pattern.points(self.depth)[self.valid].astype(np.float32)

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
        """The image of sensor-frame points [N, 3]; the nearest wins a pixel, points out of view are left out.

        The inverse of `points`. `label`, `instance` and `intensity` hold one value a point [N].
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise LayoutError(f"points have shape {points.shape}; they must be [N, 3]")
        if not np.isfinite(points).all():
            raise LayoutError(f"point {np.flatnonzero(~np.isfinite(points).all(axis=1))[0]} is not finite")
        row, column, depth = sensor.pattern.project(points)
        # Written from far to near: of several points in a pixel the last one written, the nearest, stays.
        order = np.argsort(-depth, kind="stable")
        order = order[row[order] >= 0]
        pixels = row[order], column[order]

        def image(name: str, values: np.ndarray | None) -> np.ndarray:
            picture = np.zeros(sensor.shape, dtype=_DTYPES[name])
            if values is not None:
                if len(values) != len(points):
                    raise LayoutError(f"{name} has {len(values)} values for {len(points)} points")
                values = np.asarray(values)
                if name == "label" and len(values) and not 0 <= values.min() <= values.max() < NUM_CLASSES:
                    raise LayoutError(f"label holds {values.min()} to {values.max()}; ids are 0 to {NUM_CLASSES - 1}")
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

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write sensor and images to a .npz file."""
        images = {name: getattr(self, name) for name in _DTYPES if getattr(self, name) is not None}
        with written_whole(path) as temporary, temporary.open("wb") as file:
            np.savez_compressed(file, sensor=np.array(self.sensor.to_json()), **images)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> RangeImage:
        """Raises `FormatError` where the file is no range image."""
        names = [field.name for field in fields(cls)]
        try:
            with open(path, "rb") as file, np.load(file, allow_pickle=False) as arrays:
                images = {name: arrays[name] for name in names if name in arrays}
            return cls(**{**images, "sensor": Sensor.from_json(str(images["sensor"]))})
        except _BROKEN as error:
            raise FormatError(f"{os.fspath(path)} is not a range image: {error}") from None
