"""Edges, steps and bends, counted by hand."""

import math

import numpy as np
import pytest

from lidardraft.metrics.edges import STEP_EDGES, mixed_share, range_bends, range_steps
from lidardraft.metrics.sweep import Sweep


def sweep_of(*rows: list[float]) -> Sweep:
    points = np.zeros((len(rows), len(rows[0]), 3), dtype=np.float32)
    points[..., 1] = rows
    return Sweep(points)


CLEAN = [5.0, 5.0, 5.0, 5.0, 20.0, 20.0, 20.0]
MIXED = [5.0, 5.0, 5.0, 12.0, 20.0, 20.0, 20.0]
SLOPE = [5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0]


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
