"""The steps from points to shapes: clusters and boxes, the ground, pieces of foliage and facades."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components
from sklearn.cluster import DBSCAN

from lidardraft import _core
from lidardraft.drafting.cloud.fitting import completions, contain, fit_box, fit_post
from lidardraft.drafting.cloud.ground import GROUND_IDS, surfaces
from lidardraft.drafting.cloud.layout import clusters_of
from lidardraft.drafting.cloud.rules import DETAILS
from lidardraft.scene.layout import Layout, Primitive, primitive_mesh
from lidardraft.scene.raycast import Raycaster
from lidardraft.semantics import BY_NAME

CAR_SIZE = (4.2, 1.8, 1.5)


def two_sides(center, size, yaw, step=0.1):
    """Points on the two sides of a box that face the origin, [N, 3]."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    sensor = np.sign(turn @ -np.array(center))
    along = np.arange(-0.5, 0.5, step / size[0]) * size[0]
    across = np.arange(-0.5, 0.5, step / size[1]) * size[1]
    walls = [(u, sensor[1] * size[1] / 2) for u in along] + [(sensor[0] * size[0] / 2, v) for v in across]
    heights = np.linspace(-size[2] / 2, size[2] / 2, 8)
    return np.array([(u, v, z) for u, v in walls for z in heights]) @ turn + center


def completed(center, size, yaw, heading=math.nan):
    """The boxes [7, 7] that a car may have of which one was seen."""
    return completions(np.array([[*center, *size, yaw]]), CAR_SIZE, np.array([heading]))[:, 0]


@settings(max_examples=20, deadline=None)
@given(x=st.floats(6, 30), y=st.floats(-15, 15), degrees=st.integers(-89, 90))
def test_a_box_is_found_from_its_two_near_sides(x, y, degrees):
    yaw = math.radians(degrees)
    seen = fit_box(two_sides((x, y, 0.75), CAR_SIZE, yaw))
    box = completed(seen[:3], seen[3:6], seen[6])[0]
    np.testing.assert_allclose(box[:6], (x, y, 0.75, *CAR_SIZE), atol=0.12)
    # A heading is known up to half a turn, since front and back look alike.
    assert abs(math.remainder(box[6] - yaw, math.pi)) < math.radians(3)
    assert abs(box[6]) <= math.pi / 2 + 1e-9


def test_a_few_stray_points_do_not_move_the_box():
    points = two_sides((10.0, 2.0, 0.75), CAR_SIZE, 0.3)
    strays = np.array([[10.0, 2.0, 9.0], [18.0, 2.0, 1.0]])
    np.testing.assert_allclose(fit_box(np.concatenate([points, strays]))[3:6], fit_box(points)[3:6], atol=0.15)


@pytest.mark.parametrize(
    ("size", "center", "expected_size", "expected_center"),
    [
        # Seen from behind: the back is the width, the length grows to the front.
        ((0.2, 1.7, 1.4), (10.0, 0.0, 0.7), (4.2, 1.7, 1.4), (12.0, 0.0, 0.7)),
        # Seen from the side, to the left of the sensor: grows to the left.
        ((4.0, 0.2, 1.4), (0.0, 8.0, 0.7), (4.0, 1.8, 1.4), (0.0, 8.8, 0.7)),
        # The same behind the sensor and to its right.
        ((4.0, 0.2, 1.4), (-9.0, -8.0, 0.7), (4.0, 1.8, 1.4), (-9.0, -8.8, 0.7)),
        # Longer than the class: stays.
        ((5.0, 2.0, 1.4), (9.0, 0.0, 0.7), (5.0, 2.0, 1.4), (9.0, 0.0, 0.7)),
    ],
)
def test_the_unseen_side_grows_away_from_the_sensor(size, center, expected_size, expected_center):
    np.testing.assert_allclose(completed(center, size, 0.0)[0, :6], (*expected_center, *expected_size))


def test_the_length_lies_along_the_yaw():
    box = completed((10.0, 0.0, 0.7), (1.7, 4.1, 1.4), 0.2)[0]
    np.testing.assert_allclose(box[3:], (4.1, 1.7, 1.4, 0.2 - math.pi / 2))


@pytest.mark.parametrize(
    "sides", [(0.1, 0.1), (0.65, 1.4), (2.2, 0.65), (2.7, 1.2), (4.6, 0.3), (1.9, 1.9), (6.0, 2.0)]
)
def test_no_choice_is_narrower_than_an_object_of_the_class_may_be(sides):
    boxes = completed((10.0, -4.0, 0.7), (*sides, 1.4), 0.4)
    assert (boxes[:, 3:5].min(axis=1) >= 0.7 * 1.8 - 1e-9).all()
    assert (boxes[:, 3:5].max(axis=1) >= max(sides)).all()


