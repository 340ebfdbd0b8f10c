from typing import Any

import pytest

from lidardraft import Box, layout_from_boxes
from lidardraft.errors import LayoutError
from lidardraft.scene.check import check


def box(id: str, label: str = "car", instance: int = 0, **fields: Any) -> Box:
    place = {"center": (9.0, 2.0, -1.0), "size": (4.0, 2.0, 1.5), "yaw": 0.3}
    return Box(id=id, label=label, instance=instance, **{**place, **fields})


def test_boxes_stand_where_they_were_on_a_road_under_all_of_them() -> None:
    boxes = [box("car_1", instance=4), box("house", "building", center=(-70.0, 12.0, -0.95))]
    layout = layout_from_boxes(boxes, sensor_height=1.7)
    car = layout["car_1"]
    assert (car.instance, car.center, car.size, car.yaw) == (4, (9.0, 2.0, 0.7), (4.0, 2.0, 1.5), 0.3)
    assert layout["house"].instance == 0
    assert layout["ground"].label == "road"
    assert layout["ground"].size[0] > 140
    assert [primitive.id for primitive in layout if primitive.open] == ["ground"]
    assert check(layout) == []


def test_things_have_instances_of_their_own() -> None:
    given = [box("a", instance=2), box("b", instance=2), box("c"), box("d", "person", 1), box("e", "wall", 7)]
    assert [primitive.instance for primitive in layout_from_boxes(given)][1:] == [2, 3, 4, 1, 0]


def test_a_box_may_be_called_as_the_ground_is() -> None:
    layout = layout_from_boxes([box("ground"), box("ground_")])
    assert [primitive.id for primitive in layout] == ["ground__", "ground", "ground_"]


@pytest.mark.parametrize(
    ("boxes", "said"),
    [
        ([], "there are 0 boxes"),
        ([box("a", label="none")], "a: label is 'none'"),
        ([box("a", size=(1.0, 0.0, 1.0))], "a: size is"),
        ([box("a"), box("a")], "a: two primitives have this id"),
    ],
)
def test_boxes_that_make_no_layout(boxes: list[Box], said: str) -> None:
    with pytest.raises(LayoutError, match=said.replace("[", r"\[")):
        layout_from_boxes(boxes)
    with pytest.raises(LayoutError, match="sensor_height is nan"):
        layout_from_boxes([box("a")], sensor_height=float("nan"))
