import math

import numpy as np
import pytest

from lidardraft.drafting.picture.surroundings import mirrored_surroundings
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import Raycaster
from lidardraft.semantics import BY_NAME

COVERAGE = (-math.radians(40), math.radians(40))


def box(id, center, size, label="car", yaw=0.0, **fields):
    return Primitive(shape="box", center=center, size=size, label=label, id=id, yaw=yaw, **fields)


CARS = (
    box("car_1", (18, 3, 0.75), (4, 2, 1.5), yaw=0.3, instance=1),
    box("car_2", (30, -3, 0.75), (4, 2, 1.5), instance=2),
)


def filled(*objects, slope=0.0):
    x, y = np.meshgrid(np.arange(6, 60, 0.5), np.arange(-20, 20, 0.5))
    seen = np.abs(np.arctan2(y, x)) < COVERAGE[1]
    points = np.column_stack([x[seen], y[seen], slope * x[seen] - 1.7])
    labels = np.where(np.abs(points[:, 1]) < 4, BY_NAME["road"].id, BY_NAME["terrain"].id)
    layout = Layout(objects, {"source": "image"}, COVERAGE)
    return mirrored_surroundings(layout, points, labels, 1.7)


def test_what_the_picture_shows_stays_as_it_is():
    layout = filled(*CARS)
    assert [primitive for primitive in layout if primitive.id in ("car_1", "car_2")] == list(CARS)
    assert layout.coverage == COVERAGE


def test_objects_are_mirrored_about_where_the_picture_begins():
    """That is at its edge or, near to the axis, where the ground comes out from below it."""
    house = box("house", (24, 12, 2), (6, 6, 4), "building", yaw=0.3)
    layout = filled(*CARS, house)
    mirrored = layout["mirrored_house"]
    np.testing.assert_allclose(mirrored.center, (2 * 12 / math.tan(COVERAGE[1]) - 24, 12, 2))
    assert mirrored.yaw == -0.3
    assert mirrored.size == house.size
    np.testing.assert_allclose(layout["mirrored_car_2"].center, (2 * 6 - 30, -3, 0.75), atol=1.1)
    assert [b.instance for b in layout.boxes()] == [1, 2, 3, 4]
    assert layout["mirrored_car_2"].center[1] == -3  # no side is changed for the other


def test_the_road_goes_on_under_and_behind_the_ego_vehicle():
    layout = filled(slope=0.02)
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(-25.25, 50, 2), [-12.25, -8.25, -1.25, 2.25, 9.25]))
    origins = np.column_stack([x, y, np.full(len(x), 50.0)])
    hits = Raycaster(layout).cast(origins, np.tile([0.0, 0, -1], (len(x), 1)))
    names = np.where(np.abs(y) < 4, BY_NAME["road"].id, BY_NAME["terrain"].id)
    np.testing.assert_array_equal(hits.label, names)
    edge = np.maximum(np.abs(y) / math.tan(COVERAGE[1]), 6)
    height = 50 - hits.distance
    np.testing.assert_allclose(height, 0.02 * (edge + np.abs(x - edge)), atol=0.15)


def test_what_touches_stays_together():
    """Parts at other distances from the axis are not torn apart: a crown stays round."""
    crown = [
        Primitive(shape="ellipsoid", center=(25 + dx, 9 + dy, 3), size=(1.5,) * 3, label="vegetation", id=f"v{dx}{dy}")
        for dx in (0, 1)
        for dy in (0, 1, 2)
    ]
    layout = filled(*crown)
    mirrored = np.array([layout[f"mirrored_{part.id}"].center for part in crown])
    shifts = mirrored[:, 0] + [part.center[0] for part in crown]
    np.testing.assert_allclose(shifts, 2 * 10 / math.tan(COVERAGE[1]))
    np.testing.assert_allclose(mirrored[:, 1], [part.center[1] for part in crown])


@pytest.mark.parametrize(
    "primitive",
    [
        box("house", (9, 0, 2), (40, 3, 4), "building"),  # over the ego vehicle, as its mirror image is
        box("car", (4.2, 3.5, 0.75), (4, 2, 1.5), instance=1),  # at the edge: half of it in the picture
    ],
)
def test_no_mirror_image_stands_in_the_picture_or_on_the_ego_vehicle(primitive):
    layout = filled(primitive)
    assert [p.id for p in layout if p.id.startswith("mirrored")] == []


def test_the_mirror_image_of_a_mesh_is_the_same_from_the_other_side():
    vertices = np.array([(20.0, 8, 0), (24, 8, 0), (24, 10, 0), (20, 8, 3)])
    faces = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    mesh = Primitive.from_mesh(vertices, faces, label="building", id="roof", yaw=0.0)
    mirrored = filled(mesh)["mirrored_roof"]
    assert mirrored.mesh.is_closed()
    half = np.array(mirrored.size) / 2
    corner = mirrored.mesh.vertices[3] * mirrored.size + mirrored.center
    edge = 9 / math.tan(COVERAGE[1])
    np.testing.assert_allclose(corner, (2 * edge - 20, 8, 3))
    assert half[0] == 2
