"""Vehicles, people and riders: bodies by proportions, headings, extents that no vehicle has."""

import math

import pytest
from coarse_boxes import box, detailed, materials

from lidardraft.objects.cars import BODIES
from lidardraft.simulation.detail.traffic import _nearest_body


@pytest.mark.parametrize("name", BODIES)
def test_a_box_of_a_body_gets_that_body_or_one_much_like_it(name: str) -> None:
    size = BODIES[name].size
    found = {_nearest_body(size, (k + 0.5) / 40) for k in range(40)}
    assert all(abs(a / b - 1) < 0.25 for other in found for a, b in zip(BODIES[other].size, size, strict=True))
    if name in ("large_van", "van", "off_roader", "city_car"):
        assert name in found


def test_the_front_is_where_the_box_has_it() -> None:
    cars = [detailed(box("car", (4.2, 1.8, 1.5), yaw=yaw), seed=3) for yaw in (0.0, math.pi)]
    plates = [next(p for p in parts if p.material == "retroreflector").center[0] - 15.0 for parts in cars]
    assert plates[0] == pytest.approx(-plates[1], abs=1e-9)


@pytest.mark.parametrize(("y", "ahead"), [(0.0, 1.0), (-3.0, 1.0), (3.6, -1.0), (7.0, -1.0)])
def test_of_a_clustering_cars_stand_in_the_direction_of_their_lane(y: float, ahead: float) -> None:
    yaws = [
        detailed(box("car", (4.2, 1.8, 1.5), at=(15, y, 0), id=f"car_{k}"), headed=False)[0].yaw for k in range(200)
    ]
    assert 0.88 < sum(math.cos(yaw) * ahead > 0 for yaw in yaws) / 200 < 0.995
    assert math.cos(detailed(box("car", (4.2, 1.8, 1.5), at=(15, y, 0)))[0].yaw) > 0


def test_a_long_truck_has_a_trailer() -> None:
    short, long = (detailed(box("truck", (length, 2.5, 3.6))) for length in (9.0, 16.5))
    wheels = [sum(p.material == "rubber" for p in parts) for parts in (short, long)]
    assert wheels[1] > wheels[0]


@pytest.mark.parametrize("label", ["car", "truck", "bus", "train"])
@pytest.mark.parametrize(
    "size", [(1.0, 0.4, 0.3), (0.02, 0.02, 0.02), (9.0, 3.0, 0.1), (60.0, 8.0, 9.0), (1.5, 4.0, 1.5)]
)
def test_no_box_is_too_small_too_large_or_too_flat(label: str, size: tuple[float, float, float]) -> None:
    parts = detailed(box(label, size, instance=4))
    assert {(p.label, p.instance) for p in parts} == {(label, 4)}
    assert len(parts) > 3
    assert "rubber" in materials(parts)


def test_a_name_that_is_a_body_says_which() -> None:
    pickup, other = (detailed(box("car", (5.0, 1.9, 1.7), id=id)) for id in ("pickup_1", "minivan_1"))
    assert pickup[0].mesh is not other[0].mesh


def test_people_have_heads_and_clothes() -> None:
    parts = detailed(box("person", (0.7, 0.5, 1.75), instance=3))
    assert {"skin"} < materials(parts) <= {"skin", "cloth", "dark-cloth"}
    head = next(p for p in parts if p.material == "skin")
    assert head.center[2] + head.size[2] / 2 <= 1.75 + 1e-9


def test_rider_and_machine_keep_their_instances_and_names() -> None:
    machine = box("bicycle", (1.8, 0.6, 1.1), id="bicycle_1.bicycle", instance=8)
    rider = box("rider", (0.7, 0.55, 1.0), at=(14.9, 3.0, 0.7), id="bicycle_1.rider", instance=9)
    parts = detailed(machine, rider)
    assert {(p.label, p.instance) for p in parts} == {("bicycle", 8), ("rider", 9)}
    assert all(p.id.split(".")[0] == "bicycle_1" for p in parts)


def test_a_rider_sits_on_the_machine_that_a_clustering_found_under_him() -> None:
    machine = box("motorcycle", (2.1, 0.8, 1.2), id="motorcycle_4", instance=4)
    rider = box("rider", (1.8, 0.6, 1.7), at=(15.2, 3.1, 0.0), id="rider_2", instance=2)
    parts = detailed(rider, machine, headed=False)
    by_name = {name: [p for p in parts if p.id.split(".")[0] == name] for name in ("rider_2", "motorcycle_4")}
    assert {p.label for p in by_name["rider_2"]} == {"rider"}
    assert {p.instance for p in by_name["motorcycle_4"]} == {4}
    assert "skin" in materials(by_name["rider_2"]) or "light-paint" in materials(by_name["rider_2"])


def test_a_rider_alone_has_a_bicycle_of_the_same_class() -> None:
    parts = detailed(box("rider", (1.8, 0.6, 1.7), instance=2), headed=False)
    assert {(p.label, p.instance) for p in parts} == {("rider", 2)}
    assert "rubber" in materials(parts)


def test_a_parked_machine_has_no_rider() -> None:
    parts = detailed(box("motorcycle", (2.1, 0.8, 1.2)))
    assert "rubber" in materials(parts)
    assert "skin" not in materials(parts)
