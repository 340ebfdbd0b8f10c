"""Distances between distributions, against closed forms."""

import math

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.divergence import jensen_shannon, wasserstein


def test_equal_and_disjoint_histograms() -> None:
    assert jensen_shannon(np.array([1.0, 3.0]), np.array([10.0, 30.0])) == 0.0
    assert jensen_shannon(np.array([1.0, 0.0]), np.array([0.0, 5.0])) == pytest.approx(math.sqrt(math.log(2)))


def test_a_known_divergence() -> None:
    # p = (1, 0), q = (1/2, 1/2): m = (3/4, 1/4)
    expected = (math.log(4 / 3) + 0.5 * math.log(2 / 3) + 0.5 * math.log(2)) / 2
    assert jensen_shannon(np.array([4.0, 0.0]), np.array([1.0, 1.0])) == pytest.approx(math.sqrt(expected))


def test_histograms_that_are_equal_but_for_rounding_have_a_distance() -> None:
    rng = np.random.default_rng(0)
    for _ in range(100):  # where scipy's jensenshannon is NaN for two in five
        shares = rng.dirichlet(np.ones(20))
        assert 0 <= jensen_shannon(shares, np.nextafter(shares, rng.choice([0.0, 1.0], 20))) < 1e-7


def test_histograms_that_cannot_be_compared() -> None:
    with pytest.raises(LidarDraftError, match=r"shapes \(2,\) and \(3,\)"):
        jensen_shannon(np.ones(2), np.ones(3))
    with pytest.raises(LidarDraftError, match="empty"):
        jensen_shannon(np.ones(2), np.zeros(2))


def test_earth_is_moved_by_the_shift_and_by_the_share() -> None:
    sample = np.array([0.0, 1.0, 5.0])
    assert wasserstein(sample, sample[::-1]) == 0.0
    assert wasserstein(sample, sample + 2.5) == pytest.approx(2.5)
    assert wasserstein(np.array([0.0, 0.0]), np.array([0.0, 0.0, 3.0])) == pytest.approx(1.0)
    with pytest.raises(LidarDraftError, match="empty"):
        wasserstein(sample, np.array([]))
