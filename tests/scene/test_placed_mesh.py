import math

import numpy as np
import pytest

from lidardraft.errors import LayoutError
from lidardraft.scene.layout import Primitive
from lidardraft.scene.mesh import primitive_mesh, unit_mesh
from lidardraft.scene.placed_mesh import placed_mesh, shape_of, size_and_yaw

FIELDS = {"label": "car", "id": "car_1", "instance": 1}


def turned(angles: tuple[float, float, float], size: tuple[float, float, float]) -> np.ndarray:
    x, y, z = angles
    about_x = np.array([[1, 0, 0], [0, math.cos(x), -math.sin(x)], [0, math.sin(x), math.cos(x)]])
    about_y = np.array([[math.cos(y), 0, math.sin(y)], [0, 1, 0], [-math.sin(y), 0, math.cos(y)]])
    about_z = np.array([[math.cos(z), -math.sin(z), 0], [math.sin(z), math.cos(z), 0], [0, 0, 1]])
    matrix = np.eye(4)
    matrix[:3, :3] = about_z @ about_y @ about_x * size
    matrix[:3, 3] = (5, -3, 2)
    return matrix


@pytest.mark.parametrize("shape", ["box", "ellipsoid", "cylinder", "plane"])
@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5, math.pi / 2])
@pytest.mark.parametrize("offset", [0.0, 40.0])
def test_a_mesh_of_a_shape_is_that_shape(shape: str, yaw: float, offset: float) -> None:
    """Also after float32, of vertices that are far from the mesh's own origin."""
    mesh = unit_mesh(shape)
    vertices = (mesh.vertices * (4, 2, 1.5) + offset).astype(np.float32).astype(np.float64)
    found = placed_mesh(turned((0, 0, yaw), (1, 1, 1)), vertices, mesh.faces, **FIELDS)
    assert found is not None
    assert found.shape == shape
    np.testing.assert_allclose(found.size, (4, 2, 0 if shape == "plane" else 1.5), atol=1e-4)
    assert math.remainder(found.yaw - yaw, math.tau) == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("shape", ["box", "ellipsoid", "cylinder", "plane"])
def test_any_place_keeps_the_bounds(shape: str) -> None:
    mesh = unit_mesh(shape)
    random = np.random.default_rng(1)
    for k in range(20):
        angles = random.uniform(-3, 3, 3) * ((1, 1, 1) if k % 2 else (0, 0, 1))
        matrix = turned(tuple(angles), tuple(random.uniform(0.5, 4, 3)))
        found = placed_mesh(matrix, mesh.vertices, mesh.faces, **FIELDS)
        assert found is not None
        expected = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        off = 0.15 if found.shape == "ellipsoid" else 1e-6  # a turned ellipsoid has its vertices elsewhere
        np.testing.assert_allclose(primitive_mesh(found).vertices.min(axis=0), expected.min(axis=0), atol=off)
        np.testing.assert_allclose(primitive_mesh(found).vertices.max(axis=0), expected.max(axis=0), atol=off)


def test_what_only_resembles_a_shape_is_a_mesh() -> None:
    box = unit_mesh("box")
    assert shape_of(box.vertices, box.faces) == "box"
    assert shape_of(box.vertices, box.faces[2:]) == "mesh"  # open on one side
    dented = box.vertices.copy()
    dented[0] *= 0.9
    assert shape_of(dented, box.faces) == "mesh"
    plane = unit_mesh("plane")
    assert shape_of(plane.vertices, plane.faces[:1]) == "mesh"
    ball = unit_mesh("ellipsoid")
    assert shape_of(ball.vertices, ball.faces[: len(ball.faces) // 2]) == "mesh"


def test_a_mesh_keeps_its_yaw_and_a_tight_box() -> None:
    roof = np.array([(0, 0, 0), (4, 0, 0), (4, 2, 0), (0, 2, 0), (2, 1, 3)], dtype=float)
    faces = np.array([(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (0, 2, 1), (0, 3, 2)])
    found = placed_mesh(turned((0, 0, 0.5), (1, 1, 1)), roof, faces, **FIELDS)
    assert isinstance(found, Primitive)
    assert (found.shape, found.size, found.yaw) == ("mesh", pytest.approx((4, 2, 3)), pytest.approx(0.5))
    leaning = placed_mesh(turned((0.5, 0, 0.5), (1, 1, 1)), roof, faces, **FIELDS)
    assert leaning is not None
    assert leaning.yaw == 0


def test_what_has_no_surface_is_none() -> None:
    box = unit_mesh("box")
    assert placed_mesh(turned((0, 0, 0), (1, 0, 0)), box.vertices, box.faces, **FIELDS) is None
    slab = placed_mesh(turned((0, 0, 0), (2, 1, 0)), box.vertices, box.faces, **FIELDS)
    assert slab is not None
    assert slab.shape == "plane"


def test_sheared_and_leaning_maps() -> None:
    assert size_and_yaw(np.diag([1.0, 2.0, 3.0]), "box") == ([1, 2, 3], 0)
    assert size_and_yaw(np.array([[1.0, 0.5, 0], [0, 1, 0], [0, 0, 1]]), "box") is None
    assert size_and_yaw(np.array([[1.0, 0, 0.1], [0, 1, 0], [0, 0, 1]]), "cylinder") is None
    size_yaw = size_and_yaw(np.array([[2.0, 0.5, 0], [0, 1, 0], [0, 0, 1]]), "cylinder")
    assert size_yaw is not None
    assert size_yaw[0][0] * size_yaw[0][1] == pytest.approx(2)  # a sheared circle is an ellipse of the same area


@pytest.mark.parametrize("number", [np.inf, np.nan, 1e10])
def test_transforms_that_are_no_transforms(number: float) -> None:
    box = unit_mesh("box")
    matrix = np.eye(4)
    matrix[0, 0] = number
    with pytest.raises(LayoutError, match=r"car_1: a transform or an extent is larger than 1e.09, or no number"):
        placed_mesh(matrix, box.vertices, box.faces, **FIELDS)
