"""Pixels side by side that look side by side: the lasers of many sensors fire together in different directions."""

from __future__ import annotations

import numpy as np

from lidardraft.scene.sensor import Sensor


def azimuth_grid(sensor: Sensor) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row and column [H, W'] of each pixel of a grid whose columns look to one azimuth, and whether there is one.

    Beams with offsets in azimuth look past each other in one column of the image, by up to 10 degrees. Where the sensor
    wraps W' is W; else the grid is as much wider as the beams look past each other, and some of it is not in the image.
    """
    beams, width = sensor.shape
    offsets = np.array(sensor.azimuth_offsets or [0.0] * beams)
    shifts = np.rint(offsets / (sensor.azimuth_span / width)).astype(np.intp)
    more = 0 if sensor.wraps else int(np.abs(shifts).max())
    columns = np.arange(-more, width + more)[None, :] + shifts[:, None]
    inside = (columns >= 0) & (columns < width) | sensor.wraps
    return np.broadcast_to(np.arange(beams)[:, None], columns.shape), columns % width, inside
