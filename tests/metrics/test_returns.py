"""Return rates and runs of lost firings, counted by hand."""

import numpy as np

from lidardraft.metrics.returns import (
    RANGE_EDGES,
    RUN_EDGES,
    hole_lengths,
    lone_returns,
    near_holes,
    returns_by_range,
    returns_by_row,
    runs,
)
from lidardraft.metrics.sweep import Sweep


def sweep_of(depth: list[list[float]]) -> Sweep:
    points = np.zeros((*np.shape(depth), 3), dtype=np.float32)
    points[..., 0] = depth
    return Sweep(points)


def test_runs_have_rows_starts_and_ends() -> None:
    mask = np.array([[1, 1, 0, 1], [0, 0, 0, 0], [0, 1, 1, 1], [1, 1, 1, 1]], dtype=bool)
    assert runs(mask).tolist() == [[0, 0, 2], [0, 3, 4], [2, 1, 4], [3, 0, 4]]


def test_returns_by_row() -> None:
    counts = returns_by_row(sweep_of([[5, 0, 5, 5], [0, 0, 0, 0]]))
    assert counts.tolist() == [[3, 4], [0, 4]]


def test_a_hole_counts_where_its_ends_are_one_surface() -> None:
    surface = [6.0, 6.0, 0, 0, 6.2, 6.2]  # two lost at 6.1 m
    edge = [6.0, 0, 12.0, 12.0, 12.0, 12.0]  # between near and far: nobody knows
    sky = [0, 6.0, 6.0, 6.0, 6.0, 0]  # open ends
    counts = returns_by_range(sweep_of([surface, edge, sky]))
    five, ten = np.searchsorted(RANGE_EDGES, [5.0, 10.0])
    assert counts[five].tolist() == [9, 11]
    assert counts[ten].tolist() == [4, 4]
    assert counts.sum(axis=0).tolist() == [13, 15]


def test_a_long_hole_is_no_drop_on_a_surface() -> None:
    assert returns_by_range(sweep_of([[6.0, *[0] * 8, 6.0]])).sum(axis=0).tolist() == [2, 10]
    assert returns_by_range(sweep_of([[6.0, *[0] * 9, 6.0]])).sum(axis=0).tolist() == [2, 2]


def test_lengths_of_holes() -> None:
    counts = hole_lengths(sweep_of([[5, 0, 5, 0, 5, 5, 5], [5, 0, 0, 0, 0, 0, 5]]))
    assert dict(zip(RUN_EDGES, counts, strict=False)) == {**dict.fromkeys(RUN_EDGES[:-1], 0), 1: 2, 5: 1}


def test_a_near_hole_is_one_firing_wide_and_in_a_surface() -> None:
    surface = [6.0, 0, 6.2, 6.2, 0, 0, 6.2]  # a hole, and one of two firings
    edge = [6.0, 0, 9.0, 9.0, 9.1, 9.0, 9.0]  # a gap between near and far, then places without a hole
    far = [25.0, 0, 25.0, 25.0, 25.0, 25.0, 25.0]
    assert near_holes(sweep_of([surface])).tolist() == [1, 1]
    assert near_holes(sweep_of([edge])).tolist() == [0, 3]
    assert near_holes(sweep_of([far])).tolist() == [0, 0]


def test_a_lone_return_has_no_neighbour_at_its_range() -> None:
    scan = [
        [6.0, 0, 0, 20.0],
        [0, 6.3, 0, 20.0],  # across a corner it has one
        [0, 0, 0, 0],
        [9.0, 0, 12.0, 14.0],  # alone, and two beside each other that are none's neighbours
    ]
    assert lone_returns(sweep_of(scan)).tolist() == [3, 7]
    assert lone_returns(sweep_of([[0, 0]])).tolist() == [0, 0]
