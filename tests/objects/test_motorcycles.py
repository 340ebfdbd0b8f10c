"""Motorcycles and scooters."""

import pytest
from built_objects import build, placed, vertices


def test_there_are_motorcycles_and_scooters_with_wheels_of_their_own():
    diameters = set()
    for seed in range(40):
        tyres = build(placed("motorcycle"), seed)[0]
        assert vertices(tyres)[:, 2].min() == pytest.approx(0.0, abs=1e-6)
        diameters.add(round(tyres.size[2], 3))
    assert diameters == {0.48, 0.63}


def test_only_motorcycles_have_cases():
    for seed in range(60):
        motorcycle = build(placed("motorcycle"), seed)
        cases = [p for p in motorcycle if p.shape == "box"]
        assert len(cases) <= 1
        assert not cases or round(motorcycle[0].size[2], 3) == 0.63


def test_a_motorcyclist_always_wears_a_helmet():
    for seed in range(20):
        heads = [p for p in build(placed("motorcyclist"), seed) if p.label == "rider" and p.shape == "ellipsoid"]
        assert [p.material for p in heads] == ["light-paint"]
        # a head is 0.14 of a stature in tenths of a metre, and the helmet 4 cm higher
        statures = (heads[0].size[2] - 0.04) / 0.14 * 10
        assert statures == pytest.approx(round(statures))
