import math

import numpy as np
import pytest

from lidardraft.drafting.sketches.line_smoothing import resampled, smooth, without_bumps

CORNER = np.array([(0.0, 0.0), (10.0, 0.0), (10.0, 0.0), (10.0, 10.0)])
TURNS = np.linspace(0, math.tau, 61)
RING = np.stack([20 * np.cos(TURNS), 20 * np.sin(TURNS)], axis=1)


def test_points_are_evenly_apart() -> None:
    line, spacing = resampled(CORNER, 0.7)
    assert spacing == pytest.approx(20 / 29)
    np.testing.assert_allclose(line[[0, -1]], CORNER[[0, -1]])
    away = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert np.sort(away)[1:] == pytest.approx(spacing)  # one step goes over the corner
    assert len(resampled(CORNER, 100.0)[0]) == 4


def test_a_point_is_a_line_of_no_length() -> None:
    line, _ = resampled(np.zeros((2, 2)), 1.0)
    np.testing.assert_array_equal(smooth(without_bumps(line, 3, False), 0.5, False), 0.0)


@pytest.mark.parametrize("deviation", [0.5, 3.0])
def test_a_straight_line_stays_as_it_is(deviation: float) -> None:
    line = np.linspace((0.0, 0.0), (30.0, 10.0), 40)
    np.testing.assert_allclose(smooth(line, deviation, False), line, atol=1e-9)
    np.testing.assert_allclose(without_bumps(line, 15, False), line, atol=1e-9)


def test_a_ring_stays_closed_and_hardly_shrinks() -> None:
    for ring in (smooth(RING, 2.0, True), without_bumps(RING, 5, True)):
        np.testing.assert_array_equal(ring[0], ring[-1])
        assert np.abs(np.linalg.norm(ring, axis=1) - 20).max() < 0.6


def test_a_bump_shorter_than_half_the_window_is_gone() -> None:
    line = np.linspace((0.0, 0.0), (60.0, 0.0), 61)
    line[20:28, 1] = 5.0
    assert np.abs(without_bumps(line, 19, False)[:, 1]).max() == 0
    assert np.abs(without_bumps(line, 11, False)[:, 1]).max() == 5
