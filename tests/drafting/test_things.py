"""Objects of a modelled scene become things: their ids and numbers."""

import pytest

from lidardraft.drafting.things import Node, Things
from lidardraft.scene.class_names import class_of


def below(*names: str, label: str | None = None) -> Node:
    """A node of the first name below one of the second, and so on; its surface is of a class."""
    parent = below(*names[1:]) if len(names) > 1 else None
    return Node(names[0], label, parent)


def ids_of(label: str, *nodes: Node, classes: dict[str, str] | None = None) -> list[str]:
    things = Things(nodes, classes or {})
    return [things.id_of(node, label) for node in nodes]


def numbers_of(label: str, *nodes: Node) -> list[int]:
    things = Things(nodes, {})
    return [things.number_of(node, label) for node in nodes]


def test_pieces_of_one_node_are_parts_and_nodes_of_one_name_are_not() -> None:
    car, other, numbered = Node("Car", "car"), Node("Car", "car"), Node("Car.001", "car")
    assert ids_of("car", car, car, car, other, other, numbered) == [
        *("Car", "Car.2", "Car.3"),
        *("Car_2", "Car_2.2"),
        "Car_001",
    ]
    assert numbers_of("car", car, other, car, numbered) == [1, 2, 1, 3]


def test_what_is_below_one_thing_is_a_part_of_it() -> None:
    truck, rig, scene = Node("Truck_2", None), Node("Rig", None), Node("Scene", None)
    truck.parent = scene
    body, same, cab = (Node(name, "truck", truck) for name in ("Body", "Body", "Cab"))
    another = below("Body", "Truck_2", label="truck")
    nodes = [body, same, truck, cab, another, Node("Body", "truck", rig), below("Cube", "Trucks", label="truck")]
    assert ids_of("truck", *nodes, classes={"Rig": "truck"}) == [
        *("Truck_2.Body", "Truck_2.Body_2", "Truck_2", "Truck_2.Cab"),
        *("Truck_2_2.Body", "Rig.Body"),
        "Cube",  # many are below "Trucks"
    ]
    assert ids_of("truck", below("Cube", "Car_1", label="truck")) == ["Cube"]


def test_numbers_are_those_of_things_and_none_is_given_twice() -> None:
    nodes = [Node(name, "car") for name in ("a", "b", "a.roof", "b", "Car_1_Wheel", "Car_1_Body", "c")]
    things = Things(nodes, {}, given=[1, 3, None, "2"])
    assert [things.number_of(node, "car") for node in nodes] == [2, 4, 2, 5, 6, 6, 7]
    assert things.number_of(nodes[0], "building") == 0


@pytest.mark.parametrize(
    "names",
    [
        ("car_A4_red", "car_A4_blue"),
        ("Lane1_Car_a", "Lane1_Car_b"),
        ("Tesla car Model 3 left", "Tesla car Model 3 right"),
    ],
)
def test_a_number_inside_a_name_does_not_make_two_one_thing(names: tuple[str, str]) -> None:
    assert numbers_of("car", *(Node(name, "car") for name in names)) == [1, 2]


@pytest.mark.parametrize(
    ("group", "names", "numbers"),
    [
        ("People", ("Anna", "Bob"), [1, 2]),
        ("Vehicle", ("Car.001", "Car.002"), [1, 2]),
        ("Person", ("Man", "Woman"), [1, 2]),
        ("Cars", ("Car_1", "Car_2"), [1, 2]),
        ("City", ("Car_1", "Car_2"), [1, 2]),  # that holds all there is, and says no class
        ("Car", ("Car_Body", "Car_Wheel"), [1, 1]),
        ("Truck", ("Cab", "Trailer"), [1, 1]),
        ("Vehicle_1", ("Car.001", "Car.002"), [1, 1]),
    ],
)
def test_what_is_below_a_group_is_one_thing_where_its_name_says_one(
    group: str, names: tuple[str, ...], numbers: list[int]
) -> None:
    above = Node(group)
    label = class_of([group, *names], {}) or ""
    assert numbers_of(label, *(Node(name, label, above) for name in names)) == numbers


def test_cars_and_trucks_below_one_root_are_things_of_their_own() -> None:
    root = Node("Scene_root")
    nodes = [Node(name, label, root) for name, label in (("Car_1", "car"), ("Truck", "truck"), ("Car_2", "car"))]
    things = Things(nodes, {})
    assert [things.number_of(node, str(node.label)) for node in nodes] == [1, 2, 3]
