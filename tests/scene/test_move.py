"""Objects that stand elsewhere in a caster, against casters of layouts that have them there."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import layouts, poses, sensors

from lidardraft.errors import LayoutError
from lidardraft.scene import edit
from lidardraft.scene.box import box_around
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.pose import rotations, upright
from lidardraft.scene.raycast import Raycaster, raycast
from lidardraft.scene.sensor import Sensor

SENSOR = Sensor(name="small", elevations=tuple(np.linspace(0.3, -0.4, 24)), columns=128, max_range=100.0)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(400, 400, 0), label="road", id="road")
CAR = Primitive(shape="box", center=(10, 1, 0.75), size=(4, 2, 1.5), label="car", id="car_1", yaw=0.4, instance=1)
CABIN = dataclasses.replace(CAR, id="van_2.cabin", center=(-9, 1, 1), size=(2, 2, 2), instance=2)
TRUNK = dataclasses.replace(CAR, id="van_2.box", center=(-12, 2.2, 1.4), size=(4, 2, 2.8), yaw=0.5, instance=2)
LAYOUT = Layout((ROAD, CAR, CABIN, TRUNK))


def differing(a, b):
    """Share of the rays that return something else."""
    return np.mean((a.instance != b.instance) | (a.label != b.label) | ~np.isclose(a.depth, b.depth, rtol=1e-4))


@pytest.mark.parametrize(("name", "object"), [("car_1", (CAR,)), ("van_2", (CABIN, TRUNK)), ("van_2.box", (TRUNK,))])
def test_a_moved_object_is_cast_where_it_stands(name, object):
    box = box_around(object)
    caster = Raycaster(LAYOUT)
    caster.move(name, upright((3.0, 6.0, box.center[2] + 0.2), box.yaw + 1.1))
    moved = {
        part.id: dataclasses.replace(
            part,
            center=tuple(upright((3.0, 6.0, box.center[2] + 0.2), 1.1) @ [*(np.subtract(part.center, box.center)), 1])[
                :3
            ],
            yaw=part.yaw + 1.1,
        )
        for part in object
    }
    there = Layout(tuple(moved.get(part.id, part) for part in LAYOUT))
    assert differing(caster.scan(SENSOR), raycast(LAYOUT, SENSOR)) > 0.01
    assert differing(caster.scan(SENSOR), raycast(there, SENSOR)) < 0.001


def test_moving_is_moving_in_the_layout():
    edited = edit.move(LAYOUT, "car_1", (2.0, -4.0, 0.0), turn=0.7)
    caster = Raycaster(LAYOUT)
    caster.move("car_1", upright(edited["car_1"].center, edited["car_1"].yaw))
    assert differing(caster.scan(SENSOR), raycast(edited, SENSOR)) < 0.001
    assert differing(caster.scan(SENSOR), raycast(LAYOUT, SENSOR)) > 0.01


@settings(max_examples=25, deadline=None)
@given(layouts().filter(len), sensors(), poses(), poses(), st.data())
def test_the_world_moved_one_way_is_the_sensor_moved_the_other(layout, sensor, pose, motion, data):
    """A tilted thing alone looks as an upright one does to a sensor that is tilted the other way."""
    one = data.draw(st.sampled_from(layout.primitives))
    alone = Raycaster(Layout((one,)))
    still = alone.scan(sensor, pose)
    alone.move(one.id, motion @ upright(one.center, one.yaw))
    moved = alone.scan(sensor, motion @ pose)
    # A ray on the rim of a shape may fall to either side of it.
    assert np.sum(
        (still.instance != moved.instance) | ~np.isclose(still.depth, moved.depth, rtol=1e-4, atol=1e-2)
    ) <= max(2, 0.02 * still.depth.size)


def test_where_it_stood_is_where_it_stands():
    caster, before = Raycaster(LAYOUT), raycast(LAYOUT, SENSOR)
    for object in ((CAR,), (CABIN, TRUNK)):
        box = box_around(object)
        name = object[0].id.partition(".")[0]
        caster.move(name, np.eye(4))
        assert differing(caster.scan(SENSOR), before) > 0.01
        caster.move(name, upright(box.center, box.yaw))
        assert differing(caster.scan(SENSOR), before) < 0.001


def test_only_the_thing_that_moved_has_moved():
    caster, before = Raycaster(LAYOUT), raycast(LAYOUT, SENSOR)
    caster.move("car_1", upright((0.0, 0.0, 60.0), 0.0))
    after = caster.scan(SENSOR)
    others = before.instance != 1
    np.testing.assert_array_equal(after.instance[others], before.instance[others])
    np.testing.assert_array_equal(after.depth[others], before.depth[others])
    assert not (after.instance == 1).any()
    assert (before.instance == 1).any()
    assert caster.layout == LAYOUT


def test_a_thing_may_be_tilted():
    caster = Raycaster(Layout((CAR,)))
    above = Sensor(name="above", elevations=(-np.pi / 2 + 1e-6,), columns=4)
    over = upright((10.0, 1.0, 20.0), 0.0)
    assert caster.scan(above, over).depth[0, 0] == pytest.approx(18.5, abs=1e-3)
    on_its_nose = upright(CAR.center, CAR.yaw)
    on_its_nose[:3, :3] = on_its_nose[:3, :3] @ rotations(np.array([[0.0, np.pi / 2, 0.0]]))[0]
    caster.move("car_1", on_its_nose)
    assert caster.scan(above, over).depth[0, 0] == pytest.approx(20 - 0.75 - 2, abs=1e-3)


def test_a_name_of_parts_is_the_object_before_it_is_a_part():
    base = dataclasses.replace(CAR, id="car_1", center=(10, 1, 0.5), size=(4, 2, 1))
    roof = dataclasses.replace(CAR, id="car_1.roof", center=(10, 1, 1.25), size=(2, 2, 0.5))
    caster = Raycaster(Layout((base, roof)))
    caster.move("car_1", upright((0.0, 0.0, 60.0), 0.0))
    assert not caster.scan(SENSOR).valid.any()


@pytest.mark.parametrize(
    ("id", "pose", "message"),
    [
        ("car_9", np.eye(4), r"no object or primitive has the id 'car_9'; the layout has road, car_1, van_2$"),
        ("car_1", np.eye(3), r"pose has shape \(3, 3\); it must be \[4, 4\]"),
        ("car_1", np.full((4, 4), np.nan), r"pose\[0, 0\] is nan; it must be finite"),
        ("car_1", np.diag([2.0, 2, 2, 1]), r"world_from_primitive\[0\]: .*R\^T R"),
        ("van_2", np.diag([1.0, -1, 1, 1]), r"world_from_primitive\[0\]: .*mirror"),
        ("van_2", np.diag([1.0, 1, 1, 2]), r"world_from_primitive\[0\]: the last row"),
    ],
)
def test_moves_that_cannot_be_change_nothing(id, pose, message):
    caster = Raycaster(LAYOUT)
    with pytest.raises(LayoutError, match=message):
        caster.move(id, pose)
    np.testing.assert_array_equal(caster.scan(SENSOR).depth, raycast(LAYOUT, SENSOR).depth)
    with pytest.raises(LayoutError, match="the layout has none"):
        Raycaster(Layout()).move("car_1", np.eye(4))
