"""A whole street: its detailed scene and its coarse layout, and where the ego vehicle is in it."""

import math
from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from lidardraft import CLASSES
from lidardraft.arranging.district import DISTRICTS
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.errors import LayoutError
from lidardraft.objects.kinds import kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.sensor import PRESETS
from lidardraft.scene.solids import Solid, penetration
from lidardraft.scene.street import AISLE, MAIN_ROAD, ROUNDABOUT, SIDE_ROAD
from lidardraft.streets import StreetConfig, make_street
from lidardraft.streets.ego import EGO_SPACE, Ego, mount, sample_ego
from lidardraft.streets.street import Street
from planned import overlap, plans


@cache
def street_of(seed: int) -> Street:
    return make_street(seed=seed)


def object_spaces(placed: PlacedObject) -> np.ndarray:
    """The upright boxes [n, 8] that an object fills."""
    return np.array([solid[:8] for solid in kind_of(placed.kind).solids(placed.place, placed.size, placed.clearance)])


def test_a_street_is_a_function_of_its_seed():
    again = make_street(seed=5)
    assert again.scene == street_of(5).scene
    assert again.layout == street_of(5).layout
    assert again.scene != street_of(6).scene


@pytest.mark.parametrize("seed", range(20))
def test_nothing_goes_through_another(seed: int):
    spaces = [(placed.id, space) for placed in street_of(seed).occupancy.objects for space in object_spaces(placed)]
    boxes = np.stack([space for _, space in spaces])
    reach = np.hypot(boxes[:, 4], boxes[:, 5])  # half the diagonal
    apart = np.hypot(*(boxes[:, None, :2] - boxes[:, :2]).transpose(2, 0, 1))
    for i, k in np.argwhere(np.triu(apart <= reach[:, None] + reach, 1)):
        assert spaces[i][0] == spaces[k][0] or not overlap(boxes[i], boxes[k]), (spaces[i][0], spaces[k][0])


def test_classes_and_instances_of_the_coarse_layout_are_those_of_the_scene():
    objects = {row.name for row in CLASSES if row.is_thing}
    for seed in range(5):
        street = street_of(seed)
        detailed = {(p.label, p.instance) for p in street.scene.primitives if p.label in objects}
        coarse = {(p.label, p.instance) for p in street.layout.primitives if p.label in objects}
        assert coarse == detailed
        assert all(instance > 0 for _, instance in coarse)
        assert all(p.instance == 0 for p in street.scene.primitives if p.label not in objects)


def test_every_class_occurs():
    seen = {primitive.label for seed in range(30) for primitive in street_of(seed).scene.primitives}
    assert seen >= {row.name for row in CLASSES} - {"none", "train"}


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_every_class_and_district_occurs_in_a_thousand_streets():
    places = [make_street(seed=seed) for seed in range(1000)]
    assert {p.label for place in places for p in place.scene.primitives} == {row.name for row in CLASSES} - {"none"}
    count = Counter(place.district for place in places)
    for name, district in DISTRICTS.items():
        # four standard deviations of a binomial draw
        assert count[name] / 1000 == pytest.approx(district.share, abs=4 * (district.share / 1000) ** 0.5), name


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"poses_per_street": 0}, "poses_per_street is 0; a street is scanned at least once"),
        ({"half_length": 10.0}, r"half_length is 10\.0 m; it must be 40 to 200 m"),
        ({"half_length": float("nan")}, "half_length is nan m"),
    ],
)
def test_config_errors(fields: dict, message: str):
    with pytest.raises(LayoutError, match=message):
        StreetConfig(**fields)


@cache
def egos(number: int = 6) -> list[tuple[Occupancy, Ego]]:
    found = []
    for index, (occupancy, lanes, _) in enumerate(plans()):
        rng = np.random.default_rng([index, 4])
        found += [(occupancy, sample_ego(occupancy, lanes, rng)) for _ in range(number)]
    return found


def test_the_ego_vehicle_is_free_and_on_the_road_of_its_lane():
    for occupancy, ego in egos():
        assert occupancy.is_free(ego.x, ego.y, ego.yaw, EGO_SPACE)
        mine = Solid.box(ego.x, ego.y, ego.yaw, EGO_SPACE[:2], 0.0, EGO_SPACE[2])
        for placed in occupancy.objects:
            if math.hypot(placed.x - ego.x, placed.y - ego.y) < 30.0:
                for space in kind_of(placed.kind).solids(placed.place, placed.size, placed.clearance):
                    assert not penetration(mine, space), placed
        assert 0.0 <= ego.speed <= 1.1 * ego.lane.speed + 1e-9
    names = Counter(ego.lane.kind for _, ego in egos())
    assert set(names) == {MAIN_ROAD, SIDE_ROAD, ROUNDABOUT, AISLE}
    assert names[MAIN_ROAD] > 0.6 * len(egos())
    speeds = np.array([ego.speed for _, ego in egos()])
    assert (speeds == 0.0).mean() > 0.05
    assert speeds.max() > 30.0


def test_the_ego_pose_is_rigid_and_lies_on_the_road():
    for _, ego in egos():
        assert ego.pose[:3, :3] @ ego.pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(ego.pose[:3, :3]) == pytest.approx(1.0)
        assert math.atan2(ego.pose[1, 0], ego.pose[0, 0]) == pytest.approx(ego.yaw)
        assert ego.pose[2, 2] > math.cos(0.12)
        assert abs(ego.pose[2, 0] - 0.0) < 0.12
        assert ego.pose[:3, 3] == pytest.approx((ego.x, ego.y, ego.z))
    tilted = [abs(ego.pose[2, 0]) for _, ego in egos()]
    assert np.median(tilted) > 0.003


def test_the_road_passes_under_the_wheels():
    for occupancy, ego in egos():
        if occupancy.road.curvature or ego.lane.kind == ROUNDABOUT or ego.lane.width < 2.2:
            continue  # in the narrowest lanes a wheel may be on the kerb
        # on a straight road the frame is the layout's, but for the place of the ego lane
        shift = occupancy.road.lane(occupancy.road.ego_lane)
        wheels = np.array([(sx * 1.35, sy * 0.8, 0.0) for sx in (-1, 1) for sy in (-1, 1)])
        world = wheels @ ego.pose[:3, :3].T + ego.pose[:3, 3]
        ground = occupancy.ground.heights(world[:, 0], world[:, 1] + shift)
        assert np.abs(ground - world[:, 2]).max() < 0.06


def test_a_lean_is_small_and_grows_with_speed_in_bends():
    sensor = PRESETS["hdl64e"]
    heights = []
    for index, (_, ego) in enumerate(egos()):
        pose = mount(sensor, ego, np.random.default_rng(index))
        assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
        assert pose[2, 2] > math.cos(math.radians(3.5))
        heights.append(pose[2, 3])
    assert 0.01 < np.std(heights) < 0.06
    ring = [ego.lean[0] for _, ego in egos() if ego.lane.kind == ROUNDABOUT and ego.speed > 6.0]
    # a roundabout is a left bend: the car leans to its right
    assert np.mean(ring) > 0.002


def test_a_street_without_a_free_place_is_refused():
    occupancy, lanes, _ = plans()[0]
    beyond = replace(lanes[0], along=80.0, angle=0.0, length=5.0)
    with pytest.raises(LayoutError, match=r"no free place of 4\.5 x 2\.2 m"):
        sample_ego(occupancy, (beyond,), np.random.default_rng(0))
