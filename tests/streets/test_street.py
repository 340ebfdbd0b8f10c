"""A whole street: its detailed scene and its coarse layout."""

import itertools
import math
from collections import Counter

import numpy as np
import pytest
from planned import overlap

from lidardraft import CLASSES, Layout, Raycaster, Sensor
from lidardraft.errors import LayoutError
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import primitive_mesh
from lidardraft.streets import StreetConfig, make_street
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.occupancy import spaces_of
from lidardraft.streets.street import Street

STREETS = [make_street(seed) for seed in range(20)]
DOWN = Sensor(name="down", elevations=(-math.pi / 2 + 1e-4,), columns=4, min_range=0.01)


def object_spaces(placed: PlacedObject) -> np.ndarray:
    """The upright boxes [n, 8] that an object fills."""
    return np.array(spaces_of(placed.kind, placed.x, placed.y, placed.yaw, placed.size, placed.clearance))


def test_a_street_is_a_function_of_its_seed():
    assert make_street(5).scene == make_street(5).scene
    assert make_street(5).layout == make_street(5).layout
    assert make_street(5).scene != make_street(6).scene


@pytest.mark.parametrize("street", STREETS, ids=lambda street: f"{street.district}-{street.seed}")
def test_nothing_goes_through_another(street: Street):
    spaces = [(placed.id, space) for placed in street.occupancy.objects for space in object_spaces(placed)]
    for (name, one), (other, two) in itertools.combinations(spaces, 2):
        if name != other and math.hypot(one[0] - two[0], one[1] - two[1]) < 60.0:
            assert not overlap(one, two), (name, other)


@pytest.mark.parametrize("street", STREETS[:8], ids=lambda street: f"{street.district}-{street.seed}")
def test_everything_stands_on_the_ground(street: Street):
    ground = Raycaster(Layout(primitives=tuple(street.occupancy.ground.surfaces())))
    for placed in street.occupancy.objects:
        if placed.kind in ("grass", "house", "block", "shed"):
            continue  # begin at the lowest ground under them
        pose = np.eye(4)
        pose[:3, 3] = placed.x, placed.y, 30.0
        depth = ground.scan(DOWN, pose).depth.max()
        # a driveway lies a little over the land
        assert abs(30.0 - depth - placed.z) < 0.2, placed


@pytest.mark.parametrize("street", STREETS[:5], ids=lambda street: f"{street.district}-{street.seed}")
def test_details_keep_within_their_object(street: Street):
    objects = {placed.id: placed for placed in street.occupancy.objects}
    for primitive in street.scene.primitives:
        placed = objects.get(primitive.id.partition(".")[0])
        if placed is None:
            continue
        spaces = object_spaces(placed)
        vertices = primitive_mesh(primitive).vertices - (placed.x, placed.y, placed.z)
        cos, sin = math.cos(placed.yaw), math.sin(placed.yaw)
        ahead, left = vertices[:, 0] * cos + vertices[:, 1] * sin, vertices[:, 1] * cos - vertices[:, 0] * sin
        slack = 0.35 + 0.07 * max(placed.size[:2]) * (placed.kind in ("tree", "bush"))  # tips of leaves
        # a lamp's arm is not in its middle
        far = np.hypot(spaces[:, 0] - placed.x, spaces[:, 1] - placed.y).max()
        assert np.abs(ahead).max() < spaces[:, 4].max() + far + slack, primitive.id
        assert np.abs(left).max() < spaces[:, 5].max() + far + slack, primitive.id
        assert vertices[:, 2].min() > -1.0, primitive.id
        assert vertices[:, 2].max() < spaces[:, 7].max() + 0.8, primitive.id


def test_classes_and_instances_of_the_coarse_layout_are_those_of_the_scene():
    objects = {row.name for row in CLASSES if row.is_thing}
    for seed in range(5):
        street = make_street(seed)
        detailed = {(p.label, p.instance) for p in street.scene.primitives if p.label in objects}
        coarse = {(p.label, p.instance) for p in street.layout.primitives if p.label in objects}
        assert coarse == detailed
        assert all(instance > 0 for _, instance in coarse)
        assert all(p.instance == 0 for p in street.scene.primitives if p.label not in objects)


def test_every_class_occurs():
    seen = {primitive.label for seed in range(30) for primitive in make_street(seed).scene.primitives}
    assert seen >= {row.name for row in CLASSES} - {"none", "train"}


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_every_class_and_district_occurs_in_a_thousand_streets():
    places = [make_street(seed) for seed in range(1000)]
    assert {p.label for place in places for p in place.scene.primitives} == {row.name for row in CLASSES} - {"none"}
    count = Counter(place.district for place in places)
    for name, district in DISTRICTS.items():
        # four standard deviations of a binomial draw
        assert count[name] / 1000 == pytest.approx(district.share, abs=4 * (district.share / 1000) ** 0.5), name


def test_free_places_exist_in_many_streets():
    for seed in range(12):
        street = make_street(seed)
        assert street.lanes
        assert len(street.occupancy.objects) > 10
        assert len(np.concatenate([object_spaces(placed) for placed in street.occupancy.objects])) >= len(
            street.occupancy.objects
        )


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
