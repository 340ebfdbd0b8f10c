"""Trams: sections and bellows that fill the length, heads at both ends."""

import math

import numpy as np
import pytest
from built_objects import build, placed, vertices


@pytest.mark.parametrize("variant", [0, 1])
def test_sections_and_bellows_fill_the_length(variant: int):
    made = placed("tram", variant)
    tram = build(made, 0)
    bellows = sorted(p.center[0] for p in tram if p.material == "rubber")
    sections = [p for p in tram if p.shape == "mesh"]
    assert len(sections) == len(bellows) + 1 == round(made.size[0] / 7.5)
    assert np.diff(bellows) == pytest.approx(made.size[0] / len(sections), abs=1e-9)
    every = np.concatenate([vertices(p) for p in sections])
    assert every[:, 0].max() == pytest.approx(made.size[0] / 2, abs=0.05)
    assert every[:, 0].min() == pytest.approx(-made.size[0] / 2, abs=0.05)


def test_the_rear_head_is_the_front_one_turned_round():
    heads = [p for p in build(placed("tram"), 0) if p.shape == "mesh"]
    rear, front = min(heads, key=lambda p: p.center[0]), max(heads, key=lambda p: p.center[0])
    assert rear.mesh is front.mesh
    assert rear.center[0] == pytest.approx(-front.center[0], abs=1e-9)
    assert abs(rear.yaw - front.yaw) == pytest.approx(math.pi)
