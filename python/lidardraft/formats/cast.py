"""Casts of other renderers: an .npz file of images [H, W], and the sensor whose rays they are.

`depth` f32 or f64 [m], `label` of whole numbers; where they are known `instance`, `incidence`, `materials`, and
`sensor`, its JSON. A range image that `RangeImage.save` wrote is one.
"""

from __future__ import annotations

import os

import numpy as np

from lidardraft import array_files
from lidardraft.errors import FormatError
from lidardraft.scene.sensor import Sensor

_OPTIONAL = ("instance", "incidence", "materials")


def read_cast(path: str | os.PathLike[str], sensor: Sensor | None = None) -> tuple[Sensor, dict[str, np.ndarray]]:
    """The sensor, that of the file or else the one given, and the images: arguments of `observe_cast`.

    Raises `FormatError` naming the file where it is broken, or its images are not of that sensor.
    """
    with array_files.opened(path) as archive:
        if array_files.holds(archive, "sensor"):
            sensor = Sensor.from_json(array_files.read_text(archive, "sensor"))
        if sensor is None:
            raise FormatError("it does not name its sensor; give one")
        names = ("depth", "label", *(name for name in _OPTIONAL if array_files.holds(archive, name)))
        return sensor, {name: array_files.read_numbers(archive, name, sensor.shape) for name in names}
