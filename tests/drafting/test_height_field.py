import numpy as np
import pytest

from lidardraft.drafting.cloud.ground import HeightField
from lidardraft.drafting.cloud.rays import Rays
from lidardraft.scene.layout import primitive_mesh
from lidardraft.semantics import BY_NAME

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
