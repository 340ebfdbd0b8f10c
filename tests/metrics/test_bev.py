import math

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.comparisons import bev_histogram, histogram_mmd

HERE, THERE, AWAY = [10.1, 0.1, 0.0], [-20.1, 5.1, 0.0], [30.1, -40.1, 1.0]


def scan(*places):
    return np.array(places, dtype=np.float32)


def mmd(recorded, generated):
    return histogram_mmd(*(np.stack([bev_histogram(points) for points in side]) for side in (recorded, generated)))


def test_the_histogram_counts_points_in_cells_of_160_centimetres():
    histogram = bev_histogram(scan(HERE, HERE, THERE))
    assert histogram.shape == (100, 100)
    assert histogram[math.floor(90.1 / 1.6), math.floor(80.1 / 1.6)] == 2
    assert histogram.sum() == 3


def test_distances_of_3_to_70_metres_count_height_included():
    points = scan([2.9, 0, 0], [3.1, 0, 0], [69.9, 0, 0], [70.1, 0, 0], [2.9, 0, 2.0], [69.9, 0, 10.0])
    assert bev_histogram(points).sum() == 3


def test_mmd_of_equal_and_of_disjoint_scans():
    assert mmd([scan(HERE)], [scan(HERE)]) == pytest.approx(0.0, abs=1e-12)
    # The difference is +1 in one cell and -1 in another of another row and column: both singular values are 1.
    assert mmd([scan(HERE)], [scan(AWAY)]) == pytest.approx(2 - 2 * math.exp(-1 / (2 * 0.5**2)))


def test_mmd_takes_the_largest_singular_value_not_the_euclidean_norm():
    in_the_same_row = [HERE[0], -30.1, 0.0]
    # +1 and -1 in one row: the only singular value is sqrt 2.
    assert mmd([scan(HERE)], [scan(in_the_same_row)]) == pytest.approx(2 - 2 * math.exp(-2 / (2 * 0.5**2)))


def test_mmd_is_a_mean_over_all_pairs_with_the_diagonal():
    recorded = [scan(HERE), scan(AWAY)]
    kernel = math.exp(-2)
    expected = (1 + kernel) / 2 + 1 - 2 * (1 + kernel) / 2
    assert mmd(recorded, [scan(HERE)]) == pytest.approx(expected)
    assert mmd([scan(HERE)], recorded) == pytest.approx(expected)


def test_sets_without_a_score():
    with pytest.raises(LidarDraftError, match=r"scan 1: no point lies in the top view"):
        mmd([scan(HERE)], [scan(HERE), scan([1, 0, 0])])
