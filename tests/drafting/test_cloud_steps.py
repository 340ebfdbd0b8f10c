"""The steps from points to shapes: clusters and boxes, the ground, pieces of foliage and facades."""

import math
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.cluster import DBSCAN

from lidardraft.drafting.cloud import rules
from lidardraft.drafting.cloud.clustering import (
    FittedBox,
    _neighbours,
    cluster,
    completions,
    fit_box,
    fit_crown,
    fit_post,
    percentiles,
    thin,
)
from lidardraft.drafting.cloud.ground import HeightField
from lidardraft.drafting.cloud.rays import Rays
from lidardraft.drafting.cloud.refinement import Piece, refined
from lidardraft.drafting.cloud.rules import DETAILS, Detail
from lidardraft.scene.layout import Layout, Primitive, primitive_mesh
from lidardraft.scene.raycast import Raycaster
from lidardraft.semantics import BY_NAME

CAR_SIZE = (4.2, 1.8, 1.5)


def two_sides(center, size, yaw, step=0.1):
    """Points on the two sides of a box that face the origin, [N, 3]."""
    box = FittedBox(center=np.array(center), size=np.array(size), yaw=yaw)
    sensor = np.sign(box.to_local(np.zeros((1, 3)))[0])
    along = np.arange(-0.5, 0.5, step / size[0]) * size[0]
    across = np.arange(-0.5, 0.5, step / size[1]) * size[1]
    walls = [(u, sensor[1] * size[1] / 2) for u in along] + [(sensor[0] * size[0] / 2, v) for v in across]
    heights = np.linspace(-size[2] / 2, size[2] / 2, 8)
    local = np.array([(u, v, z) for u, v in walls for z in heights])
    cos, sin = math.cos(yaw), math.sin(yaw)
    return local @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + center


@settings(max_examples=20, deadline=None)
@given(x=st.floats(6, 30), y=st.floats(-15, 15), degrees=st.integers(-89, 90))
def test_a_box_is_found_from_its_two_near_sides(x, y, degrees):
    yaw = math.radians(degrees)
    box = completions(fit_box(two_sides((x, y, 0.75), CAR_SIZE, yaw)), CAR_SIZE)[0]
    np.testing.assert_allclose(box.center, (x, y, 0.75), atol=0.12)
    np.testing.assert_allclose(box.size, CAR_SIZE, atol=0.12)
    # A heading is known up to half a turn, since front and back look alike.
    assert abs(math.remainder(box.yaw - yaw, math.pi)) < math.radians(3)
    assert abs(box.yaw) <= math.pi / 2 + 1e-9


def test_a_few_stray_points_do_not_move_the_box():
    points = two_sides((10.0, 2.0, 0.75), CAR_SIZE, 0.3)
    strays = np.array([[10.0, 2.0, 9.0], [18.0, 2.0, 1.0]])
    np.testing.assert_allclose(fit_box(np.concatenate([points, strays])).size, fit_box(points).size, atol=0.15)


def test_a_single_point_becomes_a_small_box():
    box = fit_box(np.array([[5.0, 1.0, 2.0]]))
    np.testing.assert_allclose(box.center, (5, 1, 2))
    np.testing.assert_allclose(box.size, (0.1, 0.1, 0.1))


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
    box = completions(FittedBox(center=np.array(center), size=np.array(size), yaw=0.0), CAR_SIZE)[0]
    np.testing.assert_allclose(box.size, expected_size)
    np.testing.assert_allclose(box.center, expected_center)


def test_the_length_lies_along_the_yaw():
    box = completions(FittedBox(center=np.array([10.0, 0.0, 0.7]), size=np.array([1.7, 4.1, 1.4]), yaw=0.2), CAR_SIZE)[
        0
    ]
    np.testing.assert_allclose(box.size, (4.1, 1.7, 1.4))
    assert box.yaw == pytest.approx(0.2 - math.pi / 2)


def test_the_second_choice_is_the_other_way_round_then_small_ones_and_last_what_was_seen():
    seen = FittedBox(center=np.array([10.0, 0.0, 0.7]), size=np.array([0.2, 2.1, 1.4]), yaw=0.0)
    along, _, across, _, small_along, small_across, itself = completions(seen, CAR_SIZE)
    np.testing.assert_allclose(along.size, (4.2, 2.1, 1.4))
    np.testing.assert_allclose(across.size, (4.2, 1.8, 1.4))
    assert abs(across.yaw) == pytest.approx(math.pi / 2)
    np.testing.assert_allclose(small_along.size, (0.7 * 4.2, 2.1, 1.4))
    np.testing.assert_allclose(small_across.size, (0.7 * 4.2, 0.7 * 1.8, 1.4))
    np.testing.assert_allclose(itself.size, (2.1, 0.7 * 1.8, 1.4))


