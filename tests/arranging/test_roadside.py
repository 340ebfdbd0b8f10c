"""What stands beside roads: what authorities build, furniture, trees, buildings, gardens, people."""

import itertools
import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from lidardraft.arranging.building_rows import place_buildings, sample_building
from lidardraft.arranging.car_parks import sample_car_park
from lidardraft.arranging.clusters import place_clusters
from lidardraft.arranging.district import DISTRICTS, RoadEquipment
from lidardraft.arranging.gardens import (
    place_car_park_fences,
    place_driveways,
    place_front_fences,
    place_garden_plants,
    place_shrub_beds,
    place_thickets,
    place_yard_objects,
)
from lidardraft.arranging.ground import Ground
from lidardraft.arranging.occupancy import Occupancy, _Placement
from lidardraft.arranging.road_equipment import place_road_equipment, place_traffic_lights
from lidardraft.arranging.roadside import (
    place_high_grass,
    place_island_plants,
    place_street_furniture,
    place_street_trees,
)
from lidardraft.arranging.side_roads import (
    SideRoadEdge,
    place_beside_side_roads,
    place_side_road_buildings,
)
from lidardraft.arranging.sizes import sample_enclosure
from lidardraft.arranging.walkers import place_people
from lidardraft.scene.road import LEFT, RIGHT, Road
from planned import FLAT, empty


def equipped(road: Road, equipment: RoadEquipment, seed: int = 0) -> Occupancy:
    occupancy = empty(road)
    place_road_equipment(occupancy, replace(DISTRICTS["urban"], equipment=equipment), np.random.default_rng(seed))
    return occupancy


NOTHING = RoadEquipment(cones=0.0)
WIDE = Road(lanes=2, sidewalk=0.0, median=4.0)


def test_a_district_without_equipment_has_none_and_takes_no_random_numbers():
    rng = np.random.default_rng(0)
    occupancy = empty(Road())
    place_road_equipment(occupancy, replace(DISTRICTS["urban"], equipment=NOTHING), rng)
    assert occupancy._placed == []
    assert rng.random() == np.random.default_rng(0).random()


@pytest.mark.parametrize(
    ("fields", "kinds"),
    [
        ({"median_barrier": True}, {"barrier"}),
        ({"rails": 1.0}, {"barrier"}),
        ({"short_rails": 1.0}, {"barrier"}),
        ({"noise_walls": 1.0, "deer_fences": 1.0}, {"wall"}),
        ({"deer_fences": 1.0}, {"mesh_fence"}),
        ({"gantries": 1.0}, {"gantry"}),
        ({"delineators": True}, {"pole"}),
        ({"cones": 1.0}, {"cone"}),
    ],
)
def test_each_piece_of_equipment_is_what_its_field_says(fields: dict, kinds: set[str]):
    occupancy = equipped(WIDE, replace(NOTHING, **fields))
    assert {placed.kind for placed in occupancy._placed} == kinds
    for placed in occupancy._placed:
        if placed.kind in ("wall", "mesh_fence", "pole") or "rails" in fields:
            assert abs(placed.across) > WIDE.edge
        if "median_barrier" in fields:
            assert abs(placed.across) < WIDE.median / 2


def test_rails_face_the_road_from_end_to_end():
    occupancy = equipped(WIDE, replace(NOTHING, rails=1.0))
    for side in (-1, 1):
        rails = sorted((p.along, p.size[0]) for p in occupancy._placed if p.across * side > 0)
        assert sum(length for _, length in rails) == pytest.approx(2 * WIDE.half_length, rel=0.01)
    for placed in occupancy._placed:
        # the face is the left (+y)
        assert math.cos(placed.angle) * placed.across < 0


def test_what_is_shorter_than_a_seam_is_no_piece():
    # pieces of 12 m leave 1 cm, of which the seam takes 2
    road = replace(WIDE, half_length=30.005)
    assert 0 < 2 * road.half_length % 12.0 < 0.02
    for placed in equipped(road, replace(NOTHING, rails=1.0))._placed:
        assert placed.size[0] > 0


def test_delineators_are_fifty_metres_apart():
    occupancy = equipped(WIDE, replace(NOTHING, delineators=True))
    left = sorted(p.along for p in occupancy._placed if p.across > 0)
    assert np.diff(left) == pytest.approx(50.0)


