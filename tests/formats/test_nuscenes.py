"""nuScenes sweeps, against one that is written here, and one of nuScenes where recordings lie."""

import os
from pathlib import Path

import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.formats.nuscenes import read_pcd_bin

DATA = os.environ.get("LIDARDRAFT_DATA", "")
SWEEPS = sorted(Path(DATA, "nuscenes").rglob("*LIDAR_TOP*.pcd.bin")) if DATA else []


def write(path: Path, sweep: list[list[float]]) -> Path:
    np.array(sweep, "<f4").tofile(path)
    return path


def test_axes_intensities_and_rings(tmp_path: Path) -> None:
    """What is to the right in nuScenes has a negative y in our frame, and what is ahead a positive x."""
    path = write(tmp_path / "a.pcd.bin", [[2, 10, -1.5, 255, 0], [-3, 0, 0, 51, 31]])
    points, intensity, ring = read_pcd_bin(path)
    np.testing.assert_array_equal(points, [[10, -2, -1.5], [0, 3, 0]])
    np.testing.assert_allclose(intensity, [1, 0.2])
    np.testing.assert_array_equal(ring, [0, 31])
    assert (points.dtype, intensity.dtype, ring.dtype) == (np.float32, np.float32, np.int64)


@pytest.mark.parametrize(
    ("sweep", "said"),
    [
        ([[np.nan, 0, 0, 0, 0]], r"point 0 is \[nan, .*every value must be finite"),
        ([[1, 0, 0, 0, 0], [1, 0, 0, 256, 0]], r"point 1 is .*intensity, must be 0 to 255"),
        ([[1, 0, 0, 0, 0.5]], "the ring, must be a whole number from 0 to 511"),
        ([[1, 0, 0, 0, -1]], "the ring, must be a whole number from 0 to 511"),
        ([[1, 0, 0, 0]], "a.pcd.bin has 16 bytes; a nuScenes sweep has 20 a point"),
        ([[]], "a.pcd.bin has 0 bytes"),
    ],
)
def test_what_is_no_sweep(tmp_path: Path, sweep: list[list[float]], said: str) -> None:
    with pytest.raises(FormatError, match=said):
        read_pcd_bin(write(tmp_path / "a.pcd.bin", sweep))


@pytest.mark.skipif(not SWEEPS, reason="LIDARDRAFT_DATA has no sweep of nuScenes")
def test_a_recorded_sweep_has_the_beams_of_an_hdl32e_and_a_car_that_is_long_ahead() -> None:
    from lidardraft import Sensor

    points, _, ring = read_pcd_bin(SWEEPS[0])
    distance = np.hypot(points[:, 0], points[:, 1])
    elevation = np.arctan2(points[:, 2], distance)
    found = [np.median(elevation[(ring == k) & (distance > 2)]) for k in range(31, -1, -1)]
    np.testing.assert_allclose(found, Sensor.preset("hdl32e").elevations, atol=np.deg2rad(0.4))
    roof = points[(distance > 0.5) & (distance < 3) & (points[:, 2] > -1)]
    assert np.ptp(roof[:, 0]) > np.ptp(roof[:, 1])
