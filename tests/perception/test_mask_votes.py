"""Masks with the votes of classes, numbered or one by one."""

import numpy as np

from lidardraft.perception.mask_votes import number_objects
from lidardraft.semantics import BY_NAME

CAR, ROAD = BY_NAME["car"].id, BY_NAME["road"].id


def test_numbers_of_masks_mean_the_same_as_masks() -> None:
    labels = np.full((6, 9), ROAD)
    labels[2:5, 1:8] = CAR
    numbers = np.zeros((6, 9), dtype=np.uint32)
    numbers[2:5, 1:4], numbers[1:5, 4:8] = 7, 30  # the second reaches a row over its car
    classes, objects = number_objects(labels, numbers)
    again = number_objects(labels, np.stack([numbers == 7, numbers == 30]))
    np.testing.assert_array_equal(classes, again[0])
    np.testing.assert_array_equal(objects, again[1])
    assert set(objects.ravel()) == {0, 1, 2}
    assert (classes == CAR).sum() == 9 + 16
