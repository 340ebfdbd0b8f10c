"""Boxes around objects: what they bound, and which cannot be."""

import math

import numpy as np
import pytest

from lidardraft.errors import LayoutError
from lidardraft.scene.box import Box, box_around
from lidardraft.scene.layout import Primitive


def test_a_box_around_a_turned_part_bounds_it():
    long = Primitive(shape="box", center=(0, 0, 0.5), size=(4, 2, 1), label="car", id="a", instance=1)
    turned = Primitive(
        shape="box", center=(0, 0, 0.5), size=(3, 0.2, 1), label="car", id="b", instance=1, yaw=math.pi / 2
    )
    box = box_around([turned, long])
    np.testing.assert_allclose(box.size, (4, 3, 1))
    assert (box.id, box.yaw) == ("a", 0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"size": (4.2, -1.0, 1.5)}, r"car_1: size is \[4.2, -1.0, 1.5\]; no extent may be negative"),
        ({"center": (0.0, 1.0)}, r"car_1: center is \(0.0, 1.0\); it must be 3 finite numbers"),
        ({"center": (0.0, 1.0, math.nan)}, r"car_1: center is \(0.0, 1.0, nan\); it must be 3 finite numbers"),
        ({"yaw": math.inf}, r"car_1: yaw is inf; it must be a finite number of radians"),
        ({"label": "cow"}, r"car_1: label is 'cow'; it must be one of"),
        ({"label": ["car"]}, r"car_1: label is \['car'\]; it must be one of"),
        ({"instance": 0.5}, r"car_1: instance is 0.5; it must be a whole number >= 0"),
        ({"id": ""}, r"id is ''; it must be a non-empty string"),
    ],
)
def test_a_box_that_cannot_be(change, message):
    fields = {"id": "car_1", "label": "car", "instance": 1, "center": (1, 2, 3), "size": (4, 2, 1), "yaw": 0.0}
    with pytest.raises(LayoutError, match=message):
        Box(**{**fields, **change})
