import math

import pytest
from scene_reading import refuses, with_car

from lidardraft.scene.layout import primitive_mesh

EDIT = "bpy.ops.object.mode_set(mode='EDIT')\n"


def test_a_move_in_the_edit_mode_leaves_the_origin() -> None:
    moved = with_car(
        EDIT + "bpy.ops.mesh.select_all(action='SELECT')\nbpy.ops.transform.translate(value=(0, 0, 0.5))\n"
        "bpy.ops.object.mode_set(mode='OBJECT')\ncar.location = (0, 0, 0)\ncar.scale = (4, 2, 1)"
    )
    assert (moved.center, moved.size) == ((0, 0, 0.5), (4, 2, 1))


def test_a_move_goes_along_the_axes_of_the_world() -> None:
    turned = with_car(
        "car.rotation_euler.z = math.pi / 2\ncar.scale = (4, 2, 1)\n"
        + EDIT
        + "bpy.ops.transform.translate(value=(1, 0, 0))"
    )
    assert primitive_mesh(turned).vertices.max(axis=0) == pytest.approx((7, 2, 1))


def test_vertices_are_stretched_and_turned_about_their_middle() -> None:
    stretched = with_car(EDIT + "bpy.ops.transform.resize(value=(4, 2, 2))")
    assert (stretched.center, stretched.size) == ((5, 0, 0.5), (4, 2, 2))
    turned = with_car("car.scale = (4, 2, 1)\n" + EDIT + "bpy.ops.transform.rotate(value=math.pi / 2, orient_axis='Z')")
    assert primitive_mesh(turned).vertices.max(axis=0) == pytest.approx((6, 2, 1))
    assert math.isclose(abs(math.sin(turned.yaw)), 1) or turned.size == pytest.approx((2, 4, 1))


def test_what_is_not_selected_stays() -> None:
    still = with_car(EDIT + "bpy.ops.mesh.select_all(action='DESELECT')\nbpy.ops.transform.translate(value=(9, 0, 0))")
    assert still.center == (5, 0, 0.5)
    assert with_car(EDIT + "bpy.ops.mesh.normals_make_consistent(inside=False)").center == (5, 0, 0.5)


def test_what_is_refused() -> None:
    refuses(EDIT + "bpy.ops.mesh.select_all(action='SOME')", "line 7: the action is 'SOME'")
    refuses(EDIT + "bpy.ops.mesh.extrude_region_move()", r"line 7: bpy.ops.mesh.extrude_region_move is not supported")
    refuses("car.scale = (0, 1, 1)\n" + EDIT + "bpy.ops.transform.translate(value=(1, 0, 0))", "scaled to nothing")
    refuses(
        "import bmesh\n" + EDIT + "bmesh.from_edit_mesh(car.data)\nbpy.ops.transform.translate(value=(1, 0, 0))",
        "line 9: a transform in the edit mode of what is no mesh, or is open in bmesh",
    )
