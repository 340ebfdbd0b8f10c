"""What there is in streets of all quarters, where it stands, and where the ego vehicle may be."""

import itertools
import math
from collections import Counter

import numpy as np
import pytest

from lidardraft import Layout, Raycaster
from lidardraft.scene.mesh import primitive_mesh
from lidardraft.scene.road import LEFT, RIGHT
from lidardraft.scene.sensor import PRESETS
from lidardraft.streets.ego import EGO_SIZE, Ego, mount, sample_ego
from lidardraft.streets.ground.ground import _cut
from lidardraft.streets.placement.car_parks import AISLE_WIDTH, BAY_LENGTH, BAY_WIDTH
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.lanes import AISLE, MAIN_ROAD, ROUNDABOUT, SIDE_ROAD, Lane
from lidardraft.streets.placement.occupancy import Occupancy, box_space, spaces_of, touch
from lidardraft.streets.placement.plan import plan_street

PLACES = [plan_street(np.random.default_rng([seed, 9]), 90.0) for seed in range(120)]
SITES = [occupancy for occupancy, _, _ in PLACES]
PRIVATE = {"fence", "garden_wall", "hedge", "mesh_fence", "house", "block", "shed"}
RIDDEN = ("cyclist", "motorcyclist")
LONG = {"fence", "garden_wall", "mesh_fence", "wall", "barrier"}


def egos(number: int = 6) -> list[tuple[Occupancy, Ego]]:
    found = []
    for index, (occupancy, lanes, _) in enumerate(PLACES):
        rng = np.random.default_rng([index, 4])
        found += [(occupancy, sample_ego(occupancy, lanes, rng)) for _ in range(number)]
    return found


EGOS = egos()


def test_every_quarter_and_every_form_of_road_occurs():
    assert {name for _, _, name in PLACES} == set(DISTRICTS)
    roads = [occupancy.road for occupancy in SITES]
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
    directions = [{math.cos(lane.angle) > 0 for lane in lanes if lane.kind == MAIN_ROAD} for _, lanes, _ in PLACES]
    assert {True} in directions  # one-way
    assert {True, False} in directions
    assert any(occupancy.ground.strip > 0 for occupancy in SITES)


def test_every_kind_of_thing_occurs():
    kinds = Counter(placed.kind for occupancy in SITES for placed in occupancy.objects)
    wanted = """house block shed tree bush hedge lamp pole sign traffic_light fence garden_wall bin bench shelter cone
        barrier mesh_fence grass gantry wall billboard letterbox hydrant cabinet truck bus trailer_truck tram bicycle
        cyclist motorcycle motorcyclist person hatchback saloon estate suv minivan coupe pickup van"""
    assert set(wanted.split()) <= set(kinds)
    standing = [t for occupancy in SITES for t in occupancy.objects if t.kind == "person" and t.size[0] <= 0.3]
    assert 0.1 < len(standing) / kinds["person"] < 0.8


def test_instances_are_numbered_without_gaps():
    for occupancy in SITES:
        numbers = [
            t.instance + extra for t in occupancy.objects if t.instance for extra in range(1 + (t.kind in RIDDEN))
        ]
        assert sorted(numbers) == list(range(1, len(numbers) + 1))


def frame_corners(occupancy: Occupancy, index: int) -> np.ndarray:
    """Corners [4, 2] along and across of a thing as it was put."""
    placed = occupancy._placed[index]
    half = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * placed.size[:2] / 2
    cos, sin = math.cos(placed.angle), math.sin(placed.angle)
    return half @ np.array([[cos, sin], [-sin, cos]]) + (placed.along, placed.across)


def test_private_things_keep_off_the_public_way():
    for occupancy in SITES:
        for index, placed in enumerate(occupancy.objects):
            if placed.kind in PRIVATE and not occupancy.road.curvature and not occupancy.ground.paved:
                corners = frame_corners(occupancy, index)
                kinds = occupancy.ground.kinds(corners[:, 0], corners[:, 1])
                assert (kinds == 2).all(), placed


def test_traffic_drives_on_the_road():
    for occupancy, _, name in PLACES:
        for index, placed in enumerate(occupancy.objects):
            if placed.kind in ("bus", "truck", "trailer_truck", "motorcyclist", "cyclist", "tram"):
                placed = occupancy._placed[index]
                assert occupancy.ground.surface(placed.along, placed.across) == "road", (name, placed)


def test_things_stand_where_the_ground_is():
    for occupancy in SITES:
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


def test_long_things_follow_the_ground():
    off = []
    for occupancy in SITES:
        for index, placed in enumerate(occupancy.objects):
            if placed.kind in LONG:
                corners = frame_corners(occupancy, index)
                off.append(np.abs(occupancy.ground.heights(*corners.T) - placed.z).max())
    assert np.quantile(off, 0.9) < 0.2
    assert max(off) < 0.75


