import math

import numpy as np
import pytest

from iou import ClassScores, confusion_matrix
from lidardraft.errors import LidarDraftError

#                   unlabelled, 1 x 4,      2 x 3,   3 x 1
TRUTH = np.array([0, 0, 1, 1, 1, 1, 2, 2, 2, 3])
FOUND = np.array([1, 2, 1, 1, 1, 2, 2, 2, 0, 1])


def test_a_matrix_by_hand():
    expected = [[0, 1, 1, 0, 0], [0, 3, 1, 0, 0], [1, 0, 2, 0, 0], [0, 1, 0, 0, 0], [0, 0, 0, 0, 0]]
    np.testing.assert_array_equal(confusion_matrix(TRUTH, FOUND, 5), expected)


def test_scores_by_hand():
    scores = ClassScores.from_confusion(confusion_matrix(TRUTH, FOUND, 5))
    # 1: 3 right, 4 true, 4 found among the labelled; 2: 2 right, 3 true, 3 found; what is unlabelled does not count
    np.testing.assert_allclose(scores.iou, [0.0, 3 / 5, 2 / 4, 0.0, np.nan])
    np.testing.assert_array_equal(scores.truth, [0, 4, 3, 1, 0])
    assert scores.mean([1, 2, 3]) == pytest.approx(1.1 / 3)
    assert scores.mean([1, 2, 3, 4]) == pytest.approx(1.1 / 4)  # 4 is neither there nor found
    assert math.isnan(scores.mean([]))


def test_images_that_do_not_fit():
    with pytest.raises(LidarDraftError, match=r"truth is \(10,\) and the labels found are \(9,\)"):
        confusion_matrix(TRUTH, FOUND[:9], 5)
    with pytest.raises(LidarDraftError, match="a truth is 0 or 3; ids are 0 to 2"):
        confusion_matrix(TRUTH, FOUND, 3)
    with pytest.raises(LidarDraftError, match="a label found is -1 or 2"):
        confusion_matrix(TRUTH, FOUND - np.where(FOUND == 0, 1, 0), 5)
