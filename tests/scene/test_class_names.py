import pytest

from lidardraft.errors import LayoutError
from lidardraft.scene.class_names import (
    OUTRIGHT,
    check_classes,
    class_of,
    class_of_last_word,
    id_of,
    says_many,
    whole_and_part,
    without_number,
    words_of,
)
from lidardraft.semantics import BY_NAME


@pytest.mark.parametrize("name", [name for name in BY_NAME if name != "none"])
def test_every_class_is_said_by_its_name(name: str) -> None:
    for written in (name, name.upper(), f"{name}.001", f"mat_{name}", f"Left_{name.title()}_02"):
        assert class_of([written], {}) == name


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("Car.001", "car"),
        ("ParkedCars_12", "car"),
        ("mat_building", "building"),
        ("Tree", "vegetation"),
        ("Tree_Trunk.004", "trunk"),
        ("TreeCrown", "vegetation"),
        ("Bushes", "vegetation"),
        ("StreetLamp", "pole"),
        ("street light 3", "pole"),
        ("TrafficLight_2", "traffic-light"),
        ("Traffic_Lights", "traffic-light"),
        ("StopSign", "traffic-sign"),
        ("sign_post", "traffic-sign"),
        ("HouseWall_N", "building"),
        ("Garden_Wall", "wall"),
        ("BusStop", "other"),
        ("School_Bus", "bus"),
        ("Parking_Lot", "road"),
        ("lane_marking", "road"),
        ("Ground_Plane", "terrain"),
        ("Pavement_left", "sidewalk"),
        ("Pedestrians", "person"),
        ("Cyclist1", "rider"),
        ("Motorbike", "motorcycle"),
        ("Fire_Hydrant", "other"),
        ("CarTrunk", "car"),
        ("class:truck", "truck"),
        ("class:truck.002", "truck"),
    ],
)
def test_what_names_say(name: str, label: str) -> None:
    assert class_of([name], {}) == label


@pytest.mark.parametrize(
    "name", ["Cube.001", "careful", "Oscar", "", "none", "class:unicorn", "12", "Mesh_bus2car"[:4]]
)
def test_names_that_say_nothing(name: str) -> None:
    assert class_of([name], {}) is None


def test_the_first_telling_name_counts_and_what_is_given_comes_before_all() -> None:
    assert class_of(["Cube", "mat_car", "Trees"], {}) == "car"
    assert class_of(["Car", "Trees"], {"Trees": "other"}) == "other"
    assert class_of(["Cube.003"], {"Cube": "wall"}) == "wall"
    assert class_of(["Cube.003"], {"Cube.003": "fence", "Cube": "wall"}) == "fence"
    assert class_of(["House", f"{OUTRIGHT}wall"], {}) == "wall"


def test_classes_that_are_none() -> None:
    with pytest.raises(LayoutError, match=r"classes\['a'\] is 'carr'; it must be one of .*did you mean 'car'"):
        check_classes({"a": "carr"})
    with pytest.raises(LayoutError, match="'none'"):
        check_classes({"a": "none"})


def test_words_numbers_and_ids() -> None:
    assert words_of("ParkedCAR_01.002 HTMLText") == ["parked", "car", "html", "text"]
    assert without_number("Car.001") == "Car"
    assert without_number("a.b") == "a.b"
    assert id_of("car.001") == "car_001"
    assert id_of("car_1.body") == "car_1.body"
    assert len(words_of("a" * 10**6)) == 1


def test_names_of_parts_and_of_many() -> None:
    for name in ("car_1.body", "car_1_body", "car_1 body"):
        assert whole_and_part(name) == ("car_1", "body")
    for name in ("Car_001", "roof", "car_1", "Car.001"):
        assert whole_and_part(name) == (name, "")
    assert whole_and_part("Car.001.Wheel") == ("Car.001", "Wheel")
    assert whole_and_part("Street1_ParkedCar_2_left door") == ("Street1_ParkedCar_2", "left door")
    assert whole_and_part("Car_1_Trunk") == ("Car_1", "Trunk")
    assert [
        says_many(name) for name in ("Cars", "Parked cars.001", "Buses", "People", "Car_2", "Bus", "Glass", "x")
    ] == [
        *(True, True, True, True),
        *(False, False, False, False),
    ]


@pytest.mark.parametrize(
    "name", ["car_A4_red", "Lane1_Car_a", "Tesla car Model 3 left", "Cars_1_left", "Car_1_Car_2", "Vehicle_1_van"]
)
def test_a_number_that_is_not_that_of_the_object_makes_no_part(name: str) -> None:
    assert whole_and_part(name) == (name, "")


def test_the_last_word_says_what_an_object_is() -> None:
    assert [class_of_last_word(name) for name in ("Red car_2", "Van", "Car_body", "Cars", "People", "")] == [
        *("car", "car", None, None, None, None)
    ]
