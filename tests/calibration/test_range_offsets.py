"""Offsets that are known are found again, up to what neighbours have in common."""

from dataclasses import replace

import numpy as np
import pytest
from test_beam_table import ROOM

from lidardraft import Sensor, raycast
from lidardraft.calibration.beam_table import BeamTable
from lidardraft.calibration.range_offsets import fit_range_offsets
from lidardraft.metrics.sweep import Sweep

LASERS = 24
SENSOR = Sensor(
    name="truth",
    elevations=tuple(np.deg2rad(np.linspace(4.0, -20.0, LASERS)).tolist()),
    origin_heights=(0.1,) * (LASERS // 2) + (0.0,) * (LASERS // 2),
    columns=512,
    mount_height=1.8,
)
TABLE = BeamTable(
    rings=np.arange(LASERS),
    elevations=np.array(SENSOR.elevations),
    heights=np.array(SENSOR.origin_heights),
    azimuth_offsets=np.zeros(LASERS),
    columns=512,
    residual=0.0,
    angle_residual=0.0,
)


def sweeps(offsets: np.ndarray, *, sensor: Sensor = SENSOR) -> list[Sweep]:
    """Scans from four places in a room, each laser off by its offset, with 5 mm of noise."""
    rng, found = np.random.default_rng(0), []
    for x, y in ((0, 0), (3, 2), (-6, 4), (6, -4)):
        image = raycast(ROOM, sensor, sensor.pose(x=x, y=y, yaw=x))
        off = offsets[:, None] + rng.normal(0.0, 0.005, sensor.shape)
        depth = (image.depth + off * image.valid).astype(np.float32)
        found.append(Sweep.from_image(replace(image, depth=depth)))
    return found


def smooth(values: np.ndarray) -> np.ndarray:
    rows = np.arange(len(values))
    return np.polyval(np.polyfit(rows, values, 3), rows)


def test_offsets_between_neighbours_are_found():
    truth = np.random.default_rng(1).normal(0.0, 0.03, LASERS)
    truth -= smooth(truth)
    found = fit_range_offsets(sweeps(truth), TABLE)
    left = found - truth
    assert np.std(left - smooth(left)) < 0.004
    assert np.corrcoef(found, truth)[0, 1] > 0.97


def test_without_offsets_none_is_found():
    assert np.abs(fit_range_offsets(sweeps(np.zeros(LASERS)), TABLE)).max() < 0.006


def test_lasers_that_saw_nothing_have_none():
    sees = np.arange(LASERS)[:, None, None] >= 8
    found = fit_range_offsets([Sweep(np.where(sees, sweep.points, 0)) for sweep in sweeps(np.zeros(LASERS))], TABLE)
    assert (found[:8] == 0).all()
    assert found[8:].any()


def test_fewer_lasers_than_a_patch_has_none():
    table = replace(TABLE, elevations=TABLE.elevations[:3], heights=TABLE.heights[:3], rings=TABLE.rings[:3])
    three = [Sweep(sweep.points[:3]) for sweep in sweeps(np.zeros(LASERS))]
    assert fit_range_offsets(three, table) == pytest.approx(np.zeros(3))


def test_scans_in_which_nothing_is_flat_tell_no_offsets():
    torn = [Sweep(np.where(np.arange(512)[:, None] % 2 == 0, one.points, 0.0)) for one in sweeps(np.full(LASERS, 0.05))]
    np.testing.assert_array_equal(fit_range_offsets(torn, TABLE), 0.0)
