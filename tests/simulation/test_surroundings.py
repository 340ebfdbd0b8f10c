"""What a rule learns of the layout around an object: its roads, fronts and backs."""

import math

import numpy as np
import pytest
from coarse_boxes import box

from lidardraft import Layout, Primitive
from lidardraft.scene.road import Road
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.surroundings import RoadStrip, Surroundings, road_strips


def test_only_clusterings_know_no_front_from_back() -> None:
    assert Surroundings.of(Layout(provenance={"source": "point cloud", "sensor_height": 1.7})).clustered
    assert Surroundings.of(Layout(provenance={"source": "my.bin", "sensor_height": 1.7})).clustered
    assert Surroundings.of(Layout(provenance={"source": "cloud"})).clustered
    assert not Surroundings.of(Layout(provenance={"source": "text", "seed": 1})).clustered
    assert not Surroundings.of(Layout()).clustered


def test_across_the_road_either_heading_is_as_likely() -> None:
    around = Surroundings((), clustered=True)
    heads = 0
    for seed in range(200):
        coarse = CoarseObject.of([box("car", (4, 2, 1.5), yaw=math.pi / 2)], seed, "car_1")
        heads += around.headed(coarse, coarse.box()).yaw > math.pi
    assert 70 < heads < 130


def test_the_road_side_is_that_of_the_nearest_road_or_of_the_ego() -> None:
    roads = [
        Primitive(shape="plane", center=(0, y, 0), size=(100, 8, 0), label="road", id=f"road_{y}") for y in (0, 60)
    ]
    around = Surroundings.of(Layout(primitives=tuple(roads)))
    assert around.road_side(UprightBox(30, 20, 0, 0.0, (9, 9, 6)))[1] < 0
    assert around.road_side(UprightBox(30, 45, 0, 0.0, (9, 9, 6)))[1] > 0
    assert Surroundings.of(Layout()).road_side(UprightBox(30, 20, 0, 0.0, (9, 9, 6))) == (-30, -20)


def strips(*primitives: Primitive) -> list[RoadStrip]:
    return list(road_strips(Layout(primitives=primitives)))


@pytest.mark.parametrize("curvature", [0.0, 0.01, -0.01])
def test_the_frame_of_a_road_is_found(curvature: float) -> None:
    road = Road(curvature=curvature, lanes=2, parking=2.2)
    (strip,) = strips(*road.surfaces())
    assert strip.half == pytest.approx(road.edge)
    assert strip.top == 0.0
    assert strip.length == pytest.approx(160.0, abs=0.1)
    along, across = np.array([-50.0, 0.0, 33.0]), np.array([3.0, -2.0, 7.0])
    places = road.points(along, across)
    found = strip.along_across(places)
    assert found[0] - 80.0 == pytest.approx(along, abs=0.2)
    assert found[1] == pytest.approx(across, abs=0.02)
    assert strip.at(*found) == pytest.approx(places, abs=0.03)
    x, y = strip.nearest(*places[2].tolist())
    assert math.hypot(x - places[2, 0], y - places[2, 1]) == pytest.approx(7.0, abs=0.1)


def test_side_roads_have_frames_of_their_own() -> None:
    found = strips(*Road(junction=30.0).surfaces())
    assert [strip.id for strip in found] == ["road", "road_left", "road_right"]


@pytest.mark.parametrize("yaw", [0.0, 0.4, math.pi / 2, 3.0])
def test_a_rectangle_is_a_road_along_its_longer_side(yaw: float) -> None:
    for size, turn in (((60, 7, 0), 0.0), ((7, 60, 0), math.pi / 2)):
        (strip,) = strips(Primitive(shape="plane", center=(9, 1, 0.2), size=size, label="road", id="a", yaw=yaw - turn))
        assert (strip.length, strip.half, strip.top) == pytest.approx((60.0, 3.5, 0.2))
        (x, y), (u, v) = strip.middle.tolist()
        assert abs(math.sin(math.atan2(v - y, u - x) - yaw)) == pytest.approx(0.0, abs=1e-9)


def test_squares_puddles_painted_surfaces_and_fields_of_triangles_are_no_roads() -> None:
    vertices = np.array([(x, y, 0.05 * x) for x in range(5) for y in range(5)], dtype=float) * 4
    faces = np.array([(a, a + 1, a + 6) for a in range(18)])
    assert not strips(
        Primitive(shape="plane", center=(0, 0, 0), size=(20, 20, 0), label="road", id="a"),
        Primitive(shape="plane", center=(0, 0, 0), size=(4, 2, 0), label="road", id="b"),
        Primitive(shape="plane", center=(0, 0, 0), size=(60, 7, 0), label="road", id="c", material="gravel"),
        Primitive.from_mesh(vertices, faces, label="road", id="d"),
        Primitive(shape="plane", center=(0, 0, 0), size=(1e8, 40, 0), label="road", id="f"),
        Primitive(shape="cylinder", center=(0, 0, 0), size=(60, 7, 1), label="road", id="e"),
    )