def test_nothing_stands_in_the_junction():
    road = Road(junction=10.0, sidewalk=0.0)
    occupancy = equipped(road, replace(NOTHING, rails=1.0, noise_walls=1.0, delineators=True))
    assert occupancy._placed
    for placed in occupancy._placed:
        assert abs(placed.along - 10.0) - placed.size[0] / 2 > road.verge


def test_lights_stand_at_the_corners_and_face_the_traffic_that_comes():
    road = Road(junction=10.0)
    occupancy = empty(road)
    place_traffic_lights(occupancy, np.random.default_rng(0))
    assert {(p.along > 10.0, p.across > 0) for p in occupancy._placed} == {
        (a, b) for a in (True, False) for b in (True, False)
    }
    for placed in occupancy._placed:
        assert road.edge < abs(placed.across) < road.verge
        # a light on the right faces those who drive ahead
        assert math.cos(placed.angle) * placed.across > 0


def furnished(road: Road, name: str, seeds: int = 20, **fields: float) -> list[Occupancy]:
    district = replace(DISTRICTS[name], **fields)
    found = []
    for seed in range(seeds):
        found.append(empty(road))
        place_street_furniture(found[-1], district, None, np.random.default_rng(seed))
    return found


def test_lamps_stand_off_the_road_as_far_apart_as_their_height_allows_and_reach_over_it():
    lit = 0
    for occupancy in furnished(Road(), "residential"):
        for side in (-1, 1):
            lamps = [p for p in occupancy._placed if p.kind == "lamp" and p.across * side > 0]
            lit += bool(lamps)
            for lamp in lamps:
                assert occupancy.road.edge + 0.3 < abs(lamp.across) < occupancy.road.verge
                # the arm is to the left (+y)
                assert math.cos(lamp.angle) * lamp.across < 0
            steps = np.diff(sorted(lamp.along for lamp in lamps))
            if len(steps):
                assert 3.3 * lamps[0].size[2] - 1e-6 <= steps.min() <= 4.5 * lamps[0].size[2]
    assert lit > 20


def test_furniture_stands_on_the_sidewalk():
    kinds: Counter[str] = Counter()
    for occupancy in furnished(Road(sidewalk=4.0), "urban", 40, people=5.0):
        for placed in occupancy._placed:
            kinds[placed.kind] += 1
            assert abs(placed.across) > occupancy.road.edge, placed
            if placed.kind != "billboard":
                assert abs(placed.across) < occupancy.road.verge, placed
            if placed.kind == "sign" and abs(math.cos(placed.angle)) > 0.5:
                # the face (+x) looks at the traffic that comes on that side
                assert math.cos(placed.angle) * placed.across > 0
        assert all(abs(along) < 55.0 for along, _ in occupancy.stops)
        assert sum(placed.kind == "shelter" for placed in occupancy._placed) == len(occupancy.stops)
    assert {"lamp", "sign", "pole", "hydrant", "shelter"} <= set(kinds)


@pytest.mark.parametrize("district", ["urban", "residential"])
def test_small_things_stand_together_beside_the_road(district):
    kinds: Counter[str] = Counter()
    near = []
    for seed in range(12):
        occupancy = empty(Road(sidewalk=4.0))
        place_clusters(occupancy, DISTRICTS[district], None, np.random.default_rng(seed))
        placed = occupancy._placed
        assert all(abs(one.across) > occupancy.road.edge for one in placed)
        assert all(
            math.cos(one.angle) * one.across < 0 for one in placed if one.kind == "bench"
        )  # +y looks to the road
        kinds.update(one.kind for one in placed)
        places = np.array([(one.along, one.across) for one in placed])
        apart = np.hypot(*(places[:, None] - places).transpose(2, 0, 1)) + 99.0 * np.eye(len(places))
        near += (apart.min(axis=1) < 3.0).tolist()
    assert {"bin", "bench", "cabinet", "bicycle", "crate", "plant_tub", "cafe_table", "pole", "ground_cover"} <= set(
        kinds
    )
    assert np.mean(near) > 0.6


