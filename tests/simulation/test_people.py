"""People and riders."""

from coarse_boxes import box, detailed, materials


def test_people_have_heads_and_clothes() -> None:
    parts = detailed(box("person", (0.7, 0.5, 1.75), instance=3))
    assert {"skin"} < materials(parts) <= {"skin", "cloth", "dark-cloth"}
    head = next(p for p in parts if p.material == "skin")
    assert head.center[2] + head.size[2] / 2 <= 1.75 + 1e-9


def test_a_person_of_any_size_is_built() -> None:
    for size in ((0.3, 0.3, 0.3), (0.1, 2.0, 1.0), (3.0, 3.0, 3.0)):
        assert len(detailed(box("person", size))) >= 3


def test_rider_and_machine_keep_their_instances_and_names() -> None:
    machine = box("bicycle", (1.8, 0.6, 1.1), id="bicycle_1.bicycle", instance=8)
    rider = box("rider", (0.7, 0.55, 1.0), at=(14.9, 3.0, 0.7), id="bicycle_1.rider", instance=9)
    parts = detailed(machine, rider)
    assert {(p.label, p.instance) for p in parts} == {("bicycle", 8), ("rider", 9)}
    assert all(p.id.split(".")[0] == "bicycle_1" for p in parts)


def test_a_rider_sits_on_the_machine_that_a_clustering_found_under_him() -> None:
    machine = box("motorcycle", (2.1, 0.8, 1.2), id="motorcycle_4", instance=4)
    rider = box("rider", (1.8, 0.6, 1.7), at=(15.2, 3.1, 0.0), id="rider_2", instance=2)
    parts = detailed(rider, machine, source="point cloud")
    by_name = {name: [p for p in parts if p.id.split(".")[0] == name] for name in ("rider_2", "motorcycle_4")}
    assert {p.label for p in by_name["rider_2"]} == {"rider"}
    assert {p.instance for p in by_name["motorcycle_4"]} == {4}
    assert "skin" in materials(by_name["rider_2"]) or "light-paint" in materials(by_name["rider_2"])


def test_a_rider_alone_has_a_bicycle_of_the_same_class() -> None:
    parts = detailed(box("rider", (1.8, 0.6, 1.7), instance=2), source="point cloud")
    assert {(p.label, p.instance) for p in parts} == {("rider", 2)}
    assert "rubber" in materials(parts)


def test_a_parked_machine_has_no_rider() -> None:
    parts = detailed(box("motorcycle", (2.1, 0.8, 1.2)))
    assert "rubber" in materials(parts)
    assert "skin" not in materials(parts)
