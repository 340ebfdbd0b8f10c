import math
from dataclasses import replace as replaced

import pytest

from lidardraft.errors import LayoutError
from lidardraft.scene.edit import add, move, remove, replace, select
from lidardraft.scene.layout import Layout, Primitive


def primitive(id: str, x: float, y: float = 0.0, label: str = "car", size: float = 2.0) -> Primitive:
    return Primitive(shape="box", center=(x, y, 1.0), size=(size, size, size), label=label, id=id)


LAYOUT = Layout(
    (
        primitive("car_1", 10),
        primitive("car_2", 20),
        primitive("tree_3.trunk", 5, 5, "trunk", 0.4),
        primitive("tree_3.crown", 5, 5, "vegetation", 3.0),
        primitive("tree_30.trunk", 9, 9, "trunk", 0.4),
    ),
    provenance={"seed": 1},
)


def ids(layout: Layout) -> list[str]:
    return [p.id for p in layout]


def test_select() -> None:
    assert [p.id for p in select(LAYOUT, "car_*")] == ["car_1", "car_2"]
    assert [p.id for p in select(LAYOUT, "tree_3")] == ["tree_3.trunk", "tree_3.crown"]
    assert [p.id for p in select(LAYOUT, "*.trunk")] == ["tree_3.trunk", "tree_30.trunk"]
    assert [p.id for p in select(LAYOUT, label="vegetation")] == ["tree_3.crown"]
    assert [p.id for p in select(LAYOUT, "tree_*", label="trunk")] == ["tree_3.trunk", "tree_30.trunk"]
    assert len(select(LAYOUT)) == 5
    assert select(LAYOUT, "bus_*") == ()


def test_add() -> None:
    assert ids(add(LAYOUT, primitive("bus_1", 40)))[-1] == "bus_1"
    with pytest.raises(LayoutError, match="car_1: two primitives have this id"):
        add(LAYOUT, primitive("car_1", 40))


def test_what_is_added_and_can_be_counted_gets_an_instance_of_its_own() -> None:
    layout = add(LAYOUT, replaced(primitive("car_9", 30), instance=2))
    bus = primitive("bus_1.body", 40, label="bus"), primitive("bus_1.front", 43, label="bus")
    layout = add(layout, *bus, primitive("car_4", 50), primitive("tree_9", 5, label="vegetation"))
    assert [layout[id].instance for id in ("car_9", "bus_1.body", "bus_1.front", "car_4", "tree_9")] == [2, 1, 1, 3, 0]
    assert len(layout.boxes()) == 3
    with pytest.raises(LayoutError, match="truck_1: instance 2 is car_9's; 0 takes a free one"):
        add(layout, replaced(primitive("truck_1", 60, label="truck"), instance=2))
    assert add(layout, primitive("bus_1.rear", 37, label="bus"))["bus_1.rear"].instance == 1
    van = replaced(primitive("van_1.body", 50), instance=9)
    assert add(LAYOUT, van, primitive("van_1.roof", 50))["van_1.roof"].instance == 9
    with pytest.raises(LayoutError, match="car_5: instance 9 is van_1's"):
        add(LAYOUT, van, replaced(primitive("car_5", 60), instance=9))


def test_remove() -> None:
    assert ids(remove(LAYOUT, "tree_3")) == ["car_1", "car_2", "tree_30.trunk"]
    assert ids(remove(LAYOUT, "*.crown")) == ["car_1", "car_2", "tree_3.trunk", "tree_30.trunk"]


def test_edits_keep_the_rest_and_the_old_layout() -> None:
    before = LAYOUT.to_json()
    after = move(remove(LAYOUT, "car_2"), "car_1", (1, 2, 3))
    assert LAYOUT.to_json() == before
    assert after.provenance == LAYOUT.provenance
    assert after["tree_30.trunk"] == LAYOUT["tree_30.trunk"]


def test_move_takes_the_whole_object() -> None:
    moved = move(LAYOUT, "tree_3.crown", (1, 0, 0.5))
    assert moved["tree_3.trunk"].center == (6, 5, 1.5)
    assert moved["tree_3.crown"].center == (6, 5, 1.5)
    assert moved["tree_30.trunk"] == LAYOUT["tree_30.trunk"]
    assert ids(moved) == ids(LAYOUT)


def test_turn_is_about_the_middle_of_the_object() -> None:
    layout = Layout((primitive("sign_1.left", 10, 1), primitive("sign_1.right", 10, -1)))
    turned = move(layout, "sign_1", turn=math.pi / 2)
    assert turned["sign_1.left"].center == pytest.approx((9, 0, 1))
    assert turned["sign_1.right"].center == pytest.approx((11, 0, 1))
    assert turned["sign_1.left"].yaw == pytest.approx(math.pi / 2)
    back = move(turned, "sign_1", turn=-math.pi / 2)
    assert back["sign_1.left"].center == pytest.approx(layout["sign_1.left"].center)


def test_replace() -> None:
    changed = replace(LAYOUT, "car_*", label="truck", size=(8, 2.5, 3))
    assert [p.label for p in select(changed, "car_*")] == ["truck", "truck"]
    assert changed["car_1"].size == (8, 2.5, 3)
    with pytest.raises(LayoutError, match="a primitive has no field 'colour'; it has shape, center"):
        replace(LAYOUT, "car_1", colour="red")
    with pytest.raises(LayoutError, match="label is 'dragon'"):
        replace(LAYOUT, "car_1", label="dragon")
    with pytest.raises(LayoutError, match="two primitives have this id"):
        replace(LAYOUT, "car_1", id="car_2")


@pytest.mark.parametrize("edit", [remove, move, replace])
def test_unknown_ids_name_what_was_probably_meant(edit: object) -> None:
    with pytest.raises(LayoutError, match=r"no primitive has the id 'car_11'; did you mean 'car_1'\?"):
        edit(LAYOUT, "car_11")  # type: ignore[operator]
    with pytest.raises(LayoutError, match=r"no primitive has the id 'zebra'; it has car_1, car_2, tree_3, tree_30"):
        edit(LAYOUT, "zebra")  # type: ignore[operator]


def test_unknown_id_in_large_and_empty_layouts() -> None:
    many = Layout(tuple(primitive(f"thing_{i}", i) for i in range(20)))
    with pytest.raises(LayoutError, match=r"it has thing_0, .*thing_7, \.\.\."):
        remove(many, "zebra")
    with pytest.raises(LayoutError, match="it has none"):
        remove(Layout(), "car_1")


@pytest.mark.parametrize(
    ("by", "turn", "said"),
    [
        ((1, 2), 0.0, r"by is \(1, 2\); it must be three finite numbers"),
        ((1, 2, 3, 4), 0.0, "by is"),
        (5, 0.0, "by is 5"),
        ((1, 2, float("nan")), 0.0, "by is"),
        ((0, 0, 0), None, "turn is None; it must be a finite number of radians"),
        ((0, 0, 0), float("inf"), "turn is inf"),
    ],
)
def test_moves_that_are_none(by, turn, said):
    car = Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="car_1", instance=1)
    with pytest.raises(LayoutError, match=said):
        move(Layout((car,)), "car_1", by, turn=turn)
