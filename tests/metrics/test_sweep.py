"""Sweeps: points become images laser by laser, firing by firing."""

import math

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.sweep import Sweep, firing_step
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import PRESETS, Sensor


def fired(firings: int, lost: np.ndarray, *, phase: float = 0.3, drift: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """One laser at 10 m that turns to the right; `lost` [firings] do not return. Points and firings' numbers."""
    turned = (np.arange(firings) + phase) / firings * 2 * math.pi
    turned = turned + drift * np.sin(turned)
    kept = np.flatnonzero(~lost)
    azimuth = math.pi - turned[kept]
    return np.stack([10 * np.cos(azimuth), 10 * np.sin(azimuth), np.zeros(len(kept))], axis=1), kept


@pytest.mark.parametrize("firings", [360, 900, 2004])
@pytest.mark.parametrize("drift", [0.0, 0.02])
def test_a_full_turn_leaves_no_hole(firings: int, drift: float) -> None:
    points, _ = fired(firings, np.zeros(firings, dtype=bool), drift=drift)
    sweep = Sweep.from_points(points, np.zeros(firings, dtype=int), height=1, columns=360)
    assert sweep.valid.all()
    np.testing.assert_allclose(sweep.depth, 10.0, rtol=1e-6)


def test_lost_firings_are_lost_at_their_rate_and_not_hidden_by_their_neighbours() -> None:
    rng = np.random.default_rng(0)
    lost = rng.random(2004) < 0.3
    points, _ = fired(2004, lost, drift=0.02)
    sweep = Sweep.from_points(points, np.zeros(len(points), dtype=int), height=1, columns=1002)
    # every second firing, whichever comes nearest; the nearest of two returns would leave 9 % of holes
    assert sweep.valid.mean() == pytest.approx(0.7, abs=0.04)


def test_each_firing_comes_to_its_column() -> None:
    lost = np.zeros(360, dtype=bool)
    lost[[0, 100, 101, 359]] = True
    points, kept = fired(360, lost, phase=0.5)
    sweep = Sweep.from_points(points, np.zeros(len(points), dtype=int), height=1, columns=360, intensity=kept / 360)
    np.testing.assert_array_equal(sweep.valid[0], ~lost)
    assert sweep.intensity is not None
    np.testing.assert_allclose(sweep.intensity[0], np.where(lost, 0, np.arange(360) / 360), rtol=1e-6)


def test_rows_and_labels_stay_together() -> None:
    points, _ = fired(90, np.zeros(90, dtype=bool), phase=0.5)
    both = np.concatenate([points, 2 * points])
    rows = np.repeat([2, 0], 90)
    sweep = Sweep.from_points(both, rows, height=3, columns=90, label=np.repeat([5, 7], 90))
    assert sweep.label is not None
    np.testing.assert_array_equal(sweep.depth.round(3), np.repeat([[20.0], [0.0], [10.0]], 90, axis=1))
    np.testing.assert_array_equal(sweep.label, np.repeat([[7], [0], [5]], 90, axis=1))
    assert sweep.part(10, 30).depth.shape == (3, 20)


def test_the_step_does_not_count_gaps() -> None:
    turned = np.concatenate([np.arange(50), np.arange(70, 100)]) * 0.01
    assert firing_step(turned, np.zeros(80, dtype=int)) == pytest.approx(0.01)
    with pytest.raises(LidarDraftError, match="no row has two returns"):
        firing_step(np.array([0.0, 1.0]), np.array([0, 1]))


def test_a_row_that_is_not_there() -> None:
    with pytest.raises(LidarDraftError, match="rows are 0 to 4; they must be 0 to 3"):
        Sweep.from_points(np.ones((2, 3)), np.array([0, 4]), height=4, columns=8)


def test_a_range_image_keeps_its_points() -> None:
    sensor = PRESETS["vlp16"]
    rng = np.random.default_rng(0)
    depth = np.where(rng.random(sensor.shape) < 0.8, rng.uniform(2, 50, sensor.shape), 0).astype(np.float32)
    blank = np.zeros(sensor.shape)
    image = RangeImage(sensor=sensor, depth=depth, label=blank.astype(np.uint8), instance=blank.astype(np.uint32))
    sweep = Sweep.from_image(image)
    np.testing.assert_array_equal(sweep.valid, image.valid)
    np.testing.assert_allclose(sweep.points[sweep.valid], image.points(), rtol=1e-6)
    np.testing.assert_allclose(sweep.depth, depth, rtol=1e-5)


def test_the_lasers_of_a_sector_do_not_look_around_its_edges() -> None:
    offsets = (0.2, -0.2)
    sensor = Sensor(
        name="sector", elevations=(0.1, 0.0), azimuth_offsets=offsets, columns=10, azimuth_start=0.5, azimuth_span=1.0
    )
    depth, blank = np.full(sensor.shape, 10.0, np.float32), np.zeros(sensor.shape)
    image = RangeImage(sensor=sensor, depth=depth, label=blank.astype(np.uint8), instance=blank.astype(np.uint32))
    sweep = Sweep.by_azimuth(image)
    assert sweep.depth.shape == (2, 14)
    np.testing.assert_array_equal(sweep.valid, [[i < 10 for i in range(14)], [i >= 4 for i in range(14)]])
    azimuth = np.arctan2(sweep.points[..., 1], sweep.points[..., 0])
    np.testing.assert_allclose(azimuth[0, 4:10], azimuth[1, 4:10], atol=1e-6)
    assert (np.diff(azimuth[0, :10]) < 0).all()
    assert (np.diff(azimuth[1, 4:]) < 0).all()
