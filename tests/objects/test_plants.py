"""Plants: media of foliage, trunks that hold it."""

import numpy as np
import pytest
from built_objects import build, placed

from lidardraft.objects import plants
from lidardraft.objects.plants import trunk_diameter


def test_plants_are_media_and_let_some_rays_through():
    for kind in ("tree", "bush", "hedge"):
        for seed in range(20):
            leaves = [p for p in build(placed(kind, seed % 2), seed) if p.label == "vegetation"]
            assert leaves
            assert all(p.extinction is not None and 0.0 < p.extinction < 25.0 for p in leaves)
            assert all(p.shape in ("ellipsoid", "box") for p in leaves)
    assert all(p.extinction is not None for p in build(placed("grass", 1), 0))


def test_trunks_are_solid_and_grow_with_the_height():
    for variant in range(4):
        made = placed("tree", variant)
        trunk = build(made, 0)[0]
        assert (trunk.label, trunk.shape, trunk.extinction) == ("trunk", "cylinder", None)
        assert trunk.size[0] == pytest.approx(trunk_diameter(made.size[2]))
        assert trunk.center[2] - trunk.size[2] / 2 == pytest.approx(-0.3)
    assert (trunk_diameter(4.5), trunk_diameter(13.0)) == pytest.approx((0.2, 0.39), abs=0.01)


def test_crowns_begin_at_the_clearance():
    for seed in range(30):
        made = placed("tree", seed)
        leaves = [p for p in build(made, seed) if p.label == "vegetation"]
        assert min(p.center[2] - p.size[2] / 2 for p in leaves) >= made.clearance - 0.02 * made.size[2]


def test_bare_trees_stop_a_fifth_of_the_light_and_are_few():
    densities = []
    for seed in range(400):
        made = placed("tree", 1)
        crown = made.size[2] - made.clearance
        densities.append(max(p.extinction or 0.0 for p in build(made, seed)) * crown)
    bare = [density for density in densities if density < 1.0]
    assert 0.02 < len(bare) / len(densities) < 0.13


def test_the_middle_of_a_verge_has_the_height_of_the_grass():
    made = placed("grass", 1)
    heights = [p.size[2] for p in build(made, 0)]
    assert max(heights) == made.size[2]
    assert len(heights) == 4


def test_whether_a_tree_is_bare_can_be_said():
    made = placed("tree", 1)

    def light(seed: int, bare: bool | None) -> float:
        parts = plants.tree(made, np.random.default_rng(seed), bare=bare)
        return max(p.extinction for p in parts if p.extinction is not None)

    assert all(light(seed, False) > 0.15 for seed in range(60))
    assert sum(light(seed, True) < 0.15 for seed in range(60)) > 50  # conifers are never bare
    assert light(3, None) == max(p.extinction for p in build(made, 3) if p.extinction is not None)
