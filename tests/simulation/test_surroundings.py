"""What a rule learns of the layout around an object."""

import math

from coarse_boxes import box

from lidardraft import Layout, Primitive
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.surroundings import Surroundings


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
