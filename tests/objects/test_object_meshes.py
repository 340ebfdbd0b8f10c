"""Triangles of boxes, tubes, lofts and frames, and how a builder places them."""

import math
from collections import Counter

import numpy as np
import pytest
from built_objects import is_closed, placed, vertices

from lidardraft.objects.mesh import (
    MeshTemplate,
    Triangles,
    box,
    frustum,
    frustum_corners,
    join,
    lathe,
    loft,
    quads,
    tube,
    window_frame,
)
from lidardraft.objects.object_builder import ObjectBuilder, sample_name
from lidardraft.scene.mesh import TriangleMesh


def volume(triangles: Triangles) -> float:
    """By the divergence theorem: positive where the fronts are outside."""
    vertices, faces = triangles
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def closed(triangles: Triangles) -> bool:
    vertices, faces = triangles
    return is_closed(TriangleMesh(vertices / (4 * np.abs(vertices).max()), faces))


POLYGON = 0.5 * 12 * math.sin(math.tau / 12)  # the area of a regular one of 12 corners and radius 1
SQUARE = np.array([(0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1)], dtype=float)


@pytest.mark.parametrize(
    ("triangles", "expected"),
    [
        (box((1.0, 2.0, 3.0), (2.0, 3.0, 4.0)), 24.0),
        (frustum(frustum_corners((-1.0, 1.0, 2.0, 0.0), (-1.0, 1.0, 2.0, 3.0))), 12.0),
        (tube((0.0, 0.0, 0.0), (0.0, 3.0, 4.0), (2.0, 2.0), 12), 5.0 * POLYGON),
        (tube((1.0, 0.0, 0.0), (4.0, 0.0, 4.0), (2.0, 2.0), 12), 5.0 * POLYGON),
        (loft(np.stack([SQUARE, SQUARE + np.array([2.0, 0.0, 0.0])])), 8.0),
        (lathe(np.array([(1.0, 0.0), (1.0, 2.0)]), 12), 2.0 * POLYGON),
        (lathe(np.array([(1.0, 0.0), (1.0, 2.0)]), 12, across=0.5), POLYGON),
    ],
)
def test_solids_are_closed_and_of_the_right_volume(triangles: Triangles, expected: float):
    assert closed(triangles)
    assert volume(triangles) == pytest.approx(expected)


def test_several_solids_are_one():
    one, two = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), box((3.0, 0.0, 0.0), (1.0, 1.0, 2.0))
    both = join(one, two)
    assert len(both[1]) == 24
    assert closed(both)
    assert volume(both) == pytest.approx(3.0)


def test_quadrilaterals_are_two_triangles_each():
    corners = np.stack([SQUARE, SQUARE + np.array([1.0, 0.0, 0.0])])
    vertices, faces = quads(corners)
    assert (vertices.shape, faces.shape) == ((8, 3), (4, 3))
    assert set(map(tuple, vertices[faces[2:]].reshape(-1, 3).tolist())) == set(map(tuple, corners[1].tolist()))


@pytest.mark.parametrize("side", range(4))
def test_a_frame_leaves_out_its_windows(side: int):
    corners = frustum_corners((-1.0, 1.0, 2.0, 0.0), (-1.0, 1.0, 2.0, 2.0))
    frame = window_frame(corners, side, ((0.1, 0.4), (0.6, 0.9)), (0.25, 0.75))
    vertices, faces = quads(frame)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(4.0 * (1 - 0.6 * 0.5))


# a box from (0.1, 0, 0) to (0.5, 0.2, 0.4), in shares
TEMPLATE = MeshTemplate.from_triangles(*box((0.3, 0.1, 0.2), (0.4, 0.2, 0.4)))


def test_a_template_is_stretched_and_turned_round():
    builder = ObjectBuilder(placed("bin"))
    builder.add_mesh(TEMPLATE, (10.0, 5.0, 2.0), "other", at=(1.0, 0.0, 0.5))
    builder.add_mesh(TEMPLATE, (10.0, 5.0, 2.0), "other", at=(1.0, 0.0, 0.5), backward=True)
    ahead, back = (vertices(p) for p in builder.primitives)
    assert (ahead.min(axis=0), ahead.max(axis=0)) == (
        pytest.approx(np.array([2.0, 0.0, 0.5])),
        pytest.approx(np.array([6.0, 1.0, 1.3])),
    )
    assert (back.min(axis=0), back.max(axis=0)) == (
        pytest.approx(np.array([-4.0, -1.0, 0.5])),
        pytest.approx(np.array([0.0, 0.0, 1.3])),
    )


def test_names_come_as_often_as_their_shares_say():
    rng = np.random.default_rng(0)
    shares = {"brick": 0.7, "wood": 0.3, "stone": 0.0}
    counts = Counter(sample_name(shares, rng) for _ in range(2000))
    assert counts["brick"] / 2000 == pytest.approx(0.7, abs=0.04)
    assert set(counts) == {"brick", "wood"}


def test_shares_that_do_not_add_up_are_an_error():
    with pytest.raises(ValueError, match="sum to 1"):
        sample_name({"brick": 0.7, "wood": 0.2}, np.random.default_rng(0))
