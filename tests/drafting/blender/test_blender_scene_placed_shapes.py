import math

import numpy as np
import pytest
from scene_reading import scene, with_car

from lidardraft.drafting.blender.bpy import mesh_shapes
from lidardraft.drafting.blender.bpy.rotations import rotation_matrix
from lidardraft.scene.layout import primitive_mesh


def test_numbers_are_kept_to_the_last_digit() -> None:
    car = with_car(
        "car.location = (0.1, 0.2, 0.3)\ncar.scale = (4.3, 1.7, 1.1)\ncar.rotation_euler = (0, 0, 1 / 3)\n"
        "car['class'] = 'car'"
    )
    assert (car.center, car.size, car.yaw) == ((0.1, 0.2, 0.3), (4.3, 1.7, 1.1), 1 / 3)


@pytest.mark.parametrize(
    ("script", "shape"),
    [
        ("car.rotation_euler = (0.3, 0, 0)", "mesh"),
        ("car.rotation_euler = (math.pi / 2, 0, 0.7)", "box"),
        ("car.scale = (-2, 1, 1)", "box"),
        ("car.scale = (2, 1, 0)", "plane"),
        ("car.scale = (2, 0, 1)", "mesh"),
    ],
)
def test_a_cube_is_a_box_where_it_stands_upright(script: str, shape: str) -> None:
    assert with_car(script).shape == shape


def test_a_cube_scaled_to_a_line_is_left_out() -> None:
    layout = scene(
        "bpy.ops.mesh.primitive_cube_add(scale=(1, 0, 0))\nbpy.context.object.name = 'Wall'\n"
        "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Bus'"
    )
    assert [p.id for p in layout] == ["Bus"]
    assert "Wall has no surface" in layout.provenance["notes"][0]


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.4, 0.2, 0.9), (math.pi / 2, 0.0, 0.3), (0.0, math.pi, 0.0)])
@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (2.0, 0.5, 3.0), (1.0, -2.0, 1.0)])
@pytest.mark.parametrize("kind", ["cube", "cylinder", "uv_sphere", "plane", "cone", "torus"])
def test_every_shape_keeps_its_place(kind: str, angles: tuple[float, ...], scale: tuple[float, ...]) -> None:
    """Its bounds are those of the operator's mesh under the object's transform, to the rounding of a sphere."""
    (primitive,) = scene(
        f"bpy.ops.mesh.primitive_{kind}_add(location=(3, 4, 5), rotation={angles})\n"
        f"bpy.context.object.name = 'House'\nbpy.context.object.scale = {scale}"
    )
    shape = {
        "cube": mesh_shapes.cube(2.0),
        "cylinder": mesh_shapes.cone(1.0, 1.0, 2.0, 32),
        "uv_sphere": mesh_shapes.sphere(1.0, 32, 16),
        "plane": mesh_shapes.plane(2.0),
        "cone": mesh_shapes.cone(1.0, 0.0, 2.0, 32),
        "torus": mesh_shapes.torus(1.0, 0.25, 48, 12),
    }[kind]
    expected = shape.triangles()[0] * scale @ rotation_matrix(angles).T + (3, 4, 5)
    found = primitive_mesh(primitive).vertices
    off = 0.03 * max(map(abs, scale)) if kind == "uv_sphere" else 1e-6
    np.testing.assert_allclose(found.min(axis=0), expected.min(axis=0), atol=off)
    np.testing.assert_allclose(found.max(axis=0), expected.max(axis=0), atol=off)
