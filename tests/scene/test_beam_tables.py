"""The beam tables of sensors, as their makers print them."""

import re

import numpy as np

from lidardraft.scene import beam_tables


def tables() -> dict[str, tuple[float, ...]]:
    return {name: table for name, table in vars(beam_tables).items() if name.isupper()}


def test_every_elevation_table_falls_and_has_as_many_azimuths():
    elevations = {name: table for name, table in tables().items() if name.endswith("_ELEVATIONS")}
    assert len(elevations) >= 3
    for name, table in elevations.items():
        assert (np.diff(table) < 0).all(), name
        assert max(map(abs, table)) < 90.0
        azimuths = tables().get(name.replace("_ELEVATIONS", "_AZIMUTHS"))
        assert azimuths is None or len(azimuths) == len(table), name
        assert len(table) == int(re.findall(r"\d+", name.removesuffix("C_ELEVATIONS"))[-1]), name