def test_the_road_rises_and_falls():
    rise = [float(np.ptp(occupancy.ground.heights(np.linspace(-80, 80, 81), np.zeros(81)))) for occupancy in SITES]
    assert np.median(rise) > 0.5
    assert max(rise) < 8.0
    for occupancy in SITES:
        grades = [occupancy.ground.grade(float(along)) for along in np.linspace(-90, 90, 31)]
        assert max(map(abs, grades)) < 0.061


def horizon(occupancy: Occupancy) -> np.ndarray:
    """Elevation [rad] of the land's edge around a sensor over the middle of the street."""
    along, across = np.meshgrid(np.linspace(-80, 80, 41), np.linspace(-60, 60, 31), indexing="ij")
    heights = occupancy.ground.heights(along.ravel(), across.ravel())
    distance = np.hypot(along.ravel(), across.ravel())
    far = distance > 15.0
    elevation = np.arctan2(heights[far] - occupancy.ground.height(0.0, 0.0) - 1.73, distance[far])
    sector = ((np.arctan2(across.ravel(), along.ravel())[far] + math.pi) / (2 * math.pi) * 24).astype(int) % 24
    return np.array([elevation[sector == number].max() for number in range(24)])


def test_the_horizon_is_no_flat_line():
    spread = [float(np.ptp(horizon(occupancy))) for occupancy in SITES]
    # a flat plane of this extent has a horizon between -0.029 and -0.015 rad
    assert np.median(spread) > 0.02
    assert max(spread) > 0.1


def test_heights_and_classes_are_those_of_the_mesh():
    down = np.tile([0.0, 0.0, -1.0], (500, 1))
    for occupancy in SITES[::4]:
        rng = np.random.default_rng(2)
        along, across = rng.uniform(-100, 100, 500), rng.uniform(-40, 40, 500)
        bare = [p for p in occupancy.ground.surfaces() if p.id not in ("drives", "markings")]
        origins = np.column_stack([occupancy.road.points(along, across), np.full(500, 30.0)])
        hits = Raycaster(Layout(primitives=tuple(bare))).cast(origins, down)
        off = np.abs(30.0 - hits.distance - occupancy.ground.heights(along, across))
        # chords of circles and bends move a kerb by some centimetres, and the island of a roundabout is made of facets
        assert np.quantile(off, 0.95) < (0.02 if occupancy.road.roundabout_radius is None else 0.07)
        assert off.max() < 0.21
        labels = np.array([1, 2, 10, 10])[occupancy.ground.kinds(along, across)]
        assert (labels == hits.label).mean() > 0.99


def test_heights_are_the_same_from_all_sides():
    for occupancy in SITES[::6]:
        rng = np.random.default_rng(1)
        along, across = rng.uniform(-80, 80, 300), rng.uniform(-50, 50, 300)
        step = 1e-4
        jump = np.abs(
            occupancy.ground.relief.heights(along + step, across + step)
            - occupancy.ground.relief.heights(along, across)
        )
        assert jump.max() < 1e-2


def test_the_ground_has_few_triangles():
    for occupancy in SITES[::4]:
        meshes = [p.mesh for p in occupancy.ground.surfaces() if p.mesh is not None]
        assert sum(len(mesh.faces) for mesh in meshes) <= 6000


def test_the_ego_vehicle_is_free_and_on_the_road_of_its_lane():
    for occupancy, ego in EGOS:
        assert occupancy.is_free(ego.x, ego.y, ego.yaw, EGO_SIZE)
        mine = box_space(ego.x, ego.y, ego.yaw, EGO_SIZE[:2], 0.0, EGO_SIZE[2])
        for placed in occupancy.objects:
            if math.hypot(placed.x - ego.x, placed.y - ego.y) < 30.0:
                for space in spaces_of(placed.kind, placed.x, placed.y, placed.yaw, placed.size, placed.clearance):
                    assert not touch(mine, space), placed
        assert 0.0 <= ego.speed <= 1.1 * ego.lane.speed + 1e-9
    names = Counter(ego.lane.kind for _, ego in EGOS)
    assert set(names) == {MAIN_ROAD, SIDE_ROAD, ROUNDABOUT, AISLE}
    assert names[MAIN_ROAD] > 0.6 * len(EGOS)
    speeds = np.array([ego.speed for _, ego in EGOS])
    assert (speeds == 0.0).mean() > 0.05
    assert speeds.max() > 30.0


def test_lanes_lie_on_the_road():
    for occupancy, lanes, _ in PLACES:
        for lane in lanes:
            places = np.array([lane.at(share * lane.length)[:2] for share in np.linspace(0.02, 0.98, 25)])
            assert (occupancy.ground.kinds(*places.T) == 0).all(), (occupancy.road, lane)


def test_the_ego_pose_is_rigid_and_lies_on_the_road():
    for _, ego in EGOS:
        assert ego.pose[:3, :3] @ ego.pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(ego.pose[:3, :3]) == pytest.approx(1.0)
        assert math.atan2(ego.pose[1, 0], ego.pose[0, 0]) == pytest.approx(ego.yaw)
        assert ego.pose[2, 2] > math.cos(0.12)
        assert abs(ego.pose[2, 0] - 0.0) < 0.12
        assert ego.pose[:3, 3] == pytest.approx((ego.x, ego.y, ego.z))
    tilted = [abs(ego.pose[2, 0]) for _, ego in EGOS]
    assert np.median(tilted) > 0.003


