"""The shapes that stand in for those of clustering."""

import numpy as np
import pytest
from scanned import EGO, OBJECTS, STREET, VISIBLE

from lidardraft.semantics import BY_NAME, NUM_CLASSES
from lidardraft.streets.coarse.cluster_shapes import cluster_shapes


@pytest.mark.parametrize("numbered", [True, False])
def test_shapes_are_of_what_was_seen(numbered: bool):
    street = STREET.coarse
    grounds = street.heights_over(EGO.pose)
    yaws = street.places[:, 2] - VISIBLE.place[2]
    found = cluster_shapes(VISIBLE, yaws, grounds, street.diameters, np.random.default_rng(0), numbered=numbered)
    owners, labels = found.keys // NUM_CLASSES, found.keys % NUM_CLASSES
    assert (VISIBLE.returns[owners, labels] > 0).all()
    assert (found.sizes > 0).all()
    # what stands begins on the ground or more than 2.5 m over it
    bottom = found.centers[2] - found.sizes[2] / 2
    car = labels == BY_NAME["car"].id
    assert car.any()
    assert (bottom[car] <= grounds[owners[car]] + 1e-9).all()
    x, y, _ = VISIBLE.place
    away = np.array([np.hypot(OBJECTS[k].x - x, OBJECTS[k].y - y) for k in owners[car]])
    assert np.abs(np.hypot(*found.centers[:2, car]) - away).max() < 6.0
