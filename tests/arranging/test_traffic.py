"""Where is driven, what is painted there, and the vehicles in lanes, along the kerb and in car parks."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft import Layout, Raycaster
from lidardraft.arranging.car_parks import AISLE_WIDTH, BAY_LENGTH, BAY_WIDTH, sample_car_park
from lidardraft.arranging.district import DISTRICTS
from lidardraft.arranging.markings import road_markings
from lidardraft.arranging.traffic import place_parked_vehicles, place_traffic
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.road import LEFT, PARKING_STRIP, RIGHT, Road
from lidardraft.scene.street import MAIN_ROAD, ROUNDABOUT, SIDE_ROAD, Path, StreetFrame, paths_of
from planned import empty, occupancies, plans, surface


def test_lanes_lie_on_the_road():
    for occupancy, lanes, _ in plans():
        for lane in lanes:
            places = np.array([lane.at(share * lane.length)[:2] for share in np.linspace(0.02, 0.98, 25)])
            assert (occupancy.ground.kinds(*places.T) == 0).all(), (occupancy.road, lane)


def test_an_arc_is_followed():
    ring = Path(ROUNDABOUT, "ring", 3.0, 0.0, math.pi / 2, 20 * math.pi, 8.0, bend=0.1)
    assert ring.at(0.0) == pytest.approx((3.0, 0.0, math.pi / 2))
    # half way around a circle of 10 m about (-7, 0)
    assert ring.at(10 * math.pi)[:2] == pytest.approx((-17.0, 0.0))
    assert ring.at(5 * math.pi, 1.0)[:2] == pytest.approx((-7.0, 9.0))


def lanes_of(road: Road, parking: tuple[int, ...] = (), *, oneway: bool = False, lights: bool = False) -> list[Path]:
    return list(paths_of(StreetFrame(road=road, parked=parking, one_way=oneway, lights=lights)))


def test_traffic_keeps_to_the_right_but_in_a_one_way_street():
    for lane in lanes_of(Road(lanes=2)):
        assert math.cos(lane.angle) * lane.across < 0
    assert all(math.cos(lane.angle) > 0 for lane in lanes_of(Road(), oneway=True))


def test_parked_cars_take_room_from_the_lanes():
    road = Road(lane_width=3.0 + PARKING_STRIP / 2)
    free, narrow = lanes_of(road), lanes_of(road, (RIGHT,))
    assert len(free) == len(narrow) == 2
    assert narrow[0].across == pytest.approx(free[0].across + 0.75 * PARKING_STRIP)
    # of several lanes they take the outermost
    assert len(lanes_of(Road(lanes=2), (LEFT, RIGHT))) == 2


def test_traffic_stops_before_the_junction_at_lights_only():
    road = Road(junction=10.0)
    assert all(lane.stop is None for lane in lanes_of(road))
    stopping = [lane for lane in lanes_of(road, lights=True) if lane.stop is not None]
    assert {lane.kind for lane in stopping} == {MAIN_ROAD, SIDE_ROAD}
    for lane in stopping:
        along, across, _ = lane.at(lane.stop)
        assert road.verge + 1.5 <= max(abs(along - 10.0), abs(across)) + 1e-9 <= road.verge + 3.6
    # a roundabout has none
    around = lanes_of(Road(junction=10.0, roundabout_radius=18.0), lights=True)
    assert all(lane.stop is None for lane in around)
    assert [lane.kind for lane in around].count(ROUNDABOUT) == 1


def test_markings_lie_on_the_road():
    painted = 0
    for occupancy in occupancies()[::3]:
        surfaces = {p.id: p for p in occupancy.ground.surfaces()}
        if "markings" not in surfaces:
            continue
        painted += 1
        assert surfaces["markings"].label == "road"
        bare = Raycaster(Layout(primitives=tuple(p for name, p in surfaces.items() if name != "markings")))
        corners = primitive_mesh(surfaces["markings"]).vertices
        inner = corners.reshape(-1, 4, 3).mean(axis=1)
        hits = bare.cast(inner + np.array([0.0, 0.0, 5.0]), np.tile([0.0, 0.0, -1.0], (len(inner), 1)))
        assert (hits.label == 1).all(), occupancy.road
        over = hits.distance - 5.0
        assert over.min() > 0.002
        assert over.max() < 0.012
    assert painted > 20


def painted(road: Road, speed: float, *, lights: bool = False) -> np.ndarray:
    return road_markings(road, tuple(lanes_of(road, lights=lights)), None, speed, np.random.default_rng(4))


def test_dashes_and_gaps_are_those_of_the_guide():
    for road, speed, dash, gap, width in (
        (Road(sidewalk=0.0), 14.0, 3.0, 6.0, 0.12),
        (Road(sidewalk=0.0), 28.0, 4.0, 8.0, 0.12),
        (Road(lanes=2, sidewalk=0.0, median=4.0), 36.0, 6.0, 12.0, 0.15),
    ):
        spans = painted(road, speed)
        dashes = spans[np.isclose(spans[:, 1] - spans[:, 0], dash)]
        one = dashes[dashes[:, 2] == dashes[0, 2]]
        assert np.allclose(np.diff(one[:, 0]), dash + gap)
        assert np.allclose(one[:, 3] - one[:, 2], width)


def test_fast_roads_alone_have_edge_lines():
    whole = 2 * Road().half_length
    for speed, count in ((14.0, 0), (28.0, 2)):
        spans = painted(Road(sidewalk=0.0), speed)
        assert (np.isclose(spans[:, 1] - spans[:, 0], whole)).sum() == count


def test_stop_lines_are_before_lights_only():
    road = Road(junction=10.0, sidewalk=0.0)
    without, spans = painted(road, 14.0), painted(road, 14.0, lights=True)
    arrows = 2 * 4  # an arrow each way, in four parts
    assert len(spans) == len(without) + 4 + arrows
    extents = np.stack([spans[:, 1] - spans[:, 0], spans[:, 3] - spans[:, 2]], axis=1)
    assert (np.isclose(extents.min(axis=1), 0.5) & (extents.max(axis=1) > 1.0)).sum() == 4


def test_arrows_point_at_the_junction_that_traffic_waits_for():
    road = Road(junction=10.0, sidewalk=0.0)
    spans = painted(road, 14.0, lights=True)
    shafts = spans[np.isclose(spans[:, 3] - spans[:, 2], 0.16)]
    heads = spans[np.isclose(spans[:, 3] - spans[:, 2], 0.8)]
    assert len(shafts) == len(heads) == 2
    for shaft, head in zip(shafts, heads, strict=True):
        assert abs(head[:2].mean() - 10.0) < abs(shaft[:2].mean() - 10.0)
        assert shaft[2:].mean() == pytest.approx(head[2:].mean())


def test_junctions_of_towns_have_zebras_at_their_sidewalks():
    with_zebras = 0
    for seed in range(20):
        road = Road(junction=10.0)
        lanes = tuple(lanes_of(road, lights=True))
        spans = road_markings(road, lanes, None, 14.0, np.random.default_rng(seed))
        bars = spans[np.isclose(spans[:, 1] - spans[:, 0], 4.0) & np.isclose(spans[:, 3] - spans[:, 2], 0.5)]
        off = np.abs(bars[:, :2].mean(axis=1) - 10.0)
        with_zebras += bool(np.isclose(off, (road.edge + road.verge) / 2).any())
    assert 6 <= with_zebras <= 18


def test_traffic_drives_on_the_road():
    for occupancy, _, name in plans():
        for index, placed in enumerate(occupancy.objects):
            if placed.kind in ("bus", "truck", "trailer_truck", "motorcyclist", "cyclist", "tram"):
                placed = occupancy._placed[index]
                assert surface(occupancy.ground, placed.along, placed.across) == "road", (name, placed)


def test_traffic_keeps_its_distance():
    for occupancy, lanes, name in plans():
        if name != "motorway" or occupancy.road.curvature:
            continue
        for lane in lanes:
            inside = [
                p for p in occupancy._placed if abs(p.across - lane.across) < 0.5 and p.kind not in ("barrier", "pole")
            ]
            spans = sorted((p.along - p.size[0] / 2, p.along + p.size[0] / 2) for p in inside)
            gaps = [after[0] - before[1] for before, after in itertools.pairwise(spans)]
            assert all(gap > 1.9 for gap in gaps)


def test_parked_vehicles_stand_at_the_kerb_and_clear_of_the_junction():
    for seed in range(10):
        road = Road(lane_width=5.0, junction=10.0)
        occupancy = empty(road)
        place_parked_vehicles(occupancy, (RIGHT, LEFT), None, np.random.default_rng(seed))
        assert {np.sign(p.across) for p in occupancy._placed} == {-1, 1}
        for placed in occupancy._placed:
            kerb = road.edge - abs(placed.across) - placed.size[1] / 2
            assert 0.1 < kerb < 0.35, placed
            assert abs(math.sin(placed.angle)) < 0.1
            assert abs(placed.along - 10.0) > road.verge + 5.0


def test_vehicles_face_the_way_of_their_lane():
    for seed in range(10):
        road = Road(lanes=2, junction=20.0)
        occupancy = empty(road)
        lanes = tuple(lanes_of(road, lights=True))
        place_traffic(occupancy, DISTRICTS["urban"], lanes, np.random.default_rng(seed))
        for placed in occupancy._placed:
            along_road = abs(math.sin(placed.angle)) < 0.2
            # right-hand traffic
            right = (
                -placed.across * math.cos(placed.angle)
                if along_road
                else (placed.along - 20.0) * math.sin(placed.angle)
            )
            assert right > 0, placed


def test_wide_vehicles_keep_off_the_kerbs_of_narrow_lanes():
    road, found = Road(lane_width=2.9), 0
    lanes = lanes_of(road)
    for seed in range(10):
        occupancy = empty(road)
        place_traffic(occupancy, replace(DISTRICTS["urban"], heavy=1.0), tuple(lanes), np.random.default_rng(seed))
        for placed in (placed for placed in occupancy._placed if placed.size[1] > 2.4):
            off = min(abs(placed.across - lane.across) for lane in lanes)
            assert off <= max(0.0, (lanes[0].width - placed.size[1]) / 2 - 0.2) + 1e-9, placed
            found += 1
    assert found > 10


def test_vehicles_wait_at_the_line_of_a_red_light():
    waiting = 0
    for seed in range(20):
        road = Road(junction=20.0)
        occupancy = empty(road)
        lanes = tuple(lanes_of(road, lights=True))
        place_traffic(occupancy, DISTRICTS["urban"], lanes, np.random.default_rng(seed))
        for lane in (lane for lane in lanes if lane.stop is not None):
            for placed in occupancy._placed:
                along, across, _ = lane.at(lane.stop - placed.size[0] / 2 - 0.5)
                waiting += math.hypot(placed.along - along, placed.across - across) < 0.6
    # two lanes have a red light; by chance alone there would be few
    assert waiting > 25


def test_cars_in_a_car_park_stand_in_bays():
    seen = 0
    for occupancy in occupancies():
        for area in occupancy.road.paved_areas[:1]:
            for placed in occupancy._placed:
                turned = abs(math.sin(placed.angle)) > 0.9
                if turned and area.along[0] < placed.along < area.along[1] and placed.kind in ("suv", "hatchback"):
                    if not area.across[0] < placed.across < area.across[1]:
                        continue
                    share = (placed.along - area.along[0]) / BAY_WIDTH - 0.5
                    assert abs(share - round(share)) < 0.3
                    into = (abs(placed.across) - min(map(abs, area.across))) % (2 * BAY_LENGTH + AISLE_WIDTH)
                    assert min(abs(into - BAY_LENGTH / 2), abs(into - 1.5 * BAY_LENGTH - AISLE_WIDTH)) < 0.5
                    seen += 1
    assert seen > 50


@pytest.mark.parametrize("modules", [1, 2])
def test_a_car_park_lies_behind_the_verge_and_its_way_in_leads_to_the_road(modules: int):
    road = Road()
    for seed in range(20):
        car_park = sample_car_park(road, modules, np.random.default_rng(seed))
        near, far = sorted(map(abs, car_park.paved_area.across))
        assert near > road.verge
        assert far - near == pytest.approx(modules * (2 * BAY_LENGTH + AISLE_WIDTH))
        assert np.sign(car_park.paved_area.across).tolist() == [car_park.side] * 2
        assert sorted(map(abs, car_park.access.across)) == pytest.approx([road.edge, near])
        assert car_park.paved_area.along[0] < car_park.access.along[0] < car_park.access.along[1]
        assert car_park.access.along[1] < car_park.paved_area.along[1]
        assert len(car_park.aisles) == modules
        for across, toward in car_park.rows:
            # an aisle is where each row says
            assert (
                min(abs(across + toward * (BAY_LENGTH + AISLE_WIDTH) / 2 - aisle) for aisle in car_park.aisles) < 1e-9
            )


def test_a_car_park_is_clear_of_side_roads():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        assert sample_car_park(Road(junction=5.0, side_roads=(RIGHT,)), 1, rng).side == LEFT
        road = Road(junction=5.0)
        start, end = sample_car_park(road, 1, rng).paved_area.along
        assert start > 5.0 + road.verge or end < 5.0 - road.verge