def test_outside_towns_there_are_signs_and_no_benches():
    kinds = {p.kind for occupancy in furnished(Road(sidewalk=0.0), "country") for p in occupancy._placed}
    assert kinds == {"sign", "lamp"}


def test_street_trees_stand_in_rows_over_what_passes_under_them():
    occupancy = empty(Road(lanes=2, median=4.0))
    place_street_trees(occupancy, replace(DISTRICTS["avenue"], street_trees=1.0), np.random.default_rng(2))
    rows = {round(abs(placed.across), 6) for placed in occupancy._placed}
    assert len(rows) <= 3
    for placed in occupancy._placed:
        assert placed.clearance >= (4.5 if placed.across == 0.0 else 2.6)
        assert placed.size[2] >= placed.clearance + 1.5 - 1e-9
    assert len(occupancy._placed) > 15


def test_an_island_keeps_its_plants_and_signs():
    road = Road(junction=10.0, roundabout_radius=20.0)
    occupancy = empty(road)
    place_island_plants(occupancy, np.random.default_rng(1))
    signs = [placed for placed in occupancy._placed if placed.kind == "sign"]
    assert len(signs) == 4
    for placed in occupancy._placed:
        assert math.hypot(placed.along - 10.0, placed.across) < road.island
    assert any(placed.kind == "bush" for placed in occupancy._placed)


def test_high_grass_grows_outside_towns():
    town, country = empty(Road()), empty(Road(sidewalk=0.0))
    for occupancy in (town, country):
        for seed in range(4):
            place_high_grass(occupancy, np.random.default_rng(seed))
    assert town._placed == []
    assert len(country._placed) > 20
    assert {placed.across > 0 for placed in country._placed} == {True, False}
    for placed in country._placed:
        assert abs(placed.across) - placed.size[1] / 2 > country.road.edge


@pytest.mark.parametrize("name", ["residential", "urban", "retail"])
def test_buildings_look_to_the_road_from_behind_the_verge(name: str):
    occupancy = empty(Road())
    place_buildings(occupancy, DISTRICTS[name], None, np.random.default_rng(0))
    sides = set()
    for placed in occupancy._placed:
        if placed.kind not in ("house", "block", "shed"):
            continue
        sides.add(placed.across > 0)
        # the front is -y
        assert math.cos(placed.angle) * placed.across > 0
        assert abs(math.sin(placed.angle)) < 0.1
        assert abs(placed.across) - placed.size[1] / 2 > occupancy.road.verge - 0.5
    assert sides == {True, False}


def test_closed_fronts_stand_wall_to_wall_and_open_rows_do_not():
    def gaps(name: str) -> np.ndarray:
        occupancy = empty(Road(sidewalk=3.0))
        place_buildings(occupancy, replace(DISTRICTS[name], blocks=1.0), None, np.random.default_rng(1))
        front = sorted(
            (p.along - p.size[0] / 2, p.along + p.size[0] / 2)
            for p in occupancy._placed
            if p.kind == "block" and 0 < p.across - p.size[1] / 2 < occupancy.road.verge + 13.0
        )
        return np.array([after[0] - before[1] for before, after in itertools.pairwise(front)])

    assert np.median(gaps("urban")) < 0.1
    assert gaps("residential").min() > 1.0


def test_a_hall_stands_behind_its_car_park():
    road = Road()
    car_park = sample_car_park(road, 1, np.random.default_rng(2))
    occupancy = Occupancy(
        replace(road, paved_areas=(car_park.paved_area,)), Ground(road, np.random.default_rng(0), FLAT)
    )
    place_buildings(occupancy, DISTRICTS["retail"], car_park, np.random.default_rng(3))
    hall = occupancy._placed[0]
    assert (hall.kind, np.sign(hall.across)) == ("shed", car_park.side)
    assert abs(hall.across) - hall.size[1] / 2 > max(map(abs, car_park.paved_area.across))


def test_a_roof_is_over_its_eaves():
    rng = np.random.default_rng(0)
    houses = [
        building
        for building in (sample_building(DISTRICTS["country"], rng) for _ in range(50))
        if building[0] == "house"
    ]
    assert houses
    assert all(1.0 < size[2] - eaves < 6.0 for _, size, eaves in houses)


