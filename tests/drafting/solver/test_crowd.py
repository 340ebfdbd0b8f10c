"""A crowd that has room is never given up, and one that has none is, early."""

import math

import numpy as np
import pytest

from lidardraft.drafting.solver.crowd import Crowd


def packed(width: float, height: float, size: tuple[float, float], seed: int) -> tuple[int, list[float]]:
    """Rectangles of a size placed at random until 20,000 tries are over: how many, and the bounds on the way."""
    rng, crowd = np.random.default_rng(seed), Crowd()
    placed, bounds = np.zeros((0, 2)), []
    for _ in range(20_000):
        at = rng.uniform((0, 0), (width - size[0], height - size[1]))
        found = not (np.abs(placed - at) < size).all(axis=1).any()
        crowd.add(found=found)
        if found:
            placed = np.vstack([placed, at])
        bounds.append(crowd.most(len(placed)))
    return len(placed), bounds


@pytest.mark.parametrize(("width", "height", "size"), [(30, 30, (1, 1)), (200, 1.001, (1, 1)), (120, 3, (0.6, 0.8))])
def test_the_bound_is_never_below_what_finds_room(width: float, height: float, size: tuple[float, float]) -> None:
    number, bounds = packed(width, height, size, 1)
    assert min(bounds) >= number
    assert bounds[0] == math.inf
    assert bounds[-1] <= 1.6 * number
