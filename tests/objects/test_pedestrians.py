"""People on foot."""

import numpy as np
import pytest
from built_objects import all_vertices, build, placed, vertices


@pytest.mark.parametrize("variant", range(4))
def test_a_person_fills_the_stature_and_walks(variant: int):
    made = placed("person", variant)
    strides = []
    for seed in range(40):
        primitives = build(made, seed)
        every = all_vertices(primitives)
        assert every[:, 2].max() == pytest.approx(made.size[2], abs=0.01)
        assert every[:, 2].min() == pytest.approx(0.0, abs=0.02)
        strides.append(np.ptp(vertices(primitives[0])[:, 0]))
    # the feet of one who stands are side by side; of one who walks they meet and part
    apart = max(strides) - min(strides)
    assert (apart < 0.02) if made.size[0] <= 0.3 else (apart > 0.1 * made.size[2])


def test_some_carry_a_rucksack_and_some_a_bag():
    built = [build(placed("person", 2), seed) for seed in range(200)]
    rucksacks = sum(any(p.shape == "box" for p in person) and len(person) == 4 for person in built)
    bags = sum(any(p.shape == "cylinder" for p in person) for person in built)
    assert 15 < rucksacks < 50
    assert 10 < bags < 50


def test_a_childs_head_is_larger_against_the_stature():
    def share(variant: int) -> float:
        made = placed("person", variant)
        return next(p for p in build(made, 0) if p.material == "skin").size[2] / made.size[2]

    assert share(0) > share(1) > share(2) == pytest.approx(0.13)