def test_driveways_lead_to_the_verge_and_stay_open():
    seen = 0
    for seed in range(10):
        occupancy = empty(Road())
        rng = np.random.default_rng(seed)
        driveways = place_driveways(occupancy, DISTRICTS["residential"], rng)
        place_front_fences(occupancy, replace(DISTRICTS["residential"], front_fences=1.0), driveways, None, rng)
        fences = [p for p in occupancy._placed if p.kind in ("fence", "garden_wall", "hedge", "mesh_fence")]
        assert fences
        for side, along in driveways:
            seen += 1
            for fence in fences:
                if fence.across * side > 0:
                    assert abs(fence.along - along) > fence.size[0] / 2 + 1.4, (fence, along)
    assert seen > 50


def test_no_driveway_leads_through_a_ditch():
    road = Road(sidewalk=0.0)
    counts = []
    for ditch in (0.0, 1.0):
        ground = Ground(road, np.random.default_rng(0), replace(FLAT, ditch=ditch))
        counts.append(len(place_driveways(Occupancy(road, ground), DISTRICTS["residential"], np.random.default_rng(1))))
    assert counts[0] > 3
    assert counts[1] < counts[0]


def test_closed_fronts_have_no_front_gardens():
    occupancy = empty(Road())
    assert place_driveways(occupancy, DISTRICTS["urban"], np.random.default_rng(0)) == []
    place_shrub_beds(occupancy, DISTRICTS["urban"], np.random.default_rng(0))
    assert occupancy._placed == []


def test_gaps_of_closed_fronts_are_fenced():
    occupancy, district = empty(Road(sidewalk=3.0)), replace(DISTRICTS["urban"], setback=(0.0, 0.0), front_fences=1.0)
    place_buildings(occupancy, district, None, np.random.default_rng(0))
    before = len(occupancy._placed)
    place_front_fences(occupancy, district, [], None, np.random.default_rng(0))
    blocks, fences = occupancy._placed[:before], occupancy._placed[before:]
    assert len(fences) > 6
    for fence in fences:
        assert occupancy.road.verge < abs(fence.across) < occupancy.road.verge + 1.0
        # none stands right before a wall, but for fronts that step back
        line = [
            block for block in blocks
            if block.across * fence.across > 0 and abs(block.along - fence.along) < block.size[0] / 2
            and abs(block.across) - block.size[1] / 2 < occupancy.road.verge + 0.1
        ]  # fmt: skip
        assert not line


def test_hedges_are_as_frequent_as_their_district_says():
    rng = np.random.default_rng(0)
    for green in (0.0, 0.3, 1.0):
        kinds = [sample_enclosure(green, rng)[0] for _ in range(600)]
        assert np.mean([kind in ("hedge", "overgrown_fence") for kind in kinds]) == pytest.approx(green, abs=0.07)


def test_car_parks_are_fenced_behind_and_at_their_ends_and_open_to_the_road():
    rng, road = np.random.default_rng(3), Road(sidewalk=2.0, half_length=90.0)
    car_park = sample_car_park(road, 1, rng)
    occupancy = empty(replace(road, paved_areas=(car_park.paved_area, car_park.access)))
    for _ in range(4):
        place_car_park_fences(occupancy, DISTRICTS["retail"], car_park, rng)
    (start, end), far = car_park.paved_area.along, max(map(abs, car_park.paved_area.across))
    behind = [p for p in occupancy._placed if abs(p.across) > far]
    ends = [p for p in occupancy._placed if not start < p.along < end]
    assert len(behind) > 2
    assert len(ends) > 2
    assert len(behind) + len(ends) == len(occupancy._placed)
    assert all(p.across * car_park.side > 0 for p in occupancy._placed)


def test_gardens_begin_behind_the_verge():
    occupancy = empty(Road())
    district, rng = DISTRICTS["residential"], np.random.default_rng(0)
    for _ in range(4):
        place_yard_objects(occupancy, district, rng)
    for place in (place_shrub_beds, place_thickets, place_garden_plants):
        before = len(occupancy._placed)
        place(occupancy, district, rng)
        assert len(occupancy._placed) > before, place.__name__
    for placed in occupancy._placed:
        assert abs(placed.across) > occupancy.road.verge, placed
    assert {"bush", "tree", "bin", "bicycle"} <= {placed.kind for placed in occupancy._placed}


