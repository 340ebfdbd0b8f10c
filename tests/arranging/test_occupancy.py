"""Nothing goes through another, and everything stands on the ground."""

import numpy as np
import pytest

from lidardraft.arranging.sizes import RAILING, SITE_FENCE
from lidardraft.scene.road import PavedArea, Road
from planned import empty, frame_corners, occupancies

PRIVATE = {"fence", "garden_wall", "hedge", "mesh_fence", "house", "block", "shed"}
RIDDEN = ("cyclist", "motorcyclist")


def test_what_has_no_room_is_refused():
    road = Road()
    occupancy = empty(road)
    car = (4.0, 1.8, 1.5)
    assert occupancy.place("suv", 0.0, 1.75, car)
    assert not occupancy.place("suv", 3.0, 1.75, car)
    assert occupancy.place("suv", 4.2, 1.75, car)
    assert not occupancy.place("hedge", 20.0, 0.0, (5.0, 1.0, 1.0), private=True)
    assert [placed.id for placed in occupancy.objects] == ["suv_1", "suv_2"]
    assert [placed.instance for placed in occupancy.objects] == [1, 2]


def test_a_car_may_stand_under_a_crown_but_not_in_a_trunk():
    road = Road()
    occupancy = empty(road)
    assert occupancy.place("tree", 0.0, 12.0, (6.0, 6.0, 9.0), clearance=2.5)
    assert not occupancy.place("suv", 0.0, 12.0, (4.0, 1.8, 1.5))
    assert occupancy.place("suv", 0.0, 14.0, (4.0, 1.8, 1.5))
    assert not occupancy.place("house", 7.0, 12.0, (9.0, 9.0, 8.0), clearance=6.0)


def test_instances_are_numbered_without_gaps():
    for occupancy in occupancies():
        numbers = [
            t.instance + extra for t in occupancy.objects if t.instance for extra in range(1 + (t.kind in RIDDEN))
        ]
        assert sorted(numbers) == list(range(1, len(numbers) + 1))


def test_private_objects_keep_off_the_public_way():
    for occupancy in occupancies():
        for index, placed in enumerate(occupancy.objects):
            of_street = placed.size[0] in (RAILING.length, SITE_FENCE.length)
            if placed.kind in PRIVATE and not of_street and not occupancy.road.curvature and not occupancy.ground.paved:
                corners = frame_corners(occupancy, index)
                kinds = occupancy.ground.kinds(corners[:, 0], corners[:, 1])
                assert (kinds == 2).all(), placed


def test_objects_stand_where_the_ground_is():
    for occupancy in occupancies():
        along, across = np.array([(p.along, p.across) for p in occupancy._placed]).T
        height = occupancy.ground.heights(along, across)
        for placed, ground in zip(occupancy.objects, height, strict=True):
            if placed.kind in ("house", "block", "shed", "grass"):
                assert placed.z <= ground + 1e-9
                corners = occupancy.ground.heights(*frame_corners(occupancy, occupancy.objects.index(placed)).T)
                # the plinth reaches 0.8 m down; a medium of grass none
                assert placed.z - (0.8 if placed.kind != "grass" else 1e-9) <= corners.min()
            else:
                assert placed.z == pytest.approx(ground)


def test_private_objects_keep_off_driveways():
    road = Road()
    occupancy = empty(road)
    fence = (4.0, 0.1, 1.0)
    at = (10.0, road.verge + 3.0)
    occupancy.add_driveway(PavedArea((8.0, 12.0), (road.verge, road.verge + 6.0)))
    assert not occupancy.place("fence", *at, fence, private=True)
    assert occupancy.place("suv", *at, (4.0, 1.8, 1.5))


def test_what_is_free_and_private_is_what_place_says():
    road = Road()
    occupancy = empty(road)
    assert occupancy.place("suv", 0.0, 0.0, (4.0, 1.8, 1.5))
    x, y, yaw = road.at(3.0, 0.0)
    assert not occupancy.is_free(x, y, yaw, (4.0, 1.8, 1.5))
    x, y, yaw = road.at(30.0, road.verge + 5.0)
    assert occupancy.is_free(x, y, yaw, (4.0, 1.8, 1.5))
    assert occupancy.is_private(x, y, yaw, (4.0, 1.8, 1.5))
    assert not occupancy.is_private(*road.at(30.0, 0.0), (4.0, 1.8, 1.5))


def test_nothing_is_placed_beyond_the_ground():
    road = Road()
    occupancy = empty(road)
    assert not occupancy.place("tree", 1000.0, 0.0, (4.0, 4.0, 8.0), clearance=2.0)
    assert occupancy.objects == []
