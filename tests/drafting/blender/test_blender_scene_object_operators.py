import math

import pytest
from scene_reading import CUBE, refuses, scene, with_car


def test_what_is_selected_is_deleted() -> None:
    more = "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Bus'\n"
    assert [p.id for p in scene(CUBE + more + "bpy.ops.object.delete()")] == ["Car"]
    cleared = CUBE + "bpy.ops.object.select_all(action='SELECT')\nbpy.ops.object.delete()\n" + more
    assert [p.id for p in scene(cleared)] == ["Bus"]
    inverted = CUBE + more + "bpy.ops.object.select_all(action='INVERT')\nbpy.ops.object.delete()"
    assert [p.id for p in scene(inverted)] == ["Bus"]
    by_type = CUBE + "bpy.ops.object.empty_add()\nbpy.ops.object.select_by_type(type='EMPTY')\nbpy.ops.object.delete()"
    assert [p.id for p in scene(by_type)] == ["Car"]
    assert [p.id for p in scene(CUBE + "bpy.ops.wm.read_factory_settings(use_empty=True)\n" + more)] == ["Bus"]


def test_a_transform_that_is_applied_stays_and_the_next_comes_on_top() -> None:
    car = with_car("car.scale = (4, 2, 1)\nbpy.ops.object.transform_apply(location=False)\ncar.scale.x = 2")
    assert car.shape == "box"
    assert car.size == (8, 2, 1)
    assert car.center == (5, 0, 0.5)
    moved = with_car("car.rotation_euler.z = 0.3\ncar.scale = (4, 2, 1)\nbpy.ops.object.transform_apply()")
    assert moved.center == pytest.approx((5, 0, 0.5))
    assert (moved.size, moved.yaw) == (pytest.approx((4, 2, 1)), pytest.approx(0.3))


def test_moving_stretching_and_turning() -> None:
    car = with_car(
        "bpy.ops.transform.translate(value=(1, 2, 0))\n"
        "bpy.ops.transform.resize(value=(4, 2, 1))\n"
        "bpy.ops.transform.rotate(value=0.3, orient_axis='Z')"
    )
    assert car.center == (6, 2, 0.5)
    assert car.size == pytest.approx((4, 2, 1))
    assert car.yaw == pytest.approx(-0.3)  # as Blender without a window does


def test_copies_parents_and_joined_meshes() -> None:
    layout = scene(CUBE + "bpy.ops.object.duplicate()\nbpy.context.object.location.x = 20\ncar.scale.x = 4")
    assert [(p.id, p.size[0], p.center[0]) for p in layout] == [("Car", 4, 5), ("Car_001", 1, 20)]
    parented = CUBE + (
        "car.rotation_euler.z = math.pi / 2\nbpy.ops.mesh.primitive_cube_add(size=0.4, location=(6, 0, 2))\n"
        "bpy.context.object.name = 'Car_roof'\n"
        "bpy.context.view_layer.objects.active = car\nbpy.ops.object.parent_set()\ncar.location.x = 15\n"
    )
    part = scene(parented).primitives[1]
    assert part.center == pytest.approx((16, 0, 2))
    cleared = (
        parented + "bpy.data.objects[1].select_set(True)\nbpy.ops.object.parent_clear(type='CLEAR_KEEP_TRANSFORM')"
    )
    assert scene(cleared).primitives[1].center == pytest.approx((16, 0, 2))
    (joined,) = scene(
        CUBE + "bpy.ops.mesh.primitive_cube_add(size=1, location=(7, 0, 0.5))\ncar.select_set(True)\n"
        "bpy.context.view_layer.objects.active = car\nbpy.ops.object.join()"
    )
    assert joined.shape == "mesh"
    assert (joined.size, joined.center) == (pytest.approx((3, 1, 1)), pytest.approx((6, 0, 0.5)))


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("bpy.ops.object.select_all(action='ALL')", "the action is 'ALL'"),
        ("bpy.ops.object.mode_set(mode='SCULPT')", "the mode 'SCULPT' is not supported"),
        ("bpy.ops.object.mode_set(mode='EDIT')\nbpy.ops.mesh.primitive_cube_add()", "leave it first"),
        ("bpy.ops.object.mode_set(mode='EDIT')\nbpy.ops.mesh.spin()", "bpy.ops.mesh.spin is not supported"),
        ("bpy.ops.object.delete()\nbpy.ops.object.modifier_add(type='ARRAY')", "no active object that could have"),
        ("bpy.ops.object.origin_set(type='ORIGIN_CENTER_OF_MASS')", "origin_set to 'ORIGIN_CENTER_OF_MASS'"),
        ("car.scale.x = 2\nbpy.ops.object.transform_apply(scale=False)", "applied without an uneven scale"),
        ("bpy.context.view_layer.objects.active = None\nbpy.ops.object.join()", "no selected mesh"),
        ("bpy.context.view_layer.objects.active = None\nbpy.ops.object.parent_set()", "no active object"),
    ],
)
def test_what_they_refuse(script: str, said: str) -> None:
    refuses(script, said)


def test_a_turn_by_a_quarter_keeps_a_box() -> None:
    car = with_car(f"car.scale = (2, 1, 4)\ncar.rotation_euler = (0, {math.pi / 2}, 0)")
    assert car.shape == "box"
    assert car.size == pytest.approx((4, 1, 2))


def test_a_copy_is_moved() -> None:
    layout = scene(
        CUBE + "bpy.ops.object.duplicate_move(TRANSFORM_OT_translate={'value': (6, 0, 0)})\n"
        "getattr(bpy.ops.object, 'duplicate_move')(OBJECT_OT_duplicate={'linked': True})\n"
    )
    assert [primitive.center[0] for primitive in layout] == [5, 11, 11]
    refuses("bpy.ops.object.duplicate_move(TRANSFORM_OT_translate=1)", "duplicate_move gets 1; it must be")