def test_an_edge_is_a_frame_of_its_side_road():
    # the left edge of a side road that leaves to the left is behind the junction
    assert SideRoadEdge(10.0, LEFT, LEFT).at(30.0, 4.0) == pytest.approx((6.0, 30.0, math.pi / 2))
    assert SideRoadEdge(10.0, LEFT, RIGHT).at(30.0, 4.0) == pytest.approx((14.0, 30.0, math.pi / 2))
    assert SideRoadEdge(10.0, RIGHT, LEFT).at(30.0, 4.0) == pytest.approx((14.0, -30.0, -math.pi / 2))


@pytest.mark.parametrize("sides", [(LEFT,), (RIGHT,), (LEFT, RIGHT)])
def test_there_are_objects_beside_the_side_roads_only(sides: tuple[int, ...]):
    district = replace(DISTRICTS["residential"], built=1.0, people=20.0, parked=1.0, street_trees=1.0)
    road = Road(junction=10.0, side_roads=sides, lane_width=6.0)
    occupancy = empty(road)
    place_side_road_buildings(occupancy, district, np.random.default_rng(0))
    place_beside_side_roads(occupancy, district, np.random.default_rng(0))
    kinds = {placed.kind for placed in occupancy._placed}
    assert {"house", "lamp", "tree", "person"} <= kinds
    assert {np.sign(placed.across) for placed in occupancy._placed} == set(sides)
    for placed in occupancy._placed:
        off = abs(placed.along - 10.0)
        if placed.kind in ("house", "shed", "block"):
            assert off - placed.size[1] / 2 > road.verge
            # the front (-y) looks to the side road
            assert math.sin(placed.angle) * (placed.along - 10.0) < 0
        if placed.kind == "lamp":
            assert road.edge < off < road.verge
            # the arm (+y) reaches over the side road
            assert -math.sin(placed.angle) * (10.0 - placed.along) > 0


def test_there_is_nothing_without_a_junction():
    occupancy = empty(Road())
    place_side_road_buildings(occupancy, DISTRICTS["residential"], np.random.default_rng(0))
    place_beside_side_roads(occupancy, DISTRICTS["residential"], np.random.default_rng(0))
    assert occupancy._placed == []


def people(road: Road, number: float, *, lights: bool = False, seed: int = 0) -> list[_Placement]:
    occupancy = empty(road)
    place_people(occupancy, replace(DISTRICTS["urban"], people=number), lights, np.random.default_rng(seed))
    return occupancy._placed


def test_nobody_is_where_no_people_are():
    assert people(Road(), 0.0) == []


def test_who_is_on_the_road_crosses_it():
    road = Road(sidewalk=4.0)
    found = [placed for seed in range(10) for placed in people(road, 12.0, seed=seed)]
    on_road = [placed for placed in found if abs(placed.across) < road.edge]
    assert 0 < len(on_road) < 0.2 * len(found)
    assert all(abs(math.cos(placed.angle)) < 0.6 for placed in on_road)
    assert all(abs(placed.across) < road.verge + 1.0 for placed in found)


def test_people_wait_at_all_corners_with_lights_and_look_across():
    road = Road(junction=10.0, sidewalk=3.0)
    corners = set()
    for seed in range(20):
        for placed in people(road, 8.0, lights=True, seed=seed):
            ahead, side = placed.along - 10.0, placed.across
            if abs(ahead) < road.verge and road.edge < abs(side) < road.edge + 1.0:
                corners.add((ahead > 0, side > 0))
                assert math.sin(placed.angle) * side < 0
    assert len(corners) == 4


def test_people_wait_at_a_bus_stop():
    road = Road(sidewalk=4.0)
    occupancy = empty(road)
    occupancy.stops.append((15.0, -1.0))
    for seed in range(5):
        place_people(occupancy, replace(DISTRICTS["urban"], people=0.0), False, np.random.default_rng(seed))
    assert occupancy._placed
    assert all(abs(p.along - 15.0) < 8.0 and -road.verge < p.across < -road.edge for p in occupancy._placed)
