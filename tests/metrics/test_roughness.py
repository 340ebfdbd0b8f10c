"""Plane residuals of surfaces that are known."""

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.roughness import RESIDUAL_EDGES, plane_residuals, residual_histogram
from lidardraft.metrics.sweep import Sweep

ROAD, WALL = 1, 3


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
