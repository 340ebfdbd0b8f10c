"""Casts of other renderers: an .npz file of images [H, W], and the sensor of its rays.

`depth` f32 or f64 [m], `label` of whole numbers; optional are `instance`, `incidence`, `materials`, and `sensor`, its
JSON. A file that `RangeImage.save` wrote is one.
"""

from __future__ import annotations

import os

import numpy as np

from lidardraft import array_files
from lidardraft.errors import FormatError
from lidardraft.scene.sensor import Sensor

_OPTIONAL = ("instance", "incidence", "materials")


def read_cast(path: str | os.PathLike[str], sensor: Sensor | None = None) -> tuple[Sensor, dict[str, np.ndarray]]:
    """The sensor, from the file or else the given one, and the images: arguments of `observe_cast`.

    Raises `FormatError` naming the file if it is broken, or if its images do not fit the sensor.
    """
    with array_files.opened(path) as archive:
        if array_files.holds(archive, "sensor"):
            sensor = Sensor.from_json(array_files.read_text(archive, "sensor"))
        if sensor is None:
            raise FormatError("it does not name its sensor; give one")
        names = ("depth", "label", *(name for name in _OPTIONAL if array_files.holds(archive, name)))
        return sensor, {name: array_files.read_numbers(archive, name, sensor.shape) for name in names}