@pytest.mark.parametrize(
    "sides", [(0.1, 0.1), (0.65, 1.4), (2.2, 0.65), (2.7, 1.2), (4.6, 0.3), (1.9, 1.9), (6.0, 2.0)]
)
def test_no_choice_is_narrower_than_an_object_of_the_class_may_be(sides):
    seen = FittedBox(center=np.array([10.0, -4.0, 0.7]), size=np.array([*sides, 1.4]), yaw=0.4)
    for box in completions(seen, CAR_SIZE):
        assert min(box.size[:2]) >= 0.7 * 1.8 - 1e-9
        assert max(box.size[:2]) >= max(sides)


def test_a_side_too_long_for_a_width_is_a_part_of_the_length():
    # 2.4 m of the side of a car whose other end is hidden, 8 m to the left
    seen = FittedBox(center=np.array([2.0, 8.0, 0.7]), size=np.array([2.4, 0.2, 1.4]), yaw=0.0)
    for box in completions(seen, CAR_SIZE)[:2]:
        np.testing.assert_allclose(box.size, (4.2, 1.8, 1.4))
        assert box.yaw == 0.0


def test_a_side_that_something_hides_may_go_on_to_either_hand():
    # 2.4 m of the side of a car that stands across the way ahead
    seen = FittedBox(center=np.array([12.0, 1.0, 0.7]), size=np.array([0.2, 2.4, 1.4]), yaw=0.0)
    left, right = completions(seen, CAR_SIZE)[:2]
    np.testing.assert_allclose(left.center[:2], (12.8, 1.9))
    np.testing.assert_allclose(right.center[:2], (12.8, 0.1))


@pytest.mark.parametrize(("heading", "expected"), [(None, 0.0), (3.0, 0.0), (1.4, math.pi / 2), (-1.6, math.pi / 2)])
def test_of_a_side_that_may_be_a_width_or_a_length_the_neighbour_says_which(heading, expected):
    seen = FittedBox(center=np.array([12.0, 1.0, 0.7]), size=np.array([0.2, 1.6, 1.4]), yaw=0.0)
    for box in completions(seen, CAR_SIZE, heading)[:2]:
        assert abs(box.yaw) == pytest.approx(expected)


def test_a_box_contains_what_is_over_its_footprint():
    box = FittedBox(center=np.array([10.0, 0.0, 0.0]), size=np.array([4.0, 2.0, 1.0]), yaw=0.0)
    points = np.array([[8.1, 0.0, 50.0], [7.9, 0.0, 0.0], [11.0, 0.9, 0.0]])
    np.testing.assert_array_equal(box.contains(points), [True, False, True])
    np.testing.assert_array_equal(box.contains(points, margin=0.2), [False, False, False])


def blob(center, random, count=60):
    return np.array(center) + random.uniform(-0.4, 0.4, (count, 3))


def test_clusters_are_what_lies_apart_largest_first():
    random = np.random.default_rng(0)
    points = np.concatenate([blob((5, 0, 0), random), blob((5, 3, 0), random, 90), [[20.0, 20.0, 0.0]]])
    first, second = cluster(points, reach=0.5, min_points=5)
    assert set(first) == set(range(60, 150))
    assert set(second) == set(range(60))


def test_neighbours_are_further_apart_at_long_range():
    line = np.column_stack([np.zeros(20), 0.9 * np.arange(20), np.zeros(20)])
    assert len(cluster(line + np.array([80.0, 0, 0]), reach=0.4, min_points=2)) == 1
    assert cluster(line + np.array([5.0, -8.0, 0]), reach=0.4, min_points=2) == []


def test_no_points_and_equal_points_are_fine():
    assert cluster(np.zeros((0, 3)), reach=0.5, min_points=2) == []
    (only,) = cluster(np.ones((7, 3)), reach=0.5, min_points=2)
    assert len(only) == 7


def test_thinning_keeps_one_point_a_cell():
    points = np.array([[0.0, 0, 0], [0.1, 0, 0], [1.2, 0, 0], [0.2, 0.3, 0.1]])
    kept, cell, count = thin(points, 1.0)
    assert len(kept) == 2
    assert list(cell) == [0, 0, 1, 0]
    assert list(count) == [3, 1]


