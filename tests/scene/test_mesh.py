import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.errors import LayoutError
from lidardraft.scene.layout import Primitive
from lidardraft.scene.mesh import TriangleMesh, primitive_mesh

VOLUMES = {"box": 1.0, "cylinder": math.pi / 4, "ellipsoid": math.pi / 6}


def volume(mesh: TriangleMesh) -> float:
    """By the divergence theorem: positive if the mesh is closed and faces outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.einsum("fi,fi->f", a, np.cross(b, c)).sum() / 6)


def edge_uses(mesh: TriangleMesh) -> dict[tuple[int, int], int]:
    uses: dict[tuple[int, int], int] = {}
    for face in mesh.faces.tolist():
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            uses[a, b] = uses.get((a, b), 0) + 1
    return uses


@pytest.mark.parametrize("shape", sorted(VOLUMES))
@settings(max_examples=15, deadline=None)
@given(
    size=st.tuples(*[st.floats(0.2, 20)] * 3),
    center=st.tuples(*[st.floats(-50, 50)] * 3),
    yaw=st.floats(-4, 4),
)
def test_solids(shape: str, size: tuple[float, ...], center: tuple[float, ...], yaw: float) -> None:
    primitive = Primitive(shape=shape, center=center, size=size, label="other", id="a", yaw=yaw)  # type: ignore[arg-type]
    mesh = primitive_mesh(primitive)
    unit = VOLUMES[shape] * math.prod(size)
    moved = TriangleMesh(mesh.vertices - center, mesh.faces)
    assert unit * 0.96 <= volume(moved) <= unit * (1 + 1e-9)
    assert mesh.vertices[:, 2].min() == pytest.approx(center[2] - size[2] / 2)
    assert mesh.vertices[:, 2].max() == pytest.approx(center[2] + size[2] / 2)


@pytest.mark.parametrize("shape", sorted(VOLUMES))
def test_solids_are_closed(shape: str) -> None:
    mesh = primitive_mesh(Primitive(shape=shape, center=(0, 0, 0), size=(1, 1, 1), label="other", id="a"))
    uses = edge_uses(mesh)
    assert set(uses.values()) == {1}
    assert all((b, a) in uses for a, b in uses)


def test_yaw_turns_counter_clockwise() -> None:
    box = Primitive(shape="box", center=(5, 0, 0), size=(4, 1, 1), label="car", id="a", yaw=math.pi / 2)
    vertices = primitive_mesh(box).vertices
    assert np.ptp(vertices, axis=0) == pytest.approx([1, 4, 1])
    mark = Primitive.from_mesh(
        np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]), label="other", id="b", yaw=math.pi / 2
    )
    # About the middle of its bounds (1, 0.5): (2, 0) goes to (1.5, 1.5).
    assert primitive_mesh(mark).vertices[1] == pytest.approx([1.5, 1.5, 0])


def test_plane_is_its_rectangle() -> None:
    plane = Primitive(shape="plane", center=(1, 2, 3), size=(4, 6, 0), label="road", id="a")
    mesh = primitive_mesh(plane)
    assert mesh.vertices.min(axis=0).tolist() == [-1, -1, 3]
    assert mesh.vertices.max(axis=0).tolist() == [3, 5, 3]
    normal = np.cross(mesh.vertices[1] - mesh.vertices[0], mesh.vertices[2] - mesh.vertices[0])
    assert normal[2] > 0


def test_mesh_primitive_comes_back() -> None:
    vertices = np.array([[1.0, 2, 3], [4, 2, 3], [1, 7, 3], [1, 2, 9]])
    faces = np.array([[0, 2, 1], [0, 1, 3]])
    mesh = primitive_mesh(Primitive.from_mesh(vertices, faces, label="building", id="a"))
    np.testing.assert_allclose(mesh.vertices, vertices)
    assert mesh == TriangleMesh(mesh.vertices, faces)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0, 0, 0]], [], "at least one face"),
        ([[0, 0]], [[0, 0, 0]], "vertices [V, 3]"),
        ([[0, 0, 0], [math.nan, 0, 0], [1, 0, 0]], [[0, 1, 2]], "vertex 1 of a mesh is [nan, 0.0, 0.0]"),
        ([[0, 0, 0], [math.inf, 0, 0], [1, 0, 0]], [[0, 1, 2]], "every coordinate must be finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]], "face 1 is [0, 1, 3]; the mesh has 3 vertices"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, -1]], "face 0 is [0, 1, -1]"),
    ],
)
def test_wrong_meshes(vertices: list[list[float]], faces: list[list[int]], message: str) -> None:
    with pytest.raises(LayoutError) as caught:
        TriangleMesh(np.array(vertices), np.array(faces))
    assert message in str(caught.value)


def test_meshes_are_compared_by_value_and_read_only() -> None:
    mesh = TriangleMesh(np.eye(3), np.array([[0, 1, 2]]))
    assert mesh == TriangleMesh(np.eye(3), np.array([[0, 1, 2]]))
    assert mesh != TriangleMesh(2 * np.eye(3), np.array([[0, 1, 2]]))
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 5
