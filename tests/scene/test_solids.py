"""How far solids run into each other, and which of many do."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.scene.layout import Primitive
from lidardraft.scene.solids import Solid, Solids, penetration

poses = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-math.pi, math.pi))
halves = st.floats(0.05, 2.5)
solids = st.builds(
    lambda pose, length, width, is_round: Solid.box(*pose, (2 * length, 2 * width), 0.0, 1.0)._replace(
        is_round=is_round
    ),
    poses, halves, halves, st.booleans(),
)  # fmt: skip


def gap(one: Solid, two: Solid) -> float:
    """How far apart outlines are, along the edge normal that separates them most: by their corners alone."""
    gaps = []
    for outline in (one.outline, two.outline):
        for edge in np.roll(outline, -1, axis=0) - outline:
            normal = np.array([edge[1], -edge[0]]) / np.hypot(*edge)
            a, b = one.outline @ normal, two.outline @ normal
            gaps.append(max(b.min() - a.max(), a.min() - b.max()))
    return max(gaps)


@settings(max_examples=200, deadline=None)
@given(solids, solids, st.floats(0.0, 0.5))
def test_penetration_is_what_the_corners_say(one: Solid, two: Solid, margin: float) -> None:
    expected = min(1.0, max(0.0, margin - gap(one, two)))
    assert penetration(one, two, margin) == pytest.approx(expected, abs=1e-9)
    assert penetration(two, one, margin) == pytest.approx(expected, abs=1e-9)


def test_heights_that_touch_do_not_overlap() -> None:
    low, high = (Solid.box(0.0, 0.0, 0.0, (1.0, 1.0), bottom, bottom + 1.0) for bottom in (0.0, 1.0))
    assert penetration(low, high) == 0.0
    assert penetration(low, high._replace(bottom=0.9)) == pytest.approx(0.1)


def test_round_things_have_no_corners() -> None:
    pole, corner = (
        Solid.from_primitive(Primitive(shape=shape, center=(x, x, 1.0), size=(s, s, 2.0), label="pole", id="pole"))
        for shape, x, s in (("cylinder", 0.0, 2.0), ("box", 1.4, 1.0))
    )
    assert penetration(pole, corner) == 0
    assert penetration(pole, corner._replace(y=0.0)) == pytest.approx(0.1)


def test_the_grid_finds_all_that_touch_however_large_and_far() -> None:
    rng = np.random.default_rng(0)
    places, sizes = rng.uniform(-700, 700, (300, 2)), rng.uniform(0.1, 60, (300, 2))
    many = [
        Solid.box(x, y, yaw, size, 0.0, 1.0)._replace(id=str(number))
        for number, ((x, y), yaw, size) in enumerate(
            zip(places.tolist(), rng.uniform(0, 6, 300), sizes.tolist(), strict=True)
        )
    ]
    many.append(Solid.box(-900.0, 900.0, 0.5, (1e9, 1.0), 0.0, 1.0))
    kept, found = Solids(), set()
    for solid in many:
        found |= {frozenset((solid, other)) for other in kept.touching(solid, 0.5)}
        kept.add(solid)
    expected = {frozenset(pair) for pair in itertools.combinations(many, 2) if penetration(*pair, 0.5) > 0}
    assert found == expected
    assert len(found) > 50