@pytest.mark.parametrize("seed", range(8))
def test_clusters_of_near_points_are_those_of_dbscan(seed):
    random = np.random.default_rng(seed)
    centers = random.uniform(-3, 3, (6, 3))
    points = np.concatenate([center + random.normal(0, 0.25, (30, 3)) for center in centers])
    # on a grid as coarse as thinning, and at one range, both see the same
    points = np.unique(np.round(points, 1), axis=0) * [1, 1, 1]
    reach = 0.4
    shifted = points + np.array([1e-6, 1e-6, 0.0])
    found = cluster(shifted, reach=reach, min_points=5)
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    ranges = reach + 0.01 * np.linalg.norm(shifted[:, :2], axis=1)
    scaled = distances / ((ranges[:, None] + ranges) / 2)
    expected = DBSCAN(eps=1.0, min_samples=5, metric="precomputed").fit(scaled)
    core = np.zeros(len(points), dtype=bool)
    core[expected.core_sample_indices_] = True
    groups = {frozenset(np.flatnonzero(core & (expected.labels_ == k))) for k in range(expected.labels_.max() + 1)}
    assert {frozenset(members[core[members]]) for members in found} == groups
    assert sum(map(len, found)) == np.count_nonzero(expected.labels_ >= 0)


@given(st.integers(1, 40), st.integers(0, 2**16))
def test_percentiles_are_those_of_numpy(count, seed):
    values = np.random.default_rng(seed).normal(size=(count, 3))
    shares = (1.0, 25.0, 50.0, 99.0)
    np.testing.assert_allclose(percentiles(values, shares), np.percentile(values, shares, axis=0), atol=1e-12)


def test_a_crown_looks_as_large_as_its_points_and_is_as_deep_as_half_of_them():
    random = np.random.default_rng(2)
    points = np.array([20.0, 0.0, 3.0]) + random.uniform(-1, 1, (4000, 3)) * [2.0, 1.5, 1.0]
    crown = fit_crown(points)
    np.testing.assert_allclose(crown.center, (20, 0, 3), atol=0.1)
    np.testing.assert_allclose(crown.size, (2.0, 3.0 * 1.128, 2.0 * 1.128), rtol=0.06)


def test_a_post_stands_behind_the_side_that_was_seen():
    angles = np.linspace(math.pi / 2, 3 * math.pi / 2, 30)
    side = np.array([(10 + 0.2 * math.cos(a), 0.2 * math.sin(a), z) for a in angles for z in np.arange(0, 3, 0.1)])
    post = fit_post(side)
    np.testing.assert_allclose(post.size, (0.4, 0.4, 2.9), atol=0.02)
    np.testing.assert_allclose(post.center, (10.0, 0.0, 1.45), atol=0.08)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), furthest=st.sampled_from([5.0, 60.0, 900.0]))
def test_neighbours_are_those_of_all_pairs(seed, furthest):
    rng = np.random.default_rng(seed)
    middles = rng.uniform(-1, 1, (20, 3)) * [furthest, furthest, 2.0]
    points = (middles[:, None] + rng.normal(0, 1, (20, 15, 3)) * rng.uniform(0.1, 5, (20, 1, 1))).reshape(-1, 3)
    reaches = 0.5 + 0.01 * np.linalg.norm(points[:, :2], axis=1)
    a, b = np.triu_indices(len(points), 1)
    close = np.linalg.norm(points[a] - points[b], axis=1) <= (reaches[a] + reaches[b]) / 2
    found = sorted(
        tuple(sorted(pair)) for pair in zip(*map(np.ndarray.tolist, _neighbours(points, reaches)), strict=True)
    )
    assert found == list(zip(a[close].tolist(), b[close].tolist(), strict=True))


def test_a_far_point_does_not_have_near_ones_searched_widely():
    y, z = np.meshgrid(np.arange(0, 10, 0.15), np.arange(0, 5, 0.15))
    wall = np.column_stack([np.full(y.size, 5.0), y.ravel(), z.ravel()])

    def peak(points):
        tracemalloc.start()
        found = cluster(points, reach=0.5, min_points=5)
        memory = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found, memory

    (alone,), memory = peak(wall)
    (beside,), with_far = peak(np.concatenate([wall, [[900.0, 0.0, 0.0]]]))
    np.testing.assert_array_equal(alone, beside)
    assert with_far < 1.5 * memory


ROAD, SIDEWALK, CAR = (BY_NAME[name].id for name in ("road", "sidewalk", "car"))


