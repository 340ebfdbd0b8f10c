"""What the benchmarks cast is what they say it is."""

import numpy as np
import pytest

from lidardraft.scene.layout import primitive_mesh
from peer_lidardraft import layout_of, sensor_of
from scenes import MAX_RANGE, SCENES, Body, column_poses, hdl64, pose, poses, small


@pytest.mark.parametrize(
    ("name", "kinds", "triangles"),
    [
        ("small", {"plane": 1, "cuboid": 30}, 2 + 30 * 12),
        ("street", {"plane": 1, "cuboid": 200, "ellipsoid": 100}, 2 + 200 * 12 + 100 * 320),
        ("heavy", {"mesh": 1, "ellipsoid": 220}, 720_000 + 220 * 1280),
    ],
)
def test_numbers_of_shapes_and_triangles(name: str, kinds: dict[str, int], triangles: int) -> None:
    scene = SCENES[name]()
    found = [body.kind for body in scene.primitives]
    assert {kind: found.count(kind) for kind in found} == kinds
    assert scene.faces.shape == (triangles, 3)
    assert scene.verts[scene.faces].shape == (triangles, 3, 3)  # no index out of the mesh
    assert [body.instance for body in scene.primitives] == list(range(len(found)))


def in_own_frame(body: Body) -> np.ndarray:
    """The vertices of a body where it is the unit shape."""
    cos, sin = np.cos(body.yaw), np.sin(body.yaw)
    turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    return (body.verts - np.array(body.center)) @ turn.T / np.array(body.half)


@pytest.mark.parametrize("name", ["small", "street"])
def test_the_triangles_lie_on_the_shapes_and_close_them(name: str) -> None:
    for body in SCENES[name]().primitives:
        if body.kind == "plane":
            continue
        unit = in_own_frame(body)
        away = np.abs(unit).max(axis=1) if body.kind == "cuboid" else np.linalg.norm(unit, axis=1)
        np.testing.assert_allclose(away, 1.0, atol=1e-4)
        edges = np.sort(body.faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}


def test_a_layout_of_triangles_has_the_vertices_of_the_scene() -> None:
    scene = small()
    layout = layout_of(scene, triangles=True)
    assert {primitive.shape for primitive in layout} == {"mesh"}
    for body, primitive in zip(scene.primitives, layout, strict=True):
        mesh = primitive_mesh(primitive)
        np.testing.assert_array_equal(mesh.vertices.astype(np.float32), body.verts)
        np.testing.assert_array_equal(mesh.faces, body.faces)


def test_an_analytic_layout_has_the_shapes_of_the_scene() -> None:
    shapes = [primitive.shape for primitive in layout_of(SCENES["street"](), triangles=False)]
    assert {shape: shapes.count(shape) for shape in shapes} == {"plane": 1, "box": 200, "ellipsoid": 100}


def test_the_sensor_has_the_rays_of_the_pattern() -> None:
    pattern = hdl64()
    sensor = sensor_of(pattern)
    assert sensor.shape == pattern.shape == (64, 1024)
    np.testing.assert_allclose(sensor.pattern.directions().reshape(-1, 3), pattern.directions, atol=1e-6)


def test_a_pattern_that_is_no_even_grid_is_refused() -> None:
    pattern = hdl64()
    pattern.azimuth[7] += 1e-3
    with pytest.raises(AssertionError):
        sensor_of(pattern)


def test_poses_are_rigid_and_differ() -> None:
    several = poses(0, 5)
    np.testing.assert_array_equal(several[3], pose(3))
    np.testing.assert_allclose(several[:, :3, :3] @ several[:, :3, :3].transpose(0, 2, 1), [np.eye(3)] * 5, atol=1e-12)
    assert np.abs(np.diff(several[:, :3, 3], axis=0)).max() > 0.1
    columns = column_poses(3, 64)
    np.testing.assert_array_equal(columns[0], pose(3))
    assert 0 < np.abs(columns[-1] - columns[0]).max() < np.abs(pose(4) - pose(3)).max()


def test_images_mark_misses() -> None:
    scene = small()
    faces = np.array([0, 5, len(scene.faces), 2**32 - 1, 5, 5], dtype=np.uint32)
    distance = np.array([3.0, 4.0, 5.0, np.inf, MAX_RANGE, MAX_RANGE + 1], dtype=np.float32)
    depth, semantic, instance = scene.images(distance, faces, (2, 3))
    np.testing.assert_array_equal(depth, [[3, 4, 0], [0, MAX_RANGE, 0]])
    box = scene.primitives[1]
    np.testing.assert_array_equal(instance, [[0, box.instance, -1], [-1, box.instance, -1]])
    np.testing.assert_array_equal(semantic, [[1, box.semantic, 0], [0, box.semantic, 0]])
    signed = scene.images(np.ones(1, np.float32), np.array([-1], np.int32), (1, 1))
    assert [image.item() for image in signed] == [0, 0, -1]
