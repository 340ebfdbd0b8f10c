"""Extents of what is placed."""

import numpy as np
import pytest

from lidardraft.streets.placement import sizes
from lidardraft.streets.placement.sizes import STANDING, Extents, sample_person, sample_tree

VEHICLES = ("TRAILER_TRUCK", "TRUCK", "PARKED_TRUCK", "BUS")


def test_only_ranges_take_random_numbers():
    rng, other = np.random.default_rng(0), np.random.default_rng(0)
    assert Extents(1.0, 2.0, 3.0).sample(rng) == (1.0, 2.0, 3.0)
    length, width, height = Extents((1.0, 2.0), 5.0, (3.0, 4.0)).sample(rng)
    assert (length, width, height) == (other.uniform(1.0, 2.0), 5.0, other.uniform(3.0, 4.0))


@pytest.mark.parametrize("name", VEHICLES)
def test_vehicles_keep_to_the_limits_of_directive_96_53(name: str):
    for seed in range(20):
        length, width, height = getattr(sizes, name).sample(np.random.default_rng(seed))
        assert length <= (16.5 if name == "TRAILER_TRUCK" else 12.5)
        assert width <= 2.55
        assert height <= 4.0


def test_people_are_of_usual_stature_and_stand_or_stride():
    rng = np.random.default_rng(0)
    people = np.array([sample_person(rng, standing=False) for _ in range(2000)])
    assert np.median(people[:, 2]) == pytest.approx(1.70, abs=0.03)
    assert people[:, 2].min() >= 1.0
    assert (people[:, 2] < 1.45).mean() == pytest.approx(0.1, abs=0.03)
    assert people[:, 0].min() < 0.35 < 0.6 < people[:, 0].max()
    assert {sample_person(rng, standing=True)[0] for _ in range(20)} == {STANDING}


def test_a_crown_is_over_its_stem():
    rng = np.random.default_rng(0)
    for _ in range(200):
        (length, width, height), stem = sample_tree(rng)
        assert 0.0 < stem < 0.33 * height
        assert 0.4 * height < width < 0.7 * height
        assert length == pytest.approx(width, rel=0.11)
