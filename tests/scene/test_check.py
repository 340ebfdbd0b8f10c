import dataclasses
import math

import pytest

from lidardraft.scene.check import (
    LayoutGround,
    check,
    ego_clear,
    grounded,
    in_range,
    numbered,
    on_road,
    overlap,
    size,
)
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.road import KERB_HEIGHT, TERRAIN_HEIGHT, Road
from lidardraft.scene.road_surfaces import road_surfaces

Vector = tuple[float, float, float]


def box(id: str, center: Vector, size: Vector = (4.0, 2.0, 1.5), yaw: float = 0.0, **fields: object) -> Primitive:
    fields = {"shape": "box", "label": "car", "instance": 1 + sum(map(ord, id)) % 60000} | fields
    return Primitive(id=id, center=center, size=size, yaw=yaw, **fields)  # type: ignore[arg-type]


def test_overlap_names_both_and_the_depth() -> None:
    layout = Layout((box("car_1", (10, 0, 0.75)), box("car_2", (13.6, 0, 0.75))))
    (finding,) = overlap(layout)
    assert (finding.check, finding.ids) == ("overlap", ("car_1", "car_2"))
    assert finding.message == "car_1 and car_2 overlap by 0.40 m"


@pytest.mark.parametrize(
    "other",
    [
        box("b", (14.0, 0, 0.75)),  # touches
        box("b", (10, 0, 2.25)),  # on top
        box("b", (13.5, 2.5, 0.75), yaw=math.pi / 4),  # diagonal: bounding boxes meet, the boxes do not
        box("a.wheel", (10, 0, 0.75)),  # a part of the same object, by name
        box("b", (10, 0, 0.75), instance=7),  # and by number
        box("b", (10, 0, 0.75), label="road", instance=0),
    ],
)
def test_no_overlap(other: Primitive) -> None:
    assert overlap(Layout((box("a", (10, 0, 0.75), instance=7), other))) == []


def test_grounded() -> None:
    ground = road_surfaces(Road())
    y = Road().edge + 1.0 - Road().lane(0)  # on the left sidewalk
    assert grounded(Layout((*ground, box("a", (10, y, 0.75 + KERB_HEIGHT))))) == []
    floating = Layout((*ground, box("a", (10, y, 0.75 + KERB_HEIGHT + 0.4))))
    assert [f.message for f in grounded(floating)] == ["a floats 0.40 m over the ground"]
    sunk = Layout((*ground, box("a", (10, 0, 0.45))))
    assert [f.message for f in grounded(sunk)] == ["a is sunk 0.30 m into the ground"]
    bare = Layout((box("a", (10, 0, 0.75)),))
    assert grounded(bare) == []
    # legs on either side of the end of a sidewalk, whose animal stands on the terrain
    end = Road().verge - Road().lane(0)
    legs = [box(f"dog.leg_{n}", (10, end + off, 0.7), (0.1, 0.1, 1.5)) for n, off in enumerate((-0.3, 0.1, 0.5))]
    assert grounded(Layout((*ground, *legs))) == []


@pytest.mark.parametrize("curvature", [0.0, 0.01, -0.01])
def test_on_road(curvature: float) -> None:
    road = Road(curvature=curvature)
    for across, findings in ((road.lane(0), 0), (-road.lane(0), 0), (road.verge + 2, 1), (-road.verge - 2, 1)):
        x, y, yaw = road.at(40.0, across)
        layout = Layout((*road_surfaces(road), box("car_1", (x, y, 0.75), yaw=yaw)))
        assert len(on_road(layout)) == findings
    assert on_road(Layout((box("car_1", (5, 50, 0.75)),))) == []


def test_size() -> None:
    layout = Layout((box("car_1", (10, 0, 2), (9.0, 2.0, 1.5)), box("car_2", (30, 0, 2))))
    assert [f.message for f in size(layout)] == ["car_1 has length 9.00 m; a car has 2.4 to 6.5 m"]


def test_ego_clear() -> None:
    layout = Layout((box("car_1", (4.0, 0, 0.75)), box("car_2", (9, 0, 0.75)), *road_surfaces(Road())))
    assert [f.message for f in ego_clear(layout)] == ["car_1 reaches 0.25 m into the ego vehicle"]
    bridge = Primitive(shape="box", center=(0, 0, 6), size=(5, 20, 1), label="building", id="bridge")
    assert ego_clear(Layout((bridge,))) == []


def test_in_range() -> None:
    layout = Layout((box("car_1", (250, 0, 0.75)), box("car_2", (50, 0, 0.75)), *road_surfaces(Road())))
    assert [f.message for f in in_range(layout)] == ["car_1 is 250 m away; sensors reach 210 m"]


def test_check_runs_all() -> None:
    boxes = (box("a", (1, 0, 3), (9, 2, 1.5)), box("b", (1, 0, 3)), box("c", (300, 50, 0.75)))
    bad = Layout((*road_surfaces(Road()), *boxes))
    names = {finding.check for finding in check(bad)}
    assert names == {"overlap", "grounded", "on_road", "size", "in_range"}


@pytest.mark.parametrize("curvature", [0.0, 0.01])
def test_ground_heights(curvature: float) -> None:
    road = Road(curvature=curvature)
    ground = LayoutGround(road_surfaces(road))
    for across, height in (
        (0.0, 0.0),
        (road.edge + 1, KERB_HEIGHT),
        (-road.edge - 1, KERB_HEIGHT),
        (30, TERRAIN_HEIGHT),
    ):
        x, y, _ = road.at(25.0, across)
        assert ground.height(x, y) == pytest.approx(height)
    assert ground.at(1000.0, 0.0) is None
    assert ground.height(1000.0, 0.0) == 0.0


def test_things_need_a_number_of_their_own() -> None:
    car = box("car_1", (10.0, 0.0, 0.75))
    assert [f.ids for f in numbered(Layout((dataclasses.replace(car, instance=0),)))] == [("car_1",)]
    person = dataclasses.replace(car, id="person_1", label="person", instance=4)
    findings = numbered(Layout((dataclasses.replace(car, instance=4), person)))
    assert [f.ids for f in findings] == [("car_1", "person_1")]
    assert numbered(Layout((dataclasses.replace(car, instance=4), dataclasses.replace(person, instance=5)))) == []
