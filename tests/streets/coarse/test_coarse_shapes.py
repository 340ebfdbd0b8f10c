"""The shapes that stand in for those of clustering and of the solver of sentences."""

import numpy as np
import pytest
from scanned import EGO, OBJECTS, STREET, VISIBLE

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.objects.kinds import KINDS, kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.road import Road
from lidardraft.semantics import BY_NAME, NUM_CLASSES
from lidardraft.streets.coarse.cluster_shapes import PointGroups, cluster_shapes
from lidardraft.streets.coarse.coarse_street import ShapeColumns
from lidardraft.streets.coarse.solver_shapes import solver_shapes


@pytest.mark.parametrize("numbered", [True, False])
def test_shapes_are_of_what_was_seen(numbered: bool):
    street = STREET.coarse
    grounds = street.heights_over(EGO.pose)
    yaws = street.places[:, 2] - VISIBLE.place[2]
    found = cluster_shapes(VISIBLE, yaws, grounds, street.diameters, np.random.default_rng(0), numbered=numbered)
    owners, labels = found.keys // NUM_CLASSES, found.keys % NUM_CLASSES
    assert (VISIBLE.returns[owners, labels] > 0).all()
    assert (found.sizes > 0).all()
    # what stands begins on the ground or more than 2.5 m over it
    bottom = found.centers[2] - found.sizes[2] / 2
    car = labels == BY_NAME["car"].id
    assert car.any()
    assert (bottom[car] <= grounds[owners[car]] + 1e-9).all()
    x, y, _ = VISIBLE.place
    away = np.array([np.hypot(OBJECTS[k].x - x, OBJECTS[k].y - y) for k in owners[car]])
    assert np.abs(np.hypot(*found.centers[:2, car]) - away).max() < 6.0


FENCE = BY_NAME["fence"].id


def groups(*clouds: np.ndarray, yaw: float = 0.0) -> PointGroups:
    """A group of fence for each cloud [N, 3]."""
    counts = np.array([len(cloud) for cloud in clouds])
    keys = np.arange(len(clouds)) * NUM_CLASSES + FENCE
    return PointGroups(np.concatenate(clouds).T, np.cumsum(counts) - counts, keys, np.full(len(clouds), yaw))


def line(start: float, end: float, number: int, yaw: float = 0.0) -> np.ndarray:
    """Points [number, 3] along a line through the origin."""
    along = np.linspace(start, end, number)
    return np.stack([along * np.cos(yaw), along * np.sin(yaw), np.zeros(number)], axis=1)


def pieces(found: PointGroups) -> list[int]:
    return sorted(found.counts.tolist())


def test_a_gap_wider_than_the_reach_cuts():
    broken = np.concatenate([line(0, 3, 31), line(4, 6, 21)])
    for yaw in (0.0, 0.7, 2.0):
        turned = broken @ np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
        cut = groups(turned, yaw=yaw)
        reach = np.full(len(broken), 0.8)
        assert pieces(cut.linked(reach, np.ones(1), 6)) == [21, 31]
        assert pieces(cut.linked(reach + 0.4, np.ones(1), 6)) == [52]


def test_groups_stay_apart_and_keep_their_keys():
    two = groups(line(0, 3, 31), line(2, 5, 31))
    found = two.linked(np.full(62, 0.5), np.ones(2), 6)
    assert pieces(found) == [31, 31]
    assert sorted(found.keys.tolist()) == sorted(two.keys.tolist())


def test_points_with_few_neighbours_are_left_out():
    sparse = groups(line(0, 9, 10), line(0, 3, 31))
    found = sparse.linked(np.full(41, 0.5), np.ones(2), 6)
    assert pieces(found) == [31]
    # one point that stands for sixteen has enough
    assert pieces(sparse.linked(np.full(41, 1.01), np.array([16.0, 1.0]), 6)) == [10, 31]
    assert groups(line(0, 9, 10)).linked(np.full(10, 0.5), np.ones(1), 6).points.shape == (3, 0)


