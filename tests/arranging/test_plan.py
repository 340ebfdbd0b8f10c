"""Districts and their roads, extents, the mix of streets, and what there is in streets of all districts."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from lidardraft.arranging import sizes
from lidardraft.arranging.district import DISTRICTS, sample_road
from lidardraft.arranging.plan import plan_street
from lidardraft.arranging.sizes import STANDING, Extents, sample_person, sample_tree
from lidardraft.arranging.street_mix import StreetMix, applied
from lidardraft.errors import LayoutError
from lidardraft.scene.road import LEFT, PARKING_STRIP, RIGHT, Road
from lidardraft.scene.street import MAIN_ROAD, paths_of
from lidardraft.streets.ego import sample_ego
from planned import occupancies, plans


def test_every_district_and_every_form_of_road_occurs():
    assert {name for _, _, name in plans()} == set(DISTRICTS)
    roads = [occupancy.road for occupancy in occupancies()]
    side_roads = Counter(
        road.side_roads for road in roads if road.junction is not None and road.roundabout_radius is None
    )
    assert set(side_roads) == {(LEFT, RIGHT), (LEFT,), (RIGHT,)}
    assert {len(road.side_roads) for road in roads if road.roundabout_radius is not None} == {1, 2}
    assert any(road.curvature > 0 for road in roads)
    assert any(road.curvature < 0 for road in roads)
    assert any(road.paved_areas for road in roads)
    assert any(road.median > 1.5 and road.sidewalk > 0 for road in roads)
    assert {road.lanes for road in roads} == {1, 2, 3}
    directions = [{math.cos(lane.angle) > 0 for lane in lanes if lane.kind == MAIN_ROAD} for _, lanes, _ in plans()]
    assert {True} in directions  # one-way
    assert {True, False} in directions
    assert any(occupancy.ground.strip > 0 for occupancy in occupancies())


def test_every_kind_of_object_occurs():
    kinds = Counter(placed.kind for occupancy in occupancies() for placed in occupancy.objects)
    wanted = """house block shed tree bush hedge lamp pole sign traffic_light fence garden_wall bin bench shelter cone
        barrier mesh_fence grass gantry wall billboard letterbox hydrant cabinet truck bus trailer_truck tram bicycle
        cyclist motorcycle motorcyclist person hatchback saloon estate suv minivan coupe pickup van"""
    assert set(wanted.split()) <= set(kinds)
    standing = [t for occupancy in occupancies() for t in occupancy.objects if t.kind == "person" and t.size[0] <= 0.3]
    assert 0.1 < len(standing) / kinds["person"] < 0.8


def test_streets_of_any_length():
    for seed in range(15):
        for half_length in (40.0, 200.0):
            frame, _ = plan_street(np.random.default_rng([seed, 77]), half_length)
            lanes = paths_of(frame.street)
            assert sample_ego(frame.occupancy, lanes, np.random.default_rng(0)).lane in lanes


def roads(name: str, count: int = 200, **options: bool) -> list[Road]:
    rng = np.random.default_rng(1)
    return [sample_road(DISTRICTS[name], (), 90.0, rng, **options) for _ in range(count)]


@pytest.mark.parametrize("name", DISTRICTS)
def test_roads_keep_to_what_their_district_says(name: str):
    district = DISTRICTS[name]
    found = roads(name)
    assert {road.lanes for road in found} == set(district.lanes)
    for road in found:
        assert district.lane_width[0] <= road.lane_width <= district.lane_width[1]
        assert district.sidewalk[0] <= road.sidewalk <= district.sidewalk[1]
        assert road.curvature == 0.0 or road.junction is None
        assert road.roundabout_radius is None or 13.0 <= road.roundabout_radius <= 25.0
    junctions = np.mean([road.junction is not None for road in found])
    # four standard deviations of a binomial draw
    assert junctions == pytest.approx(district.junction, abs=4 * (0.25 / len(found)) ** 0.5)


def test_a_road_is_straight_beside_a_car_park():
    assert any(road.curvature or road.roundabout_radius for road in roads("retail"))
    assert not any(road.curvature or road.roundabout_radius for road in roads("retail", car_park=True))


def test_parked_cars_widen_the_only_lane():
    district = replace(DISTRICTS["residential"], lane_width=(3.0, 3.0))
    widths = [
        sample_road(district, parking, 90.0, np.random.default_rng(0)).lane_width
        for parking in ((), (RIGHT,), (RIGHT, LEFT))
    ]
    assert widths == pytest.approx([3.0, 3.0 + PARKING_STRIP / 2, 3.0 + PARKING_STRIP])


def test_shares_of_districts_add_up():
    assert sum(district.share for district in DISTRICTS.values()) == pytest.approx(1.0)
    assert [name for name, district in DISTRICTS.items() if district.closed_fronts] == ["urban"]


def test_a_median_barrier_has_a_median_to_stand_in():
    for name, district in DISTRICTS.items():
        if district.equipment.median_barrier:
            assert all(road.median > 2.0 for road in roads(name))


VEHICLES = ("TRAILER_TRUCK", "TRUCK", "PARKED_TRUCK", "BUS")


def test_only_ranges_take_random_numbers():
    rng, other = np.random.default_rng(0), np.random.default_rng(0)
    assert Extents(1.0, 2.0, 3.0).sample(rng) == (1.0, 2.0, 3.0)
    length, width, height = Extents((1.0, 2.0), 5.0, (3.0, 4.0)).sample(rng)
    assert (length, width, height) == (other.uniform(1.0, 2.0), 5.0, other.uniform(3.0, 4.0))


@pytest.mark.parametrize("name", VEHICLES)
def test_vehicles_keep_to_the_limits_of_directive_96_53(name: str):
    for seed in range(20):
        length, width, height = getattr(sizes, name).sample(np.random.default_rng(seed))
        assert length <= (16.5 if name == "TRAILER_TRUCK" else 12.5)
        assert width <= 2.55
        assert height <= 4.0


def test_people_are_of_usual_stature_and_stand_or_stride():
    rng = np.random.default_rng(0)
    people = np.array([sample_person(rng, standing=False) for _ in range(2000)])
    assert np.median(people[:, 2]) == pytest.approx(1.70, abs=0.03)
    assert people[:, 2].min() >= 1.0
    assert (people[:, 2] < 1.45).mean() == pytest.approx(0.1, abs=0.03)
    assert people[:, 0].min() < 0.35 < 0.6 < people[:, 0].max()
    assert {sample_person(rng, standing=True)[0] for _ in range(20)} == {STANDING}


def test_a_crown_is_over_its_stem():
    rng = np.random.default_rng(0)
    for _ in range(200):
        (length, width, height), stem = sample_tree(rng)
        assert 0.0 < stem < 0.33 * height
        assert 0.4 * height < width < 0.7 * height
        assert length == pytest.approx(width, rel=0.11)


STREETS = 24
ONLY_URBAN = {name: 0.0 for name in DISTRICTS if name != "urban"}


def kinds(mix: StreetMix) -> Counter[str]:
    plans = [plan_street(np.random.default_rng([seed, 5]), 60.0, mix) for seed in range(STREETS)]
    return Counter(placed.kind for frame, _ in plans for placed in frame.occupancy.objects)


def test_the_usual_mix_changes_no_district():
    for district in DISTRICTS.values():
        assert applied(StreetMix(), district) == district


def test_districts_have_their_shares():
    rng = np.random.default_rng(0)
    mix = StreetMix(**ONLY_URBAN | {"motorway": 0.54, "urban": 0.18})
    counts = Counter(mix.sample_district(rng) for _ in range(2000))
    assert set(counts) == {"urban", "motorway"}
    assert counts["motorway"] / 2000 == pytest.approx(0.75, abs=0.04)
    names = {plan_street(np.random.default_rng(k), 60.0, StreetMix(**ONLY_URBAN))[1] for k in range(5)}
    assert names == {"urban"}


def test_there_is_more_of_what_is_asked_for():
    cars = ("hatchback", "saloon", "estate", "suv", "minivan")
    usual, more = kinds(StreetMix()), kinds(StreetMix(parked_cars=3.0, traffic=3.0, people=4.0, plants=0.2))
    assert sum(more[name] for name in cars) > 1.4 * sum(usual[name] for name in cars)
    assert more["person"] > 2 * usual["person"]
    assert more["tree"] < 0.7 * usual["tree"]


def test_nearly_nothing_of_a_kind_can_be_asked_for():
    usual, none = (kinds(StreetMix(**dict.fromkeys(("traffic", "people", "buildings"), k))) for k in (1.0, 0.0))
    assert none["person"] < 0.5 * usual["person"]  # some wait at stops or cross
    assert none["house"] + none["block"] < 0.3 * (usual["house"] + usual["block"])  # those along side roads
    moving = ("truck", "bus", "trailer_truck", "motorcyclist")
    assert sum(none[name] for name in moving) < 0.5 * sum(usual[name] for name in moving)  # a few trucks are parked


@pytest.mark.parametrize("value", [-1.0, float("inf"), float("nan")])
def test_an_amount_that_cannot_be_is_refused(value):
    with pytest.raises(LayoutError, match=r"people of the street mix is .*; it must be finite and 0 or more"):
        StreetMix(people=value)


def test_no_district_at_all_is_refused():
    with pytest.raises(LayoutError, match="the street mix has no district; one of residential"):
        StreetMix(**dict.fromkeys(DISTRICTS, 0.0))
