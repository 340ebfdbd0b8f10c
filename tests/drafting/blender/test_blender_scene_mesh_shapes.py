import math

import numpy as np
import pytest

from lidardraft.drafting.blender.bpy import mesh_shapes as shapes
from lidardraft.drafting.blender.bpy.mesh_shapes import MeshShape
from lidardraft.scene.mesh import TriangleMesh

CLOSED = {
    "cube": (shapes.cube(2.0), 8.0),
    "cylinder": (shapes.cone(1.0, 1.0, 2.0, 64), 2 * math.pi),
    "cone": (shapes.cone(1.0, 0.0, 3.0, 64), math.pi),
    "sphere": (shapes.sphere(1.0, 64, 32), 4 / 3 * math.pi),
    "icosphere": (shapes.icosphere(1.0, 4), 4 / 3 * math.pi),
    "torus": (shapes.torus(2.0, 0.5, 96, 48), 2 * math.pi**2 * 2 * 0.25),
}


def volume(shape: MeshShape) -> float:
    vertices, faces = shape.triangles()
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6)


@pytest.mark.parametrize("name", CLOSED)
def test_closed_shapes_have_their_volume_and_look_outwards(name: str) -> None:
    shape, expected = CLOSED[name]
    assert volume(shape) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("name", CLOSED)
def test_the_number_of_vertices_is_known_before_they_are_made(name: str) -> None:
    shape, _ = CLOSED[name]
    vertices, faces = shape.triangles()
    assert len(vertices) == shape.vertices
    assert TriangleMesh(vertices, faces).is_closed()


@pytest.mark.parametrize(
    ("shape", "vertices", "polygons"),
    [
        (shapes.cube(1.0), 8, 6),
        (shapes.grid(1.0, 3, 2), 12, 6),
        (shapes.cone(1.0, 1.0, 2.0, 32), 64, 34),
        (shapes.cone(1.0, 0.0, 2.0, 32), 33, 33),
        (shapes.cone(0.0, 1.0, 2.0, 32, capped=False), 33, 32),
        (shapes.sphere(1.0, 32, 16), 482, 512),
        (shapes.icosphere(1.0, 2), 42, 80),
        (shapes.torus(1.0, 0.25, 48, 12), 576, 576),
    ],
)
def test_vertices_and_polygons_are_as_many_as_in_blender(shape: MeshShape, vertices: int, polygons: int) -> None:
    places, faces = shape.make()
    assert (len(places), sum(map(len, faces)), shape.vertices) == (vertices, polygons, vertices)


def test_a_cone_may_stand_on_its_tip() -> None:
    assert volume(shapes.cone(0.0, 1.0, 3.0, 64)) == pytest.approx(math.pi, rel=0.02)
    vertices, faces = shapes.cone(0.0, 1.0, 3.0, 64).triangles()
    assert TriangleMesh(vertices, faces).is_closed()


def test_round_shapes_of_few_corners_are_meshes() -> None:
    assert shapes.cone(1.0, 1.0, 2.0, 32).shape == "cylinder"
    assert shapes.cone(1.0, 1.0, 2.0, 6).shape == "mesh"
    assert shapes.cone(1.0, 1.0, 2.0, 32, capped=False).shape == "mesh"
    assert shapes.sphere(1.0, 32, 16).shape == "ellipsoid"
    assert shapes.sphere(1.0, 4, 3).shape == "mesh"
    assert shapes.icosphere(1.0, 1).shape == "mesh"


def test_flat_shapes() -> None:
    vertices, faces = shapes.plane(4.0).triangles()
    assert np.ptp(vertices, axis=0).tolist() == [4, 4, 0]
    assert len(faces) == 2
    vertices, faces = shapes.disc(2.0, 6).triangles()
    np.testing.assert_allclose(vertices[0], (0, 2, 0), atol=1e-12)
    assert len(faces) == 4


def test_fans() -> None:
    polygons = shapes.polygons_of([(0, 1, 2, 3), (4, 5), (6, 7, 8), (3, 2, 1)])
    assert [each.tolist() for each in polygons] == [[[0, 1, 2, 3]], [[6, 7, 8], [3, 2, 1]]]
    assert shapes.fans(polygons).tolist() == [[0, 1, 2], [0, 2, 3], [6, 7, 8], [3, 2, 1]]
    assert shapes.fans([]).shape == (0, 3)
