"""Histograms of a small sweep."""

import math

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.metrics import profiles
from lidardraft.metrics.profiles import jensen_shannon, wasserstein
from lidardraft.metrics.returns import RANGE_EDGES
from lidardraft.metrics.sweep import Sweep


def small() -> Sweep:
    """Road 2 m below at 6 m, a wall top 1 m above at 12 m, and a ray without return."""
    points = np.array([[[6, 0, -2], [6, 1, -2], [6, 2, -1.98]], [[12, 0, 1], [0, 0, 0], [12, 2, 1]]], dtype=np.float32)
    label = np.array([[1, 1, 1], [3, 0, 3]], dtype=np.uint8)
    return Sweep(points, label, np.array([[0.1, 0.1, 0.12], [0.5, 0.0, 1.0]], dtype=np.float32))


def test_heights_are_over_the_road() -> None:
    assert profiles.road_level(small()) == pytest.approx(-2.0, abs=0.05)
    counts = profiles.height_histogram(small())
    assert counts.sum() == 5
    at_wall = np.searchsorted(profiles.HEIGHT_BINS, 1.0 - profiles.road_level(small())) - 1
    assert counts[at_wall] == 2


def test_no_road_is_an_error() -> None:
    with pytest.raises(LidarDraftError, match="the height of the road is unknown"):
        profiles.road_level(Sweep(np.full((2, 2, 3), 5.0, dtype=np.float32)))


def test_ranges() -> None:
    counts = profiles.range_histogram(small())
    assert counts.sum() == 5
    assert counts[6] == 3  # 6.3 to 6.6 m
    assert counts[12] == 2


def test_intensity_by_class_and_range() -> None:
    assert profiles.intensity_histogram(small()).sum() == 5
    wall = profiles.intensity_histogram(small(), (3,))
    assert wall.sum() == 2
    assert wall[[25, 49]].tolist() == [1, 1]
    near, far = np.searchsorted(RANGE_EDGES, [5.0, 10.0])
    sums = profiles.intensity_by_range(small())
    assert sums[near].tolist() == pytest.approx([0.32, 3])
    assert sums[far].tolist() == pytest.approx([1.5, 2])
    assert profiles.intensity_by_range(small(), (3,))[near].tolist() == [0, 0]
    assert profiles.intensity_by_row(small()).tolist() == [pytest.approx([0.32, 3]), pytest.approx([1.5, 2])]


def test_hundredths_fall_two_to_a_step() -> None:
    hundredths = np.arange(100, dtype=np.float32).reshape(1, 100) / 100
    sweep = Sweep(np.ones((1, 100, 3), dtype=np.float32), None, hundredths)
    assert profiles.intensity_histogram(sweep).tolist() == [2.0] * 50


def test_what_is_not_known() -> None:
    bare = Sweep(small().points)
    with pytest.raises(LidarDraftError, match="no intensity"):
        profiles.intensity_histogram(bare)
    with pytest.raises(LidarDraftError, match="no labels"):
        profiles.intensity_histogram(Sweep(bare.points, None, small().intensity), (1,))


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