@pytest.mark.parametrize(("margin", "expected"), [(0.0, [True, False, True]), (0.2, [False, False, False])])
def test_a_box_contains_what_is_over_its_footprint(margin, expected):
    boxes = np.array([[10.0, 0.0, 0.0, 4.0, 2.0, 1.0, 0.0], [0.0, 10.0, 0.0, 4.0, 2.0, 1.0, math.pi / 2]])
    for along, across, inside in zip((8.1, 7.9, 11.0), (0.0, 0.0, 0.9), expected, strict=True):
        assert contain(boxes, np.array([along, across]), margin).tolist() == [inside, False]
        assert contain(boxes, np.array([-across, along]), margin).tolist() == [False, inside]


@pytest.mark.parametrize("seed", range(8))
def test_clusters_of_near_points_are_those_of_dbscan(seed):
    random = np.random.default_rng(seed)
    centers = random.uniform(-3, 3, (6, 3))
    points = np.concatenate([center + random.normal(0, 0.25, (30, 3)) for center in centers])
    # on a grid as coarse as thinning, and at one range, both see the same
    points = np.unique(np.round(points, 1), axis=0) * [1, 1, 1]
    reach = 0.4
    shifted = points + np.array([1e-6, 1e-6, 0.0])
    found = clusters_of(shifted, reach, 5)
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    ranges = reach + 0.01 * np.linalg.norm(shifted[:, :2], axis=1)
    scaled = distances / ((ranges[:, None] + ranges) / 2)
    expected = DBSCAN(eps=1.0, min_samples=5, metric="precomputed").fit(scaled)
    core = np.zeros(len(points), dtype=bool)
    core[expected.core_sample_indices_] = True
    groups = {frozenset(np.flatnonzero(core & (expected.labels_ == k))) for k in range(expected.labels_.max() + 1)}
    assert {frozenset(members[core[members]]) for members in found} == groups
    assert sum(map(len, found)) == np.count_nonzero(expected.labels_ >= 0)


def test_a_post_stands_behind_the_side_that_was_seen():
    angles = np.linspace(math.pi / 2, 3 * math.pi / 2, 30)
    side = np.array([(10 + 0.2 * math.cos(a), 0.2 * math.sin(a), z) for a in angles for z in np.arange(0, 3, 0.1)])
    post = fit_post(side)
    np.testing.assert_allclose(post[3:6], (0.4, 0.4, 2.9), atol=0.02)
    np.testing.assert_allclose(post[:3], (10.0, 0.0, 1.45), atol=0.08)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), furthest=st.sampled_from([5.0, 60.0, 900.0]))
def test_clusters_are_those_of_all_pairs_at_any_range(seed, furthest):
    """Single links, on points so far apart that none are searched as one, far and near ones together."""
    rng = np.random.default_rng(seed)
    middles = rng.uniform(-1, 1, (20, 3)) * [furthest, furthest, 2.0]
    points = (middles[:, None] + rng.normal(0, 1, (20, 15, 3)) * rng.uniform(0.1, 5, (20, 1, 1))).reshape(-1, 3)
    apart = np.linalg.norm(points[:, None] - points, axis=2) + 9.0 * np.eye(len(points))
    points = points[~np.tril(apart < 0.25).any(axis=1)]  # a cell of 0.125 m is 0.22 m across
    reaches = 0.5 + 0.01 * np.linalg.norm(points[:, :2], axis=1)
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    _, number = connected_components(apart <= (reaches[:, None] + reaches) / 2, directed=False)
    expected = {frozenset(np.flatnonzero(number == one).tolist()) for one in np.unique(number)}
    assert {frozenset(members.tolist()) for members in clusters_of(points, 0.5, 1)} == expected


ROAD, SIDEWALK, CAR = (BY_NAME[name].id for name in ("road", "sidewalk", "car"))