def test_the_road_passes_under_the_wheels():
    for occupancy, ego in EGOS:
        if occupancy.road.curvature or ego.lane.kind == ROUNDABOUT:
            continue
        # on a straight road the frame is the layout's, but for the place of the ego lane
        shift = occupancy.road.lane(occupancy.road.ego_lane)
        wheels = np.array([(sx * 1.35, sy * 0.8, 0.0) for sx in (-1, 1) for sy in (-1, 1)])
        world = wheels @ ego.pose[:3, :3].T + ego.pose[:3, 3]
        ground = occupancy.ground.heights(world[:, 0], world[:, 1] + shift)
        assert np.abs(ground - world[:, 2]).max() < 0.06


def test_a_lean_is_small_and_grows_with_speed_in_bends():
    sensor = PRESETS["hdl64e"]
    heights = []
    for index, (_, ego) in enumerate(EGOS):
        pose = mount(sensor, ego, np.random.default_rng(index))
        assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
        assert pose[2, 2] > math.cos(math.radians(3.5))
        heights.append(pose[2, 3])
    assert 0.01 < np.std(heights) < 0.06
    ring = [ego.lean[0] for _, ego in EGOS if ego.lane.kind == ROUNDABOUT and ego.speed > 6.0]
    # a roundabout is a left bend: the car leans to its right
    assert np.mean(ring) > 0.002


def test_cars_in_a_car_park_stand_in_bays():
    seen = 0
    for occupancy in SITES:
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


def test_traffic_keeps_its_distance():
    for occupancy, lanes, name in PLACES:
        if name != "motorway" or occupancy.road.curvature:
            continue
        for lane in lanes:
            inside = [
                p for p in occupancy._placed if abs(p.across - lane.across) < 0.5 and p.kind not in ("barrier", "pole")
            ]
            spans = sorted((p.along - p.size[0] / 2, p.along + p.size[0] / 2) for p in inside)
            gaps = [after[0] - before[1] for before, after in itertools.pairwise(spans)]
            assert all(gap > 1.9 for gap in gaps)


def test_levels_are_those_of_the_drawing():
    for occupancy in SITES[::3]:
        rng = np.random.default_rng(5)
        along, across = rng.uniform(-80, 80, 400), rng.uniform(-30, 30, 400)
        condition_image = Raycaster(Layout(primitives=tuple(occupancy.road.surfaces())))
        origins = np.column_stack([occupancy.road.points(along, across), np.full(400, 10.0)])
        top = 10.0 - condition_image.cast(origins, np.tile([0.0, 0.0, -1.0], (400, 1))).distance
        # but for the chords of bends and circles, and the sidewalk that a drawing has across a way in
        assert (np.abs(top - occupancy.ground.levels(along, across)) < 1e-3).mean() > 0.97, occupancy.road


def test_markings_lie_on_the_road():
    painted = 0
    for occupancy in SITES[::3]:
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


def test_spans_are_cut_where_lines_cross_them():
    spans = np.array([(0.0, 10.0, 0.0, 1.0), (3.5, 4.5, 2.0, 3.0)])
    pieces = _cut(spans, np.array([-5.0, 2.0, 3.0, 10.0]), 0)
    assert pieces.tolist() == [[0, 2, 0, 1], [2, 3, 0, 1], [3, 10, 0, 1], [3.5, 4.5, 2, 3]]
    assert _cut(spans, np.array([2.5]), 1).tolist() == [[0, 10, 0, 1], [3.5, 4.5, 2, 2.5], [3.5, 4.5, 2.5, 3]]


def test_streets_of_any_reach():
    for seed in range(30):
        for reach in (40.0, 200.0):
            occupancy, lanes, _ = plan_street(np.random.default_rng([seed, 77]), reach)
            assert sample_ego(occupancy, lanes, np.random.default_rng(0)).lane in lanes


def test_an_arc_is_followed():
    ring = Lane(kind=ROUNDABOUT, along=3.0, across=0.0, angle=math.pi / 2, length=20 * math.pi, speed=8.0, bend=0.1)
    assert ring.at(0.0) == pytest.approx((3.0, 0.0, math.pi / 2))
    # half way around a circle of 10 m about (-7, 0)
    assert ring.at(10 * math.pi)[:2] == pytest.approx((-17.0, 0.0))
    assert ring.at(5 * math.pi, 1.0)[:2] == pytest.approx((-7.0, 9.0))


def test_a_site_is_a_function_of_its_generator():
    for seed in (0, 3, 8):
        one, two = (plan_street(np.random.default_rng([seed]), 90.0) for _ in range(2))
        assert one[0].objects == two[0].objects
        assert one[1:] == two[1:]
        assert (one[0].ground.heights(*np.ones((2, 3))) == two[0].ground.heights(*np.ones((2, 3)))).all()
