"""Triangles of boxes, tubes, lofts and frames: closed, their fronts outside, of the right volume."""

import math

import numpy as np
import pytest
from built_objects import is_closed

from lidardraft.objects.mesh import (
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