def test_of_a_high_group_no_more_than_the_reach_counts():
    wall = np.concatenate([line(0, 3, 16) + np.array([0, 0, z]) for z in (0.0, 2.0, 4.0)])
    low = wall * np.array([1, 1, 0.1])
    assert pieces(groups(low).linked(np.full(48, 0.3), np.ones(1), 6)) == [48]
    assert pieces(groups(wall).linked(np.full(48, 0.3), np.ones(1), 6)) == []


def test_a_heading_is_that_of_the_points_unless_they_are_near_each_other():
    for yaw in (-1.2, 0.0, 0.4, 1.5):
        found = groups(line(-3, 3, 21, yaw), line(-0.2, 0.2, 21, yaw), yaw=0.3).headings(0.45)
        assert abs(np.sin(found[0] - yaw)) < 1e-6
        assert found[1] == 0.3


ROAD = Road()


def shapes_of(kind: str, size: tuple[float, float, float], *, across: float = 8.0, yaw: float = 0.0) -> ShapeColumns:
    placed = PlacedObject(kind=kind, id=kind, x=5.0, y=across, z=0.0, level=0.0, yaw=yaw, size=size, instance=0)
    return ShapeColumns.from_rows([placed], solver_shapes([placed], ROAD, [ROAD.lane(0)]))


def test_sizes_are_the_nearest_of_the_solver_but_no_further_than_a_quarter():
    smallest, largest = (
        np.array(size) for size in (SENTENCE_KINDS["bench"].sizes.smallest, SENTENCE_KINDS["bench"].sizes.largest)
    )
    middle = tuple(((smallest + largest) / 2).tolist())
    np.testing.assert_allclose(shapes_of("bench", middle).sizes[0], middle)
    a_little_larger = tuple((1.1 * largest).tolist())
    np.testing.assert_allclose(
        shapes_of("bench", a_little_larger).sizes[0], np.maximum(largest, np.array(a_little_larger) * 0.75)
    )
    far_too_large = (10.0, 5.0, 4.0)
    np.testing.assert_allclose(shapes_of("bench", far_too_large).sizes[0], 0.75 * np.array(far_too_large))


def test_a_long_block_is_several_buildings():
    longest = SENTENCE_KINDS["building"].sizes.largest[0]
    found = shapes_of("block", (3.5 * longest, 12.0, 12.0), across=20.0)
    assert len(found.sizes) == 3  # of three quarters of its length
    assert (found.sizes[:, 0] < longest).all()


def test_what_sentences_have_no_word_for_is_left_out():
    for kind in ("grass", "hydrant", "gantry"):
        assert kind_of(kind).word is None
        assert len(shapes_of(kind, (1.0, 1.0, 1.0)).sizes) == 0


def test_cars_are_near_the_middle_of_their_lane_and_along_it():
    found = shapes_of("saloon", (4.2, 1.8, 1.5), across=0.4, yaw=0.15)
    x, y, yaw = found.places[0]
    assert abs(y) < 0.4 - 1e-6  # the ego vehicle's lane is at y = 0
    assert x == 5.0
    assert 0.0 < yaw < 0.15


@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind.word])
def test_every_kind_has_the_parts_of_its_word(name: str):
    """A kind whose word has parts of its own, and that is forgotten here, would keep its other coarse shapes."""
    kind, (length, width, height) = KINDS[name], SENTENCE_KINDS[KINDS[name].word].sizes.largest
    size, low = (min(length, 20.0), width, height), 0.6 * height
    placed = PlacedObject(
        kind=name, id=name, x=5.0, y=20.0, z=0.0, level=0.0, yaw=0.0, size=size, clearance=low, instance=1
    )
    shapes = [shape for _, shape, _ in solver_shapes([placed], ROAD, [ROAD.lane(0)])]
    parts = SENTENCE_KINDS[kind.word].sample_parts(np.random.default_rng(0), parked=kind.instances < 2)
    assert {(shape.shape, shape.label) for shape in shapes} == {(part.shape, part.label) for part in parts}
