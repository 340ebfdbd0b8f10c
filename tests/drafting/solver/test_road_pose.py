import numpy as np

from lidardraft.drafting.solver.road_pose import YAW_DEVIATION, alternate, turned


def test_sides_are_taken_in_turns() -> None:
    assert [alternate((1, -1), number) for number in range(4)] == [1, -1, 1, -1]


def test_headings_are_as_precise_as_drivers() -> None:
    rng = np.random.default_rng(0)
    assert 0.5 * YAW_DEVIATION < np.std([turned(rng, 1.0) for _ in range(200)]) < 2 * YAW_DEVIATION
