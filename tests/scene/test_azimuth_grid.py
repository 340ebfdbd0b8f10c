"""What stands side by side in the grid looks side by side."""

import dataclasses
import math

import numpy as np
import pytest

from lidardraft.scene.azimuth_grid import azimuth_grid
from lidardraft.scene.sensor import Sensor

SECTOR = {"azimuth_start": 0.7, "azimuth_span": 1.4, "columns": 400}


@pytest.mark.parametrize("fields", [{}, SECTOR])
@pytest.mark.parametrize("name", ["vlp32c", "vlp16"])
def test_each_column_looks_to_one_azimuth_and_each_pixel_is_there_once(name: str, fields: dict[str, float]) -> None:
    sensor = dataclasses.replace(Sensor.preset(name), **fields)
    rows, columns, inside = azimuth_grid(sensor)
    assert rows.shape == columns.shape == inside.shape
    assert (rows.shape[1] == sensor.columns) == (sensor.wraps or not sensor.azimuth_offsets)
    counts = np.zeros(sensor.shape, int)
    np.add.at(counts, (rows[inside], columns[inside]), 1)
    assert (counts == 1).all()
    step = sensor.azimuth_span / sensor.columns
    offsets = np.array(sensor.azimuth_offsets or [0.0] * len(sensor.elevations))
    azimuth = sensor.azimuth_start - (columns + 0.5) * step + offsets[rows]
    middle = azimuth[np.argmax(inside, axis=0), np.arange(rows.shape[1])]
    apart = np.abs((azimuth - middle + math.pi) % (2 * math.pi) - math.pi)
    assert apart[inside].max() <= step * 1.001
