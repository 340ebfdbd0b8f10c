"""Shapes as columns: the same scan and the same layout as the primitives they stand for."""

from dataclasses import replace

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.errors import LayoutError
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.shape_table import ShapeTable

SENSOR = Sensor.preset("vlp16")
TENT = TriangleMesh([[-0.5, -0.5, -0.5], [0.5, -0.5, -0.5], [0.0, 0.5, -0.5], [0.0, 0.0, 0.5]], [[0, 1, 3], [1, 2, 3]])
PRIMITIVES = (
    Primitive(shape="plane", center=(0, 0, 0), size=(80, 80, 0), label="road", id="road"),
    Primitive(shape="box", center=(8, 1, 1), size=(4, 2, 2), yaw=0.4, label="car", id="car_1", instance=1),
    Primitive(shape="mesh", center=(-6, 3, 1), size=(2, 2, 2), label="other", id="tent", mesh=TENT),
    Primitive(shape="ellipsoid", center=(3, -6, 1), size=(2, 3, 2), label="vegetation", id="bush"),
    Primitive(shape="mesh", center=(5, 9, 1), size=(1, 3, 2), yaw=1.0, label="wall", id="slab", mesh=TENT),
)
TABLE = ShapeTable.from_primitives(PRIMITIVES)


def test_a_table_is_the_layout_of_its_primitives():
    assert TABLE.layout({"source": "here"}, (-1.0, 1.0)) == Layout(PRIMITIVES, {"source": "here"}, (-1.0, 1.0))
    assert ShapeTable.join(TABLE.select(np.arange(5) < 2), TABLE.select(np.arange(5) >= 2)).layout({}) == TABLE.layout(
        {}
    )
    assert [p.id for p in TABLE.select(np.array([0, 0, 0, 1, 1], bool)).layout({})] == ["bush", "slab"]


def test_a_table_is_cast_as_its_layout():
    pose = SENSOR.pose(1.0, 2.0, 0.3)
    scan, cast = TABLE.scan(SENSOR, pose), raycast(Layout(PRIMITIVES), SENSOR, pose)
    for name in ("depth", "label", "instance"):
        assert (getattr(scan, name) == getattr(cast, name)).all(), name


def test_who_moves_sees_what_he_saw_before():
    there, here = (
        TABLE.scan(SENSOR, SENSOR.pose(2.0, -3.0, 0.7)),
        TABLE.seen_from(2.0, -3.0, 0.7).scan(SENSOR, SENSOR.pose()),
    )
    same = there.label == here.label
    assert same.mean() > 0.999
    assert there.depth[same] == pytest.approx(here.depth[same], abs=1e-4)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"yaws": np.zeros(4)}, r"yaws has shape \(4,\); 5 ids need \(5,\)"),
        ({"labels": np.array([1, 0, 2, 3, 4])}, "car_1: label is 0; it must be 1 to 20"),
        ({"ids": ("road", "car_1", "tent", "car_1", "slab")}, "car_1: two shapes have this id"),
        ({"meshes": ()}, "2 shapes are meshes; there are 0 meshes for them"),
    ],
)
def test_columns_that_do_not_fit(columns: dict, message: str):
    with pytest.raises(LayoutError, match=message):
        replace(TABLE, **columns)


@pytest.mark.parametrize("size", [(1.0, -1.0, 1.0), (1.0, float("nan"), 1.0), (0.0, 1.0, 1.0)])
def test_numbers_that_are_no_shape_are_not_cast(size: tuple):
    sizes = TABLE.sizes.copy()
    sizes[1] = size
    with pytest.raises(LayoutError):
        replace(TABLE, sizes=sizes).scan(SENSOR, SENSOR.pose())
    with pytest.raises(LayoutError, match="car_1: size"):
        replace(TABLE, sizes=sizes).layout({})
