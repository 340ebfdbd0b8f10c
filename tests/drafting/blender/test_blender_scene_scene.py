import pytest
from scene_reading import refuses, scene, with_car


def test_what_the_context_tells() -> None:
    with_car(
        "assert bpy.context.object is car and bpy.context.active_object is car\n"
        "assert bpy.context.selected_objects == [car]\n"
        "assert bpy.context.mode == 'OBJECT' and bpy.context.scene.objects['Car'] is car\n"
        "assert bpy.context.view_layer.objects.active is car and bpy.data.scenes[0].name == bpy.context.scene.name\n"
        "car.select_set(False)\nassert bpy.context.selected_objects == [] and not car.select_get()\n"
        "bpy.context.view_layer.update()\nassert bpy.app.version >= (2, 80, 0) and bpy.app.background"
    )


def test_lights_and_cameras_are_objects_without_a_shape() -> None:
    layout = scene(
        "sun = bpy.data.lights.new(name='Sun', type='SUN')\nsun.energy = 5\nlamp = bpy.data.objects.new('Lamp', sun)\n"
        "bpy.context.collection.objects.link(lamp)\nlamp.rotation_mode = 'QUATERNION'\n"
        "bpy.ops.object.camera_add(location=(0, 0, 9))\n"
        "bpy.context.object.constraints.new('TRACK_TO').target = lamp\n"
        "for light in bpy.data.lights:\n    bpy.data.lights.remove(light)\n"
        "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Car'\n"
        "assert lamp.type == 'LIGHT' and lamp.name == 'Lamp'"
    )
    assert [p.id for p in layout] == ["Car"]


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("bpy.context.scene.cursor.location = (1, 2)", "the location of the cursor is a tuple; it must be 3 numbers"),
        ("bpy.context.scene.speed = 1", "'speed' of the scene cannot be set to 1"),
        ("bpy.context.edit_object", "bpy.context has no 'edit_object' that is supported"),
        ("bpy.data.armatures.new('a')", "bpy.data.armatures.new is not supported"),
        ("bpy.data.scenes['Other']", "bpy.data.scenes has no 'Other'"),
        ("bpy.data.texts", "bpy.data.texts is not supported"),
        ("bpy.context.view_layer.objects.active = 5", "'active' of the view layer cannot be set to 5"),
        ("bpy.app.handlers", "bpy.app.handlers is not supported"),
    ],
)
def test_what_is_refused(script: str, said: str) -> None:
    refuses(script, said)
