from scene_reading import CUBE, refuses, scene, with_car


def test_blocks_are_found_listed_and_removed() -> None:
    with_car(
        "assert 'Car' in bpy.data.objects and bpy.data.objects.keys() == ['Car'] and len(bpy.data.objects) == 1\n"
        "assert bpy.data.objects[0] is car and bpy.data.objects[-1] is car and bpy.data.objects.get('x', 3) == 3\n"
        "m = bpy.data.meshes.new('m')\nassert [b.name for b in bpy.data.meshes] == ['Cube', 'm']\n"
        "bpy.data.meshes.remove(m)\nassert len(bpy.data.meshes) == 1 and bpy.data.materials[:] == []"
    )


def test_properties_of_the_users_own() -> None:
    with_car(
        "car['speed'] = 3\n"
        "assert car['speed'] == 3 and car.get('x', 1) == 1 and 'speed' in car and car.keys() == ['speed']"
    )
    refuses("car['x']", "an object 'Car' has no property 'x'")
    refuses("car['x'] = print", "a property of a function is not supported")


def test_what_no_shape_depends_on_may_be_anything() -> None:
    layout = scene(
        CUBE + "scene = bpy.context.scene\nscene.render.image_settings.file_format = 'PNG'\n"
        "for node in scene.render.views:\n    node.use = scene.render.use_multiview\n"
        "if scene.render.filepath:\n    scene.render.resolution_x = 5"
    )
    assert layout.provenance["notes"] == ["line 7: render of the scene is passed over"]
    refuses(
        "car.location.x = bpy.context.scene.render.fps",
        "a coordinate is render of the scene; it must be a finite number",
    )
    refuses("bpy.data.objects.remove(5)", "5 is not in bpy.data.objects")
