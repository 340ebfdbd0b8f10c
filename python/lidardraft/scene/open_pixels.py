"""The pixels of a scan that a layout leaves open, because its source does not say what is there."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage


def open_pixels(layout: Layout, condition_image: RangeImage, pose: np.ndarray) -> np.ndarray:
    """The pixels that a layout leaves open to a sensor at world_from_sensor `pose` [4, 4], bool [H, W].

    A pixel is open where the ray of `condition_image`, the cast with the image `primitive`, hits a shape that is `open`
    or, in a layout that has one, no shape at all; and outside the layout's coverage. Pixels that the vehicle hides are
    never open.
    """
    if condition_image.primitive is None:
        raise LayoutError("the condition image has no primitives; cast it with primitive=True")
    of_shape = np.array([primitive.open for primitive in layout], dtype=bool)
    # -1, the last, is a ray that hits nothing
    found: np.ndarray = np.append(of_shape, of_shape.any())[condition_image.primitive]
    sensor = condition_image.sensor
    if layout.coverage is not None:
        start, end = layout.coverage
        seen_from = math.atan2(pose[1, 0], pose[0, 0]) - start
        found = found | ((sensor.azimuths + seen_from) % (2 * math.pi) > end - start)
    return found & ~sensor.blocked_pixels
