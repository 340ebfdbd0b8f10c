"""Trucks: what they carry, axles by their length, protection at the rear and the sides."""

import numpy as np
import pytest
from built_objects import build, is_closed, placed, vertices


def test_all_loads_are_carried_and_end_where_the_truck_does():
    shapes = set()
    for seed in range(120):
        made = placed("trailer_truck", seed)
        load = build(made, seed)
        every = np.concatenate([vertices(p) for p in load])
        assert every[:, 2].max() <= made.size[2] + 0.1
        shapes |= {p.material for p in load}
    # tarpaulins, tanks of steel, heaps of a tipper, the floor of a flatbed
    assert {"cloth", "chrome", "gravel", "wood", "light-paint", "mid-paint"} <= shapes


def test_a_longer_truck_has_one_axle_more():
    def axles(variant: int) -> int:
        return sum(p.material == "rubber" for p in build(placed("truck", variant), 0))

    assert (axles(1), axles(2)) == (2, 3)
    assert sum(p.material == "rubber" for p in build(placed("trailer_truck"), 0)) == 5


@pytest.mark.parametrize("kind", ["truck", "trailer_truck"])
def test_the_marking_at_the_rear_is_behind_everything(kind: str):
    for seed in range(8):
        made = placed(kind, seed)
        primitives = build(made, seed)
        marking = next(p for p in primitives if p.material == "retroreflector")
        assert marking.center[0] < -made.size[0] / 2 + 0.03
        assert marking.size[1] > 0.9 * made.size[1]


def test_tanks_are_closed():
    tanks = [p for seed in range(60) for p in build(placed("truck", 2), seed) if p.material == "chrome"]
    assert tanks
    assert all(is_closed(p.mesh) for p in tanks)
