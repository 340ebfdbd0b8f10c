"""Nothing through another, everything on the ground, every detail within its thing."""

import itertools
import math

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Raycaster, Sensor
from lidardraft.scene.mesh import primitive_mesh
from lidardraft.scene.road import LEFT, Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.placement.occupancy import Occupancy, object_spaces
from lidardraft.streets.placement.occupancy import touch as close
from lidardraft.streets.street import Street, make_street

STREETS = [make_street(seed) for seed in range(20)]
DOWN = Sensor(name="down", elevations=(-math.pi / 2 + 1e-4,), columns=4, min_range=0.01)


def corners(space: np.ndarray) -> np.ndarray:
    x, y, cos, sin, length, width, _, _ = space
    local = np.array([(length, width), (length, -width), (-length, -width), (-length, width)])
    return local @ np.array([[cos, sin], [-sin, cos]]) + (x, y)


def touch(one: np.ndarray, two: np.ndarray) -> bool:
    """Whether two upright boxes overlap, by projecting their corners: another way than the site's."""
    if one[6] >= two[7] or two[6] >= one[7]:
        return False
    a, b = corners(one), corners(two)
    for ring in (a, b):
        for edge in np.diff(ring, axis=0):
            normal = np.array([-edge[1], edge[0]])
            # neighbours in a row share a side, but for rounding
            if (a @ normal).max() <= (b @ normal).min() + 1e-9 or (b @ normal).max() <= (a @ normal).min() + 1e-9:
                return False
    return True


@pytest.mark.parametrize("street", STREETS, ids=lambda street: f"{street.district}-{street.seed}")
def test_nothing_goes_through_another(street: Street):
    spaces = [(placed.id, space) for placed in street.occupancy.objects for space in object_spaces(placed)]
    for (name, one), (other, two) in itertools.combinations(spaces, 2):
        if name != other and math.hypot(one[0] - two[0], one[1] - two[1]) < 60.0:
            assert not touch(one, two), (name, other)


@pytest.mark.parametrize("street", STREETS[:8], ids=lambda street: f"{street.district}-{street.seed}")
def test_everything_stands_on_the_ground(street: Street):
    ground = Raycaster(Layout(primitives=tuple(street.occupancy.ground.surfaces())))
    for placed in street.occupancy.objects:
        if placed.kind in ("grass", "house", "block", "shed"):
            continue  # begin at the lowest ground under them: test_places.py
        pose = np.eye(4)
        pose[:3, 3] = placed.x, placed.y, 30.0
        depth = ground.scan(DOWN, pose).depth.max()
        # a drive lies a little over the land
        assert abs(30.0 - depth - placed.z) < 0.2, placed


@pytest.mark.parametrize("street", STREETS[:5], ids=lambda street: f"{street.district}-{street.seed}")
def test_details_keep_within_their_thing(street: Street):
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


def test_a_site_refuses_what_has_no_room():
    road = Road()
    occupancy = Occupancy(road, Ground(road, np.random.default_rng(0)))
    car = (4.0, 1.8, 1.5)
    assert occupancy.place("suv", 0.0, 1.75, car)
    assert not occupancy.place("suv", 3.0, 1.75, car)
    assert occupancy.place("suv", 4.2, 1.75, car)
    assert not occupancy.place("hedge", 20.0, 0.0, (5.0, 1.0, 1.0), private=True)
    assert [placed.id for placed in occupancy.objects] == ["suv_1", "suv_2"]
    assert [placed.instance for placed in occupancy.objects] == [1, 2]


def test_a_car_may_stand_under_a_crown_but_not_in_a_trunk():
    road = Road()
    occupancy = Occupancy(road, Ground(road, np.random.default_rng(0)))
    assert occupancy.place("tree", 0.0, 12.0, (6.0, 6.0, 9.0), clearance=2.5)
    assert not occupancy.place("suv", 0.0, 12.0, (4.0, 1.8, 1.5))
    assert occupancy.place("suv", 0.0, 14.0, (4.0, 1.8, 1.5))
    assert not occupancy.place("house", 7.0, 12.0, (9.0, 9.0, 8.0), clearance=6.0)


def test_overlap_is_symmetric_and_right():
    rng = np.random.default_rng(1)
    yaws = rng.uniform(0, 6.3, 60)
    spaces = np.column_stack(
        [
            rng.uniform(-4, 4, (60, 2)),
            np.cos(yaws),
            np.sin(yaws),
            rng.uniform(0.2, 2.0, (60, 2)),
            np.zeros(60),
            np.ones(60),
        ]
    )
    rows = [tuple(space) for space in spaces.tolist()]
    found = np.array([[close(one, two) for two in rows] for one in rows])
    assert (found == found.T).all()
    assert (found == [[touch(one, two) for two in spaces] for one in spaces]).all()
    assert 0.05 < found.mean() < 0.95


def test_the_ground_has_kerbs_and_covers_the_street():
    road = Road(junction=20.0, side_roads=(LEFT,))
    ground = Ground(road, np.random.default_rng(2))
    assert ground.surface(0.0, 0.0) == "road"
    assert ground.surface(0.0, road.edge + 0.5) == "sidewalk"
    assert ground.surface(0.0, road.verge + 5.0) == "terrain"
    assert ground.surface(20.0, road.verge + 5.0) == "road"
    assert ground.surface(20.0, -road.verge - 5.0) == "terrain"
    assert ground.height(0.0, road.edge + 0.01) - ground.height(0.0, road.edge - 0.01) == pytest.approx(0.12, abs=0.01)
    surfaces: dict[str, Primitive] = {p.id: p for p in ground.surfaces()}
    assert set(surfaces) == {"far", "road", "sidewalk", "terrain"}
