"""Objects of a layout, before they have details."""

import math

import numpy as np
import pytest
from coarse_boxes import box

from lidardraft import Layout, Primitive
from lidardraft.scene.mesh import primitive_mesh
from lidardraft.simulation.coarse_object import UprightBox, coarse_objects, generator_of


def names(*parts: Primitive) -> list[list[str]]:
    return [[part.id for part in one.parts] for one in coarse_objects(Layout(primitives=parts), 0)]


def test_the_box_around_parts_holds_them_all() -> None:
    parts = [
        box("pole", (3.0, 0.5, 0.2), at=(1, 2, 6), yaw=0.7),
        box("pole", (0.2, 0.2, 6.0), shape="cylinder", id="p"),
    ]
    around = UprightBox.around(parts)
    cos, sin = math.cos(around.yaw), math.sin(around.yaw)
    points = np.concatenate([primitive_mesh(part).vertices for part in parts]) - (around.x, around.y, around.bottom)
    local = np.column_stack([cos * points[:, 0] + sin * points[:, 1], cos * points[:, 1] - sin * points[:, 0]])
    assert (np.abs(local) <= np.array(around.size[:2]) / 2 + 1e-9).all()
    assert points[:, 2].min() == pytest.approx(0.0)
    assert points[:, 2].max() == pytest.approx(around.size[2])


def test_a_turned_box_is_the_same_box() -> None:
    around = UprightBox.around([box("car", (4.0, 2.0, 1.5), yaw=0.3)])
    assert around.turned(1).size == (2.0, 4.0, 1.5)
    assert around.turned(2).size == around.size
    assert around.turned(2).yaw == pytest.approx(0.3 + math.pi)


def test_parts_of_one_name_are_one_object_unless_they_are_several_things() -> None:
    trailer = [
        box("truck", (10, 2.5, 4), id="truck_1", instance=1),
        box("truck", (5, 2.5, 4), at=(23, 3, 0), id="truck_1.1", instance=1),
    ]
    assert names(*trailer) == [["truck_1", "truck_1.1"]]
    cars = [box("car", (4, 2, 1.5), at=(10 * k, 3, 0), id=f"car.{k}") for k in (1, 4)]
    assert names(*cars) == [["car.1"], ["car.4"]]
    numbered = [box("car", (4, 2, 1.5), at=(4 * k, 3, 0), id=f"car.{k}", instance=k) for k in (1, 2)]
    assert names(*numbered) == [["car.1"], ["car.2"]]


def test_a_rider_comes_with_the_nearest_machine() -> None:
    rider = box("rider", (0.7, 0.5, 1.0), id="rider_1")
    near, far = (box("bicycle", (1.8, 0.6, 1.1), at=(15 + off, 3, 0), id=f"bicycle_{off}") for off in (0.3, 2.0))
    assert names(far, rider, near) == [["bicycle_2.0"], ["rider_1", "bicycle_0.3"]]


def test_random_numbers_depend_on_seed_and_name_alone() -> None:
    # a fixed number: another machine, Python or process gives the same
    assert generator_of(1, "car_1").integers(10**9) == generator_of(1, "car_1").integers(10**9) == 717_818_439
    assert len({int(generator_of(seed, name).integers(10**9)) for seed in (1, 2) for name in ("car_1", "car_2")}) == 4
