"""What is placed first."""

from lidardraft.drafting.placing_order import placing_order, row_of, with_references
from lidardraft.drafting.scene_spec import ObjectGroup, SceneSpec

CARS, BUS = ObjectGroup(kind="car", count=3), ObjectGroup(kind="bus", places=("front",))
BEHIND = ObjectGroup(kind="van", relation="behind", references=(1,))
BETWEEN = ObjectGroup(kind="bicycle", relation="between", references=(0,))


def test_references_come_before_what_is_placed_from_them_and_those_before_the_rest() -> None:
    spec = SceneSpec(groups=(CARS, BUS, BEHIND))
    assert placing_order(spec, set()) == [1, 2, 0]
    assert placing_order(spec, {0}) == [0, 1, 2]
    assert with_references(spec, 2) == {1, 2}


def test_what_is_between_two_is_placed_as_a_row() -> None:
    spec = SceneSpec(groups=(ObjectGroup(kind="truck", count=2), BETWEEN))
    assert row_of(spec, 0) == (0, 1, 0)
    assert row_of(SceneSpec(groups=(CARS, BUS)), 0) is None