def plain(height=lambda x, _: 0.0 * x):
    """Points every 0.25 m of a 20 m square, road to the right and sidewalk to the left of y = 0."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(-10, 10, 0.25), np.arange(-10, 10, 0.25)))
    return np.column_stack([x, y, height(x, y)]), np.where(y < 0, ROAD, SIDEWALK)


def field(points, labels):
    return cloud_of(points).ground(labels.astype(np.uint8), list(GROUND_IDS))


def cloud_of(points):
    return _core.Cloud(points, origin=(0.0, 0.0, 1.7), most_rays=50_000)


def test_each_class_is_one_mesh_over_one_plane():
    plane, *meshes = surfaces(field(*plain()))
    assert (plane.id, plane.shape, plane.label) == ("ground", "plane", "terrain")
    assert [(mesh.id, mesh.label, mesh.shape) for mesh in meshes] == [
        ("road", "road", "mesh"),
        ("sidewalk", "sidewalk", "mesh"),
    ]
    assert plane.center[2] < min(mesh.center[2] - mesh.size[2] / 2 for mesh in meshes)


def test_neighbouring_classes_meet_without_a_gap():
    _, road, sidewalk = surfaces(field(*plain(lambda x, y: 0.05 * x + 0.1 * np.sin(y))))
    corners = [{tuple(v) for v in primitive_mesh(mesh).vertices.round(6)} for mesh in (road, sidewalk)]
    edge = [{v for v in half if v[1] == 0.0} for half in corners]
    assert edge[0] == edge[1]
    assert len(edge[0]) >= 20


def test_the_height_follows_the_points_and_ignores_other_classes():
    points, labels = plain(lambda x, _: 0.1 * x)
    high = points + np.array([0.0, 0.0, 1.0])
    ground = field(np.concatenate([points, high]), np.concatenate([labels, np.full(len(high), CAR)]))
    places = np.array([[5.0, 3.0], [-7.0, -2.0], [0.0, 0.0]])
    np.testing.assert_allclose(ground.heights(places)[0], 0.1 * places[:, 0], atol=0.05)


def test_a_hole_is_bridged_and_far_land_is_not():
    points, labels = plain()
    ring = np.linalg.norm(points[:, :2], axis=1) > 3.0
    _, *meshes = surfaces(field(points[ring], labels[ring]))
    cells = np.concatenate([primitive_mesh(mesh).vertices[:, :2] for mesh in meshes])
    assert np.linalg.norm(cells, axis=1).min() < 0.5
    assert np.abs(cells).max() < 15.0


def test_the_ground_is_known_near_its_points():
    away = field(*plain()).heights(np.array([[5.0, 3.0], [11.0, 0.0], [150.0, 0.0]]))[1]
    np.testing.assert_allclose(away, [0.5, 1.5, 140.5], atol=0.5)


def test_a_wall_that_is_called_road_does_not_lift_the_ground():
    points, labels = plain()
    y, z = (axis.ravel() for axis in np.meshgrid(np.arange(-4, 4, 0.25), np.arange(0.5, 3, 0.25)))
    wall = np.column_stack([np.full(len(y), 5.5), y, z])
    ground = field(np.concatenate([points, wall]), np.concatenate([labels, np.full(len(wall), ROAD)]))
    assert ground.heights(np.array([[5.5, 0.5], [5.5, -2.5], [7.0, 1.0]]))[0] == pytest.approx([0.0] * 3, abs=0.05)


ORIGIN = np.array([0.0, 0.0, 1.7])


def wall(start, end, heights=(0.0, 4.0)):
    """Points every 0.2 m on an upright wall between two places, [N, 3]."""
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    along = np.arange(0, np.linalg.norm(end - start), 0.2) / np.linalg.norm(end - start)
    flat = start + along[:, None] * (end - start)
    return np.array([(x, y, z) for x, y in flat for z in np.arange(*heights, 0.2)])


def refined(points, detail="fine", clusters=None, crowns=None, others=(), **changes):
    """The clusters [Q] and boxes [Q, 7] that the points [N, 3] become; by default all are one facade."""
    cloud, detail = cloud_of(points), replace(DETAILS[detail], **changes)
    return cloud.refined(
        clusters=np.ones(len(points), dtype=np.uint32) if clusters is None else clusters.astype(np.uint32),
        crowns=np.zeros(len(points), dtype=bool) if crowns is None else crowns,
        boxes=np.array(others, dtype=float).reshape(-1, 7),
        posts=np.zeros(len(others), dtype=bool),
        ground=cloud.ground(np.zeros(len(points), dtype=np.uint8), list(GROUND_IDS)),
        most_pieces=detail.most_shapes,
        least_length=detail.least_length,
        worth=detail.worth,
        grounded=detail.grounded,
    )


def hits_of(shape, boxes, points):
    """Of rays to points [N, 3]: which meet shapes in boxes [Q, 7], which end before their point, and which there."""
    solids = [
        Primitive(
            shape=shape, center=box[:3].tolist(), size=box[3:6].tolist(), yaw=float(box[6]), label="other", id=str(k)
        )
        for k, box in enumerate(boxes)
    ]
    hits = Raycaster(Layout(primitives=tuple(solids))).cast(ORIGIN, points - ORIGIN)
    ranges = np.linalg.norm(points - ORIGIN, axis=1)
    further, tolerance = hits.distance - ranges, np.maximum(0.5, 0.05 * ranges)
    return hits.valid, hits.valid & (further < -tolerance), hits.valid & (np.abs(further) <= tolerance)


@pytest.mark.parametrize("detail", ["fine", "objects"])
def test_a_corner_is_cut_until_its_walls_are_followed(detail):
    # seen from outside: one box around both hides the second wall
    points = np.concatenate([wall((30, -8), (10, -8)), wall((30, -8), (30, 12))])
    before, after = refined(points, "objects", worth=1e9)[1], refined(points, detail)[1]
    assert len(before) == 1
    assert hits_of("box", before, points)[2].mean() < 0.7
    met, _, near = hits_of("box", after, points)
    assert near.mean() > (0.94 if detail == "fine" else 0.75)
    assert met.mean() > 0.99
    assert 2 <= len(after) < 16
    if detail == "objects":  # nothing is stacked that is to stand
        assert (after[:, 5] > 3.5).all()


def test_what_is_seen_past_a_piece_cuts_it():
    # a hedge in two halves with a house in the gap between them
    random = np.random.default_rng(0)
    left, right = (random.uniform((8, y, 0), (9, y + 2, 2.5), (600, 3)) for y in (-3, 1))
    house = wall((20, -2), (20, 2))
    points = np.concatenate([left, right, house])
    is_hedge = np.arange(len(points)) < 1200
    for detail, worth, low, high in (("objects", 1e9, 0.0, 0.1), ("fine", 5, 0.8, 1.0)):
        clusters, boxes = refined(points, detail, clusters=np.where(is_hedge, 1, 2), crowns=is_hedge, worth=worth)
        met, _, _ = hits_of("ellipsoid", boxes[clusters == 1], house)
        assert low <= (~met).mean() <= high


def test_the_budget_holds_and_nothing_that_is_to_stand_is_left_out():
    random = np.random.default_rng(1)
    points = random.uniform((5, -20, 0), (40, 20, 6), (6000, 3))
    clusters, boxes = refined(
        points, "objects", crowns=np.ones(6000, dtype=bool), most_shapes=11, least_length=0.0, worth=5
    )
    assert len(boxes) == 11
    assert (clusters == 1).all()


def test_a_piece_that_shows_nothing_goes_unless_all_stand():
    front, hidden = wall((10, -5), (10, 5)), wall((30, -1), (30, 0), (0.0, 0.8))[:4]
    points = np.concatenate([front, hidden])
    clusters = np.where(np.arange(len(points)) < len(front), 1, 2)
    assert refined(points, "objects", clusters)[0].tolist() == [1, 2]
    assert refined(points, "fine", clusters)[0].tolist() == [1]


def test_what_stands_before_a_piece_and_stays_is_not_its_fault():
    points = wall((10, -5), (10, 5))
    assert len(refined(points, others=[(5, 0, 1, 1, 12, 6, 0)], worth=0.5, least_points=0)[1]) == 0
    assert len(refined(points, "objects", others=[(5, 0, 1, 1, 12, 6, 0)], worth=0.5, least_length=0.0)[1]) == 1


def test_a_piece_is_larger_than_its_points_by_what_beams_are_apart():
    (box,) = refined(wall((50, -5), (50, 5)))[1]
    np.testing.assert_allclose(np.sort(box[3:6])[1:], [3.8 + 0.3, 9.8 + 0.3], atol=0.01)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_rays_through_boxes_are_counted_as_one_by_one(seed):
    """Boxes anywhere, also around, above and behind the sensor, against casts of every ray."""
    random = np.random.default_rng(seed)
    points = random.normal(0, 1, (2000, 3)) * [20, 20, 4] + [0, 0, 1]
    weights = random.uniform(0.5, 3, 2000)
    boxes = np.column_stack(
        [random.normal(0, 1, (20, 3)) * [8, 8, 2], random.uniform(0.2, 6, (20, 3)), random.uniform(-7, 7, 20)]
    )
    expected = []
    for box in boxes:
        _, hidden, _ = hits_of("box", box[None], points)
        cos, sin = math.cos(box[6]), math.sin(box[6])
        local = np.abs((points - box[:3]) @ [[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])[:, :2]
        inside = (local < box[3:5] / 2).all(axis=1) & (points[:, 2] > box[2] - box[5] / 2)
        expected.append(weights[hidden & ~inside].sum())
    np.testing.assert_allclose(cloud_of(points).passed(weights, boxes, boxes), expected, rtol=1e-6, atol=1e-6)
