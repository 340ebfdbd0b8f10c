import numpy as np
import pytest

from lidardraft.drafting.cloud.rays import Rays
from lidardraft.drafting.cloud.refinement import Piece, refined
from lidardraft.drafting.cloud.rules import DETAILS, Detail
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import Raycaster
from lidardraft.semantics import BY_NAME

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
