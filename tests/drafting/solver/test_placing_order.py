"""What is placed first."""

import pytest

from lidardraft.drafting.solver.placing_order import (
    long_strips,
    placing_order,
    row_of,
    with_gaps,
    with_references,
    with_sides,
)
from lidardraft.drafting.solver.scene_spec import ObjectGroup, SceneSpec

CARS, BUS = ObjectGroup(kind="car", count=3), ObjectGroup(kind="bus", places=("front",))
BEHIND = ObjectGroup(kind="van", relation="behind", references=(1,))
BETWEEN = ObjectGroup(kind="bicycle", relation="between", references=(0,))


def test_references_come_before_what_is_placed_from_them_and_those_before_the_rest() -> None:
    spec = SceneSpec(groups=(CARS, BUS, BEHIND))
    assert placing_order(spec, {}) == [1, 2, 0]
    assert placing_order(spec, {0: 0}) == [0, 1, 2]
    assert with_references(spec, 2) == {1, 2}


def test_what_is_between_two_is_placed_as_a_row() -> None:
    spec = SceneSpec(groups=(ObjectGroup(kind="truck", count=2), BETWEEN))
    assert row_of(spec, 0) == (0, 1, 0)
    assert row_of(SceneSpec(groups=(CARS, BUS)), 0) is None


def test_a_side_follows_from_what_is_to_the_left() -> None:
    sign = ObjectGroup(kind="traffic-sign")
    for kind, side in (("bench", "left"), ("car", "right")):
        other = ObjectGroup(kind=kind, relation="left-of", references=(0,))
        assert with_sides((sign, other))[0].places == (side,)


def test_many_strips_are_shorter() -> None:
    (many,) = long_strips((ObjectGroup(kind="fence", count=10),))
    assert many.size is not None
    assert many.size[0] is not None
    assert 3.0 <= many.size[0] < 9.0
    few = ObjectGroup(kind="fence", count=2)
    assert long_strips((few,)) == (few,)


def test_what_found_no_room_last_is_first() -> None:
    spec = SceneSpec(groups=(CARS, BUS, ObjectGroup(kind="person")))
    assert placing_order(spec, {0: 0, 2: 1}) == [2, 0, 1]
    assert placing_order(spec, {0: 1, 2: 0}) == [0, 2, 1]


def test_a_strip_in_a_lane_is_short() -> None:
    in_lane, asked = (
        ObjectGroup(kind="wall", lane="left"),
        ObjectGroup(kind="wall", lane="left", size=(6.0, None, None)),
    )
    (short,) = long_strips((in_lane,))
    assert short.size is not None
    assert short.size[0] == 2.0
    assert long_strips((asked,)) == (asked,)


@pytest.mark.parametrize(("spacing", "step"), [(1.5, 6.0), (4.0, 8.5), (4.2, 4.2), (9.0, 9.0)])
def test_a_spacing_that_is_shorter_than_the_objects_is_between_their_ends(spacing: float, step: float) -> None:
    (row,) = with_gaps((ObjectGroup(kind="car", count=4, spacing=spacing),))
    assert row.spacing == pytest.approx(step, abs=0.5)
    assert (row.size is None) == (spacing == step)


def test_crowns_leave_room_for_each_other() -> None:
    (row,) = with_gaps((ObjectGroup(kind="tree", count=4, spacing=2.0),))
    assert row.spacing == 2.0
    assert row.size is not None
    assert row.size[0] is not None
    assert row.size[0] < 2.0
