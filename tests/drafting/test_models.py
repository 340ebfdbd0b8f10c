"""Pieces of 3D models become objects: ids and numbers of things."""

import pytest

from lidardraft.drafting.models import PieceIds
from lidardraft.scene.class_names import class_of


def test_pieces_of_one_node_are_parts_and_nodes_of_one_name_are_not() -> None:
    ids = PieceIds([], {})
    assert [ids.id_of((1,), ("Car", "mesh"), "car") for _ in range(3)] == ["Car", "Car.2", "Car.3"]
    assert [ids.id_of((2,), ("Car", "mesh"), "car") for _ in range(2)] == ["Car_2", "Car_2.2"]
    assert ids.id_of((3,), ("", "tree"), "vegetation") == "tree"
    assert ids.id_of((4,), ("", ""), "other") == "unnamed"
    assert ids.id_of((5,), ("Car.001", ""), "car") == "Car_001"


def test_what_is_below_one_thing_is_a_part_of_it() -> None:
    ids = PieceIds([], {"Rig": "truck"})
    assert ids.id_of((1, 9, 8), ("Body", "Truck_2", "Scene", ""), "truck") == "Truck_2.Body"
    assert ids.id_of((2, 9, 8), ("Body", "Truck_2", "Scene", ""), "truck") == "Truck_2.Body_2"
    assert ids.id_of((9, 8), ("Truck_2", "Scene", ""), "truck") == "Truck_2"
    assert ids.id_of((3, 7), ("Body", "Truck_2", ""), "truck") == "Truck_2_2.Body"  # another node of that name
    assert ids.id_of((4, 6), ("Body", "Rig", ""), "truck") == "Rig.Body"
    assert ids.id_of((5, 5), ("Cube", "Trucks", ""), "truck") == "Cube"  # many of them
    assert ids.id_of((10, 11), ("Cube", "Car_1", ""), "truck") == "Cube_2"  # of another class


def test_numbers_are_those_of_things_and_none_is_given_twice() -> None:
    ids = PieceIds([1, 3, None, "2"], {})
    numbers = [ids.instance_of(whole) for whole in ("a", "b", "a.roof", "b.2", "Car_1_Wheel", "Car_1_Body", "c", 5)]
    assert numbers == [2, 4, 2, 4, 5, 5, 6, 7]


@pytest.mark.parametrize(
    "names",
    [
        ("car_A4_red", "car_A4_blue"),
        ("Lane1_Car_a", "Lane1_Car_b"),
        ("Tesla car Model 3 left", "Tesla car Model 3 right"),
    ],
)
def test_a_number_inside_a_name_does_not_make_two_one_thing(names: tuple[str, str]) -> None:
    ids = PieceIds([], {})
    assert [ids.instance_of(name) for name in names] == [1, 2]


def instances_below(group: str, *names: str) -> list[int]:
    """The instances of nodes below a group, each with the class that its own name or that of the group says."""
    paths = [((k + 1, 0), (name, group, "mesh")) for k, name in enumerate(names)]
    label = class_of([group], {}) or ""
    ids = PieceIds([], {}, paths)
    return [ids.instance_of(ids.id_of(*path, label)) for path in paths]


@pytest.mark.parametrize(
    ("group", "names"), [("People", ("Anna", "Bob")), ("Vehicle", ("Car.001", "Car.002")), ("Person", ("Man", "Woman"))]
)
def test_a_group_of_several_is_not_one_thing(group: str, names: tuple[str, ...]) -> None:
    assert instances_below(group, *names) == [1, 2]


@pytest.mark.parametrize(
    ("group", "names"),
    [("Car", ("Car_Body", "Car_Wheel")), ("Truck", ("Cab", "Trailer")), ("Vehicle_1", ("Car.001", "Car.002"))],
)
def test_a_group_of_parts_is_one_thing(group: str, names: tuple[str, ...]) -> None:
    assert instances_below(group, *names) == [1, 1]
