"""Many scans by one sensor in one array each: what training and bulk data read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from operator import index

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.scene.range_image import IMAGES, RangeImage, blank_images, check_images
from lidardraft.scene.sensor import Sensor


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
        check_images(self.sensor, vars(self), self.depth.shape[:1])

    @classmethod
    def unchecked(cls, sensor: Sensor, **images: np.ndarray) -> RangeImageBatch:
        """The batch of arrays that are known to fit `sensor`, as in `RangeImage.unchecked`."""
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

    def __getitem__(self, i: int) -> RangeImage:
        i = index(i)
        images = {name: getattr(self, name, None) for name in IMAGES}
        return RangeImage.unchecked(self.sensor, **{k: array[i] for k, array in images.items() if array is not None})

    def __iter__(self) -> Iterator[RangeImage]:
        return (self[i] for i in range(len(self)))
