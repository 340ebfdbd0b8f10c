"""The mesh of a roundabout."""

import numpy as np
import pytest

from lidardraft.scene.road import Road
from lidardraft.streets.ground.roundabout import RoundaboutMesh


@pytest.mark.parametrize("sidewalk", [0.0, 2.5])
def test_rings_are_circles_between_the_middle_and_the_square(sidewalk: float):
    road = Road(junction=10.0, roundabout_radius=18.0, sidewalk=sidewalk)
    mesh = RoundaboutMesh(road)
    radius = np.hypot(mesh.along - 10.0, mesh.across)
    assert np.allclose(radius[0], 0.0)
    for ring, wanted in enumerate((0.5 * road.island, road.island, 18.0), start=1):
        assert np.allclose(radius[ring], wanted)
    square = np.maximum(np.abs(mesh.along[-1] - 10.0), np.abs(mesh.across[-1]))
    assert np.allclose(square, mesh.half)
    # rings lie outside one another, so that no cell is folded
    assert (np.diff(radius, axis=0) > -1e-9).all()


def test_kinds_are_those_of_an_island_a_lane_and_a_sidewalk():
    road = Road(junction=0.0, roundabout_radius=18.0, sidewalk=2.0)
    mesh = RoundaboutMesh(road)
    diagonal = np.array([5.0, 14.0, 19.0, 25.0]) / np.sqrt(2.0)
    land = np.full(4, 2)
    assert mesh.kinds(diagonal, diagonal, land).tolist() == [3, 0, 1, 2]


def test_it_covers_its_square_and_fits_the_lines_of_the_ground():
    road = Road(junction=10.0, roundabout_radius=18.0)
    mesh = RoundaboutMesh(road)
    inside = mesh.half - 0.01
    assert mesh.covers(np.array([10.0 + inside, 10.0]), np.array([0.0, -inside])).all()
    assert not mesh.covers(np.array([10.0 + mesh.half + 0.01]), np.array([0.0])).any()
    assert min(mesh.lines_along()) == pytest.approx(10.0 - mesh.half)
    assert {road.edge, road.verge} <= set(mesh.offsets)
