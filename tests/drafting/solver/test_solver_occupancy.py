"""What has room and what is in the way."""

import math

import numpy as np
import pytest

from lidardraft.drafting.solver.occupancy import Occupancy
from lidardraft.drafting.solver.road_pose import RoadPose
from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.drafting.text.layout import layout_from_text
from lidardraft.errors import LayoutError
from lidardraft.scene.road import Road


def occupancy(**fields: object) -> Occupancy:
    return Occupancy(Road(**fields), np.random.default_rng(0))  # type: ignore[arg-type]


def test_what_finds_no_room_says_what_is_in_the_way() -> None:
    scene, car = occupancy(), ObjectGroup(kind="car")
    assert scene.place(car.record, car, RoadPose(20.0, -1.75, 0.0)) is not None
    assert scene.place(car.record, car, RoadPose(21.0, -1.75, 0.0)) is None
    assert scene.place(car.record, car, RoadPose(1.0, -1.75, 0.0)) is None
    assert scene.place(car.record, car, RoadPose(30.0, -9.0, 0.0)) is None
    tree = ObjectGroup(kind="tree")
    assert scene.place(tree.record, tree, RoadPose(30.0, -1.0, 0.0)) is None
    assert set(scene.in_the_way) == {"car_1", "the ego vehicle", "the kerb", "the road"}


def test_nothing_stands_in_the_way_of_a_roundabout_but_those_who_drive_around() -> None:
    scene = occupancy(junction=40.0, roundabout_radius=20.0)
    car, person = ObjectGroup(kind="car"), ObjectGroup(kind="person")
    assert scene.place(car.record, car, RoadPose(40.0, 10.0, 0.0)) is None
    assert scene.place(person.record, person, RoadPose(30.0, 4.5, 0.0)) is None
    assert scene.place(car.record, car, RoadPose(40.0, 16.0, 0.0)) is None  # the wrong way round
    assert scene.place(car.record, car, RoadPose(40.0, 16.0, math.pi)) is not None


def test_a_place_that_is_excluded_stays_free() -> None:
    scene, car = occupancy(), ObjectGroup(kind="car", not_places=("left",))
    assert scene.place(car.record, car, RoadPose(30.0, 1.75, 0.0)) is None
    assert scene.place(car.record, car, RoadPose(30.0, -1.75, 0.0)) is not None


def test_objects_have_the_sizes_that_are_asked_for() -> None:
    scene = occupancy()
    wall = ObjectGroup(kind="wall", size=(None, None, 4.0))
    scene.place(wall.record, wall, RoadPose(30.0, 8.0, 0.0))
    assert scene.primitives[-1].size[2] == pytest.approx(4.0)
    large = ObjectGroup(kind="car", scale=(9.0, 9.0, 9.0))  # as large as a car can be
    assert scene.place(large.record, large, RoadPose(30.0, -1.75, 0.0)) is not None
    assert scene.primitives[-1].size == pytest.approx((6.5, 2.4, 3.0), rel=1e-5)
    long = ObjectGroup(kind="car", size=(30.0, None, None))
    with pytest.raises(LayoutError, match=r"car: length is 30 m; a car has 2\.4 to 6\.5 m"):
        scene.place(long.record, long, RoadPose(60.0, -1.75, 0.0))


def test_a_wall_of_a_length_that_is_asked_for_follows_a_bend() -> None:
    layout = layout_from_text("a left bend with a 60 m long wall on the right", seed=1)
    pieces = [primitive for primitive in layout if primitive.id.startswith("wall")]
    assert sum(piece.size[0] for piece in pieces) > 50.0
    assert max(piece.size[0] for piece in pieces) < 5.0
