"""Bicycles: wheels that rays go through, alike on both sides."""

import numpy as np
import pytest
from built_objects import all_vertices, build, cast, placed, vertices


def test_rays_pass_between_the_spokes():
    bicycle = build(placed("bicycle"), 3)
    rng = np.random.default_rng(0)
    at = np.column_stack([rng.uniform(0.48, 0.62, 400), np.zeros(400), rng.uniform(0.2, 0.28, 400)])
    assert 0.7 < (cast(bicycle, (0.55, 8.0, 0.3), at) < 0).mean() < 1.0


def test_wheels_have_28_inches_and_stand_on_the_ground():
    tyres = build(placed("bicycle"), 0)[0]
    assert tyres.material == "rubber"
    assert tyres.size[2] == pytest.approx(0.68, abs=0.02)
    assert vertices(tyres)[:, 2].min() == pytest.approx(0.0, abs=0.01)


def test_some_carry_panniers_or_a_basket():
    counts = [len(build(placed("bicycle"), seed)) for seed in range(60)]
    assert set(counts) == {5, 6, 7}


def test_a_cyclist_is_as_high_as_the_extents_say():
    for seed in range(10):
        made = placed("cyclist", seed)
        rider = [p for p in build(made, seed) if p.label == "rider"]
        assert all_vertices(rider)[:, 2].max() == pytest.approx(made.size[2], abs=0.12)
