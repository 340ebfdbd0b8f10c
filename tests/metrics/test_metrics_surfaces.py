"""Edges, steps and bends, counted by hand."""

import math

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.surfaces import (
    RESIDUAL_EDGES,
    STEP_EDGES,
    mixed_share,
    plane_residuals,
    range_bends,
    range_steps,
    residual_histogram,
)
from lidardraft.metrics.sweep import Sweep

CLEAN = [5.0, 5.0, 5.0, 5.0, 20.0, 20.0, 20.0]
MIXED = [5.0, 5.0, 5.0, 12.0, 20.0, 20.0, 20.0]
SLOPE = [5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0]
ROAD, WALL = 1, 3


def sweep_of(*rows: list[float]) -> Sweep:
    points = np.zeros((len(rows), len(rows[0]), 3), dtype=np.float32)
    points[..., 1] = rows
    return Sweep(points)


def test_mixed_pixels_are_a_share_of_edges() -> None:
    assert mixed_share(sweep_of(CLEAN)) == 0.0
    assert mixed_share(sweep_of(MIXED)) == 1.0
    assert mixed_share(sweep_of(CLEAN, MIXED, CLEAN, CLEAN[::-1])) == 0.25


def test_slopes_returns_near_a_surface_and_holes_are_no_edges() -> None:
    near = [5.0, 5.0, 5.0, 19.9, 20.0, 20.0, 20.0]
    assert mixed_share(sweep_of(near)) == 0.0
    assert math.isnan(mixed_share(sweep_of(SLOPE)))
    assert math.isnan(mixed_share(sweep_of([5.0, 5.0, 5.0, 0.0, 20.0, 20.0, 20.0])))


def test_the_image_is_no_ring() -> None:
    assert math.isnan(mixed_share(sweep_of([5.0] * 5, [20.0] * 5)))
    assert range_steps(sweep_of([5.0, 5.0, 9.0, 9.0])).sum() == 3


def test_steps_and_bends_are_counted_by_size() -> None:
    steps = range_steps(sweep_of([10.0, 10.1, 10.1, 0.0, 12.0]))
    assert steps.sum() == 2
    assert steps[0] == 1
    assert steps[np.searchsorted(STEP_EDGES, 0.1) - 1] == 1
    assert range_bends(sweep_of(SLOPE))[0] == 5
    bend = range_bends(sweep_of([10.0, 10.5, 10.0]))
    assert bend[np.searchsorted(STEP_EDGES, 0.5) - 1] == 1


def test_bends_measure_noise() -> None:
    rng = np.random.default_rng(0)
    noisy = 10.0 + rng.normal(0.0, 0.02, 20_000)
    counts = range_bends(sweep_of(noisy.tolist()))
    median = STEP_EDGES[np.searchsorted(np.cumsum(counts), counts.sum() / 2)]
    # the middle of two neighbours adds half of their variance
    assert median == pytest.approx(0.6745 * 0.02 * math.sqrt(1.5), rel=0.25)


def wall(noise: float, label: int = WALL, distance: float = 12.0) -> Sweep:
    rng = np.random.default_rng(0)
    y, z = np.meshgrid(np.arange(200) * 0.05, np.arange(30) * 0.1)
    x = distance + 0.3 * y + rng.normal(0.0, noise, y.shape)
    return Sweep(np.stack([x, y, z], axis=2).astype(np.float32), np.full(y.shape, label, np.uint8))


def test_a_plane_has_no_residual() -> None:
    assert plane_residuals(wall(0.0), (WALL,)).max() < 1e-5


def test_noise_comes_back_less_what_the_plane_takes() -> None:
    residuals = plane_residuals(wall(0.03), (WALL,))
    # of 15 points three go into the plane; the wall is seen at a slant of 0.3
    expected = 0.03 * np.sqrt(12 / 15) / np.hypot(1, 0.3)
    assert np.sqrt((residuals**2).mean()) == pytest.approx(expected, rel=0.05)


def test_windows_keep_to_a_class_and_to_30_metres() -> None:
    assert len(plane_residuals(wall(0.01), (ROAD,))) == 0
    assert len(plane_residuals(wall(0.01, distance=31.0), (WALL,))) == 0
    mixed = wall(0.01)
    assert mixed.label is not None
    mixed.label[:, ::4] = ROAD
    assert len(plane_residuals(mixed, (WALL,))) == 0
    assert len(plane_residuals(mixed, (WALL, ROAD))) > 1000


def test_the_histogram_holds_all() -> None:
    counts = residual_histogram(wall(0.03), (WALL,))
    assert counts.sum() == len(plane_residuals(wall(0.03), (WALL,)))
    assert RESIDUAL_EDGES[counts.argmax()] == pytest.approx(0.025, rel=0.4)
    with pytest.raises(LidarDraftError, match="no labels"):
        residual_histogram(Sweep(wall(0.0).points), (WALL,))