def plain(height=lambda x, _: 0.0 * x):
    """Points every 0.25 m of a 20 m square, road to the right and sidewalk to the left of y = 0."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(-10, 10, 0.25), np.arange(-10, 10, 0.25)))
    return np.column_stack([x, y, height(x, y)]), np.where(y < 0, ROAD, SIDEWALK)


def field(points, labels):
    return HeightField(Rays(points, np.array([0.0, 0.0, 1.7])), labels)


def test_each_class_is_one_mesh_over_one_plane():
    plane, *meshes = field(*plain()).primitives()
    assert (plane.id, plane.shape, plane.label) == ("ground", "plane", "terrain")
    assert [(mesh.id, mesh.label, mesh.shape) for mesh in meshes] == [
        ("road", "road", "mesh"),
        ("sidewalk", "sidewalk", "mesh"),
    ]
    assert plane.center[2] < min(mesh.center[2] - mesh.size[2] / 2 for mesh in meshes)


def test_neighbouring_classes_meet_without_a_gap():
    _, road, sidewalk = field(*plain(lambda x, y: 0.05 * x + 0.1 * np.sin(y))).primitives()
    corners = [{tuple(v) for v in primitive_mesh(mesh).vertices.round(6)} for mesh in (road, sidewalk)]
    edge = [{v for v in half if v[1] == 0.0} for half in corners]
    assert edge[0] == edge[1]
    assert len(edge[0]) >= 20


def test_the_height_follows_the_points_and_ignores_other_classes():
    points, labels = plain(lambda x, _: 0.1 * x)
    high = points + np.array([0.0, 0.0, 1.0])
    ground = field(np.concatenate([points, high]), np.concatenate([labels, np.full(len(high), CAR)]))
    places = np.array([[5.0, 3.0], [-7.0, -2.0], [0.0, 0.0]])
    np.testing.assert_allclose(ground.height(places), 0.1 * places[:, 0], atol=0.05)


def test_a_hole_is_bridged_and_far_land_is_not():
    points, labels = plain()
    ring = np.linalg.norm(points[:, :2], axis=1) > 3.0
    _, *meshes = field(points[ring], labels[ring]).primitives()
    cells = np.concatenate([primitive_mesh(mesh).vertices[:, :2] for mesh in meshes])
    assert np.linalg.norm(cells, axis=1).min() < 0.5
    assert np.abs(cells).max() < 15.0


def test_without_ground_points_it_is_flat():
    ground = field(np.ones((5, 3)), np.full(5, CAR))
    (plane,) = ground.primitives()
    assert plane.center[2] == 0.0
    assert ground.height(np.array([[3.0, 4.0]])) == pytest.approx([0.0])
    assert not ground.is_known(np.array([[0.0, 0.0]])).any()


def test_the_ground_is_known_near_its_points():
    known = field(*plain()).is_known(np.array([[5.0, 3.0], [11.0, 0.0], [15.0, 0.0]]))
    np.testing.assert_array_equal(known, [True, True, False])


def test_a_wall_that_is_called_road_does_not_lift_the_ground():
    points, labels = plain()
    y, z = (axis.ravel() for axis in np.meshgrid(np.arange(-4, 4, 0.25), np.arange(0.5, 3, 0.25)))
    wall = np.column_stack([np.full(len(y), 5.5), y, z])
    ground = field(np.concatenate([points, wall]), np.concatenate([labels, np.full(len(wall), ROAD)]))
    assert ground.height(np.array([[5.5, 0.5], [5.5, -2.5], [7.0, 1.0]])) == pytest.approx([0.0] * 3, abs=0.05)


ORIGIN = np.array([0.0, 0.0, 1.7])


BUILDING, VEGETATION = BY_NAME["building"].id, BY_NAME["vegetation"].id


def wall(start, end, heights=(0.0, 4.0)):
    """Points every 0.2 m on an upright wall between two places, [N, 3]."""
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    along = np.arange(0, np.linalg.norm(end - start), 0.2) / np.linalg.norm(end - start)
    flat = start + along[:, None] * (end - start)
    return np.array([(x, y, z) for x, y in flat for z in np.arange(*heights, 0.2)])


def pieces_of(points, label=BUILDING, shape="box"):
    return [Piece.from_points(points, np.arange(len(points)), label, shape, 0)]


def shares(pieces, points):
    """The shares of the rays that the pieces show near, and that they do not show."""
    layout = Layout(primitives=tuple(piece.primitive(str(k)) for k, piece in enumerate(pieces)))
    hits = Raycaster(layout).cast(ORIGIN, points - ORIGIN)
    ranges = np.linalg.norm(points - ORIGIN, axis=1)
    near = np.abs(hits.distance - ranges) <= np.maximum(0.5, 0.05 * ranges)
    return np.mean(hits.valid & near), np.mean(~hits.valid)


def test_a_wall_that_is_right_stays_whole():
    points = wall((10, -5), (10, 5))
    assert len(refined(pieces_of(points), Rays(points, ORIGIN), [], DETAILS["fine"])) == 1


@pytest.mark.parametrize("detail", ["fine", "objects"])
def test_a_corner_is_cut_until_its_walls_are_followed(detail):
    # seen from outside: one box around both hides the second wall
    points = np.concatenate([wall((30, -8), (10, -8)), wall((30, -8), (30, 12))])
    before = pieces_of(points)
    after = refined(before, Rays(points, ORIGIN), [], DETAILS[detail])
    assert shares(before, points)[0] < 0.7
    near, empty = shares(after, points)
    assert near > (0.94 if detail == "fine" else 0.75)
    assert empty < 0.01
    assert 2 <= len(after) < 16
    if detail == "objects":  # nothing is stacked that is to stand
        assert all(piece.box.size[2] > 3.5 for piece in after)


def test_what_is_seen_past_a_piece_cuts_it():
    # a hedge in two halves with a house in the gap between them
    random = np.random.default_rng(0)
    left, right = (random.uniform((8, y, 0), (9, y + 3, 2.5), (600, 3)) for y in (-5, 2))
    house = wall((20, -3), (20, 4))
    points = np.concatenate([left, right, house])
    hedge = Piece.from_points(points, np.arange(1200), VEGETATION, "ellipsoid", 0)
    behind = Piece.from_points(points, np.arange(1200, len(points)), BUILDING, "box", 0)
    assert shares([hedge, behind], house)[0] < 0.1
    assert shares(refined([hedge, behind], Rays(points, ORIGIN), [], DETAILS["fine"]), house)[0] > 0.8


def test_the_budget_holds_and_counts_what_stays():
    random = np.random.default_rng(1)
    points = random.uniform((5, -20, 0), (40, 20, 6), (6000, 3))
    box = Primitive(shape="box", center=(-9, 0, 1), size=(1, 1, 1), label="car", id="car")
    few = Detail(most_shapes=12, least_length=0.0, worth=5, least_points=3, grounded=True)
    found = refined(pieces_of(points, VEGETATION, "ellipsoid"), Rays(points, ORIGIN), [box], few)
    assert len(found) == 11
    members = np.concatenate([piece.members for piece in found])
    assert sorted(members) == list(range(6000))


def test_a_piece_that_shows_nothing_goes_unless_all_stand():
    front, hidden = wall((10, -5), (10, 5)), wall((30, -1), (30, 0), (0.0, 0.8))[:4]
    points = np.concatenate([front, hidden])
    pieces = [
        Piece.from_points(points, np.arange(len(front)), BUILDING, "box", 0),
        Piece.from_points(points, np.arange(len(front), len(points)), BUILDING, "box", 1),
    ]
    assert len(refined(pieces, Rays(points, ORIGIN), [], DETAILS["objects"])) == 2
    assert len(refined(pieces, Rays(points, ORIGIN), [], DETAILS["fine"])) == 1


def test_a_piece_is_larger_than_its_points_by_what_beams_are_apart():
    points = wall((50, -5), (50, 5))
    (piece,) = pieces_of(points)
    np.testing.assert_allclose(np.sort(piece.box.size)[1:], [3.8 + 0.3, 9.8 + 0.3], atol=0.01)


def test_points_at_one_place_cannot_be_parted():
    points = np.full((50, 3), 5.0)
    sensor_inside = Piece.from_points(points, np.arange(50), BUILDING, "box", 0)
    assert len(refined([sensor_inside], Rays(points, ORIGIN), [], DETAILS["objects"])) == 1


def test_no_pieces_are_none():
    points = np.ones((3, 3))
    assert refined([], Rays(points, ORIGIN), [], DETAILS["fine"]) == []


def test_the_rules_are_about_classes_that_exist():
    assert {*rules.POST_CLASSES, *rules.HANGING_CLASSES, *rules.REACH} <= set(BY_NAME)


def test_what_imitates_clustering_does_not_load_it():
    code = "import sys, lidardraft.streets; print(sorted({'sklearn', 'lark'} & set(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"
