"""Objects of a scene: how they are made, found, moved, joined, copied and grouped, and what is refused."""

import math

import pytest
from scene_reading import CUBE, refuses, scene, with_car

from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.scene.layout import primitive_mesh

TREES = "trees = bpy.data.collections.new('Trees')\n"
EDIT = "bpy.ops.object.mode_set(mode='EDIT')\n"
REFUSED: list[tuple[str, str]] = [
    ("bpy.context.scene.cursor.location = (1, 2)", "the location of the cursor is a tuple; it must be 3 numbers"),
    ("bpy.context.scene.speed = 1", "'speed' of the scene cannot be set to 1"),
    ("bpy.context.edit_object", "bpy.context has no 'edit_object' that is supported"),
    ("bpy.data.armatures.new('a')", "bpy.data.armatures.new is not supported"),
    ("bpy.context.collection.objects.link(car)", "the object 'Car' is in this collection already"),
    ("bpy.context.collection.objects.link(5)", "what is linked is 5; it must be an object"),
    (TREES + "trees.objects.unlink(car)", "an object is not in this collection"),
    (TREES + "trees.children.link(car)", "what is linked is an object; it must be a collection"),
    ("car.speed = 3", "'speed' of an object cannot be set to 3"),
    ("car.vertices", "an object has no 'vertices' that is supported"),
    ("car.location = (1, 2)", "the location is a tuple; it must be 3 numbers"),
    ("car.scale = (1, 2, float('inf'))", "the scale is inf"),
    ("car.modifiers.new('a', 'ARRAY').count = 1001", "the count of an array is 1001; it must be 1 to 1000"),
    ("car.modifiers.new('a', 'ARRAY').fit_type = 'FIT_LENGTH'", "'fit_type' of an array modifier cannot be set"),
    (
        "for i in range(2):\n    car.modifiers.new('a', 'ARRAY').count = 99",
        "^line 3: .* 9801 copies; the limit is 1000",
    ),
    ("bpy.ops.import_scene.obj(filepath='a.obj')", "^line 6: bpy.ops.import_scene.obj is not supported"),
    ("bpy.ops.mesh()", "bpy.ops.mesh cannot be called"),
    ("bpy.types.Operator", "bpy.types.Operator is not supported"),
    ("bpy.ops.object.select_all(action='ALL')", "the action is 'ALL'"),
    ("bpy.ops.object.mode_set(mode='SCULPT')", "the mode 'SCULPT' is not supported"),
    ("bpy.ops.object.mode_set(mode='EDIT')\nbpy.ops.mesh.primitive_cube_add()", "leave the edit mode first"),
    ("bpy.ops.object.mode_set(mode='EDIT')\nbpy.ops.mesh.spin()", "bpy.ops.mesh.spin is not supported"),
    (EDIT + "bpy.ops.mesh.select_all(action='SOME')", "line 7: the action is 'SOME'"),
    (EDIT + "bpy.ops.mesh.extrude_region_move()", r"line 7: bpy.ops.mesh.extrude_region_move is not supported"),
    ("car.scale = (0, 1, 1)\n" + EDIT + "bpy.ops.transform.translate(value=(1, 0, 0))", "scaled to nothing"),
    (
        "import bmesh\n" + EDIT + "bmesh.from_edit_mesh(car.data)\nbpy.ops.transform.translate(value=(1, 0, 0))",
        "line 9: the edit mode transforms a mesh that bmesh does not have open",
    ),
]


@pytest.mark.parametrize(("script", "said"), REFUSED)
def test_it_is_refused(script: str, said: str) -> None:
    refuses(script, said)


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
    assert list(layout.notes) == ["line 7: render of the scene is passed over"]
    refuses(
        "car.location.x = bpy.context.scene.render.fps",
        "a coordinate is render of the scene; it must be a finite number",
    )
    refuses("bpy.data.objects.remove(5)", "5 is not in bpy.data.objects")


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
        "bpy.ops.object.camera_add(location=(0, 0, 9))\nbpy.context.object.constraints.new('TRACK_TO').target = lamp\n"
        "for light in bpy.data.lights:\n    bpy.data.lights.remove(light)\nbpy.ops.mesh.primitive_cube_add()\n"
        "bpy.context.object.name = 'Car'\nassert lamp.type == 'LIGHT' and lamp.name == 'Lamp'"
    )
    assert [p.id for p in layout] == ["Car"]


def test_objects_are_in_the_scene_through_their_collections() -> None:
    moved = CUBE + TREES + "car.name = 'Blob'\nbpy.context.collection.objects.unlink(car)\ntrees.objects.link(car)\n"
    layout = scene(moved + "bpy.context.scene.collection.children.link(trees)\nassert trees.objects[:] == [car]")
    assert [p.label for p in layout] == ["vegetation"]
    more = "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Bus'"
    layout = scene(moved + more)
    assert [p.label for p in layout] == ["bus"]
    assert list(layout.notes) == ["line 11: Blob is not linked to the scene"]


def test_what_collections_hold() -> None:
    scene(
        CUBE + TREES + "bpy.context.scene.collection.children.link(trees)\n"
        "assert car.users_collection[0].name == 'Scene Collection' and 'Car' in bpy.context.collection.objects\n"
        "assert len(trees.objects) == 0 and [c.name for c in bpy.context.scene.collection.children] == ['Trees']\n"
        "assert bpy.context.collection.objects['Car'] is car and trees.objects.get('Car') is None\n"
        "inner = bpy.data.collections.new('Inner')\ntrees.children.link(inner)\n"
        "inner.children.link(trees)\ninner.objects.link(car)"
    )


def test_new_objects_come_into_the_active_collection() -> None:
    layout = scene(
        "cars = bpy.data.collections.new('Cars')\nbpy.context.scene.collection.children.link(cars)\n"
        "layer = bpy.context.view_layer\nlayer.active_layer_collection = layer.layer_collection.children['Cars']\n"
        "assert bpy.context.collection is cars and layer.active_layer_collection.name == 'Cars'\n"
        "bpy.ops.mesh.primitive_cube_add()\nassert bpy.context.object.users_collection == (cars,)\n"
        "layer.layer_collection.children[0].hide_viewport = True\n"
        "bpy.data.collections.remove(bpy.data.collections.new('Other'))"
    )
    assert [shape.label for shape in layout] == ["car"]
    assert any("what hides collections" in note for note in layout.notes)


def test_a_removed_collection_is_active_no_more() -> None:
    scene(
        "c = bpy.data.collections.new('C')\nbpy.context.scene.collection.children.link(c)\n"
        "layer = bpy.context.view_layer\nlayer.active_layer_collection = layer.layer_collection.children['C']\n"
        "bpy.data.collections.remove(c)\nassert bpy.context.collection is bpy.context.scene.collection\n" + CUBE
    )
    refuses("bpy.context.view_layer.layer_collection.children['None']", "has no 'None'")


def test_numbers_of_all_objects_of_a_collection_are_set_in_the_order_of_their_links() -> None:
    script = (
        "c = bpy.data.collections.new('Cars')\nbpy.context.scene.collection.children.link(c)\nm = car.data\n"
        "bpy.data.objects.remove(car)\na, b = bpy.data.objects.new('b', m), bpy.data.objects.new('a', m)\n"
        "c.objects.link(b)\nc.objects.link(a)\n"
    )
    layout = scene(
        CUBE + script + "c.objects.foreach_set('location', [1, 2, 3, 4, 5, 6])\n"
        "c.objects.foreach_set('scale', (1, 1, 1, 2, 2, 2))\nassert c.objects[:] == [b, a] and c.objects[0] is b"
    )
    assert {shape.id: (shape.center, shape.size[0]) for shape in layout} == {"a": ((1, 2, 3), 1), "b": ((4, 5, 6), 2)}
    refuses(script + "c.objects.foreach_set('location', [1, 2, 3])", "foreach_set of 'location' for 2 objects to 3")
    refuses(script + "c.objects.foreach_set('name', [1, 2, 3, 4, 5, 6])", "foreach_set of 'name'")
    refuses(script + "c.objects.foreach_set('scale', [1, 2, 3, 4, 5, 'a'])", "the scale is 'a'")


def test_a_collection_is_linked_once_and_unlinked_once() -> None:
    script = "c, d = bpy.data.collections.new('c'), bpy.context.scene.collection.children\nd.link(c)\n"
    scene(CUBE + script + "assert 'c' in d and d.get('c') is c and d.keys() == ['c']\nd.unlink(c)\nassert 'c' not in d")
    refuses(script + "d.link(c)", "the collection 'c' is in this collection already")
    refuses(script + "d.unlink(c)\nd.unlink(c)", "a collection is not in this collection")


def test_dimensions_are_those_of_the_mesh_in_place() -> None:
    car = with_car("car.dimensions = (4.5, 1.8, 1.5)\nassert car.dimensions[0] == 4.5 and car.scale.y == 1.8")
    assert car.size == (4.5, 1.8, 1.5)


def test_names_that_are_taken_get_numbers_as_in_blender() -> None:
    script = (
        "a, b, c, d = [bpy.data.objects.new(name, None) for name in ('A', 'A', 'A.005', 'A.005')]\n"
        "assert [x.name for x in (a, b, c, d)] == ['A', 'A.001', 'A.005', 'A.002']\n"
        "b.name = 'B'\nassert b.name == 'B' and 'A.001' not in bpy.data.objects and bpy.data.objects['B'] is b\n"
        "bpy.data.objects.remove(a, do_unlink=True)\nassert bpy.data.objects.get('A') is None\n"
    )
    with_car(script)


def test_a_part_goes_with_its_parent() -> None:
    script = CUBE + (
        "bpy.ops.mesh.primitive_cube_add(size=1, location=(1, 0, 1))\npart = bpy.context.object\npart.parent = car\n"
        "car.rotation_euler.z = math.pi / 2\ncar.scale = (2, 2, 2)\nassert part.matrix_world.translation.z == 2.5\n"
        "assert part.parent is car and car.parent is None"
    )
    part = scene(script).primitives[1]
    assert part.center == pytest.approx((5, 2, 2.5))
    assert part.size == pytest.approx((2, 2, 2))


def test_a_copy_shares_its_mesh_until_that_is_copied() -> None:
    layout = scene(
        CUBE + "twin = car.copy()\nbpy.context.collection.objects.link(twin)\ntwin.location.x = 30\ncar.scale.x = 4"
    )
    assert [(p.id, p.center[0], p.size[0]) for p in layout] == [("Car", 5, 4), ("Car_001", 30, 1)]


def test_how_objects_look_is_passed_over_with_a_note() -> None:
    layout = scene(CUBE + "car.hide_render = True\ncar.color = (1, 0, 0, 1)\ncar.keyframe_insert(data_path='location')")
    assert len(layout.notes) == 3


def test_an_array_makes_a_row_of_objects() -> None:
    layout = scene(
        CUBE + "car.scale = (4, 2, 1.5)\nm = car.modifiers.new('Row', 'ARRAY')\nm.count = 3\n"
        "m.relative_offset_displace = (1.5, 0, 0)\n"
    )
    assert [primitive.center[0] for primitive in layout] == [5, 11, 17]
    assert len({primitive.instance for primitive in layout}) == 3
    assert {primitive.size for primitive in layout} == {(4, 2, 1.5)}


@pytest.mark.parametrize("name", ["Car_1", "Car.001", "Car_1_Body"])
def test_what_an_array_makes_shares_nothing_with_other_objects(name: str) -> None:
    layout = scene(
        CUBE + f"car.name = '{name}'\ncar['id'], car['instance'] = 'first', 7\n"
        "car.modifiers.new('Row', 'ARRAY').count = 3\n"
        "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Car_2'\n"
    )
    assert [primitive.id for primitive in layout] == ["first", "first_array001", "first_array002", "Car_2"]
    assert layout["first"].instance == 7
    assert len({primitive.instance for primitive in layout}) == 4


def test_parts_that_have_arrays_belong_to_one_object_each() -> None:
    row = ".modifiers.new('Row', 'ARRAY')\nm.count, m.use_relative_offset, m.use_constant_offset = 2, False, True\n"
    layout = scene(
        CUBE + f"car.name = 'Car_1_Body'\nm = car{row}bpy.ops.mesh.primitive_cube_add()\n"
        f"bpy.context.object.name = 'Car_1_Wheel'\nm = bpy.context.object{row}"
    )
    assert [(primitive.id, primitive.instance) for primitive in layout] == [
        ("Car_1.Body", 1),
        ("Car_1_array001.Body", 2),
        ("Car_1.Wheel", 1),
        ("Car_1_array001.Wheel", 2),
    ]


def test_arrays_of_arrays_and_constant_offsets() -> None:
    layout = scene(
        CUBE + "bpy.ops.object.modifier_add(type='ARRAY')\nm = car.modifiers['Array']\nm.use_relative_offset = False\n"
        "m.use_constant_offset = True\nm.constant_offset_displace[0] = 2\n"
        "bpy.ops.object.modifier_add(type='ARRAY')\ncar.modifiers[-1].relative_offset_displace = (0, 3, 0)\n"
        "car.rotation_euler.z = math.pi / 2\n"
    )
    assert sorted((round(p.center[0], 6), round(p.center[1], 6)) for p in layout) == [(2, 0), (2, 2), (5, 0), (5, 2)]


def test_other_modifiers_are_passed_over_with_their_line() -> None:
    script = (
        "import bpy\n"
        + CUBE
        + "m = car.modifiers.new('a', 'SOLIDIFY')\nm.thickness = 3\ncar.modifiers.new('b', 'BEVEL')"
    )
    notes = layout_from_blender(script).notes
    assert "line 5: the modifier 'SOLIDIFY' is passed over: the shape is that without it" not in notes  # no quotes
    assert "line 5: the modifier SOLIDIFY is passed over: the shape is that without it" in notes
    assert "line 7: the modifier BEVEL is passed over" in notes
    assert with_car("car.modifiers['none'].width = 2").size == (1, 1, 1)


def test_operators_that_leave_shapes_alone_are_passed_over() -> None:
    calls = ("render.render(write_still=True)", "wm.save_as_mainfile(filepath='a')", "export_scene.gltf(filepath='a')")
    layout = scene(
        CUBE + "".join(f"bpy.ops.{call}\n" for call in calls) + "if bpy.ops.object.mode_set.poll():\n    pass"
    )
    assert [note.split(": ")[1].split(" ")[0] for note in layout.notes] == [
        "bpy.ops.render.render",
        "bpy.ops.wm.save_as_mainfile",
        "bpy.ops.export_scene.gltf",
    ]


@pytest.mark.parametrize(
    ("operator", "shape", "size"),
    [
        ("cube_add(size=3)", "box", (3, 3, 3)),
        ("cube_add(size=2, scale=(1, 2, 3))", "box", (2, 4, 6)),
        ("plane_add(size=4)", "plane", (4, 4, 0)),
        ("grid_add(x_subdivisions=3, size=4)", "plane", (4, 4, 0)),
        ("cylinder_add(radius=2, depth=5)", "cylinder", (4, 4, 5)),
        ("cone_add(radius1=1, radius2=1, depth=2)", "cylinder", (2, 2, 2)),
        ("cone_add(radius1=1.5, depth=2, vertices=32)", "mesh", (3, 3, 2)),
        ("uv_sphere_add(radius=2)", "ellipsoid", (4, 4, 4)),
        ("ico_sphere_add(radius=2, subdivisions=3)", "ellipsoid", (4, 4, 4)),
        ("torus_add(major_radius=2, minor_radius=0.5)", "mesh", (5, 5, 1)),
        ("torus_add(mode='EXT_INT', abso_major_rad=2, abso_minor_rad=1)", "mesh", (4, 4, 1)),
        ("circle_add(radius=2, fill_type='NGON')", "mesh", (4, 4, 0)),
    ],
)
def test_each_operator_makes_its_shape(operator: str, shape: str, size: tuple[float, ...]) -> None:
    (primitive,) = scene(f"bpy.ops.mesh.primitive_{operator}\nbpy.context.object.name = 'House'")
    assert primitive.shape == shape
    assert primitive.size == pytest.approx(size, abs=1e-9)


def test_a_circle_without_faces_is_left_out() -> None:
    layout = scene(
        "bpy.ops.mesh.primitive_circle_add()\nbpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Car'"
    )
    assert [p.label for p in layout] == ["car"]
    assert "Circle has no faces" in layout.notes[0]


@pytest.mark.parametrize(
    ("operator", "said"),
    [
        ("cube_add(width=3)", "the argument 'width' is not supported; size are"),
        ("cube_add(align='VIEW')", "align='VIEW' or enter_editmode is not supported"),
        ("ico_sphere_add(subdivisions=9)", "subdivisions is 9; it must be 1 to 8"),
        ("monkey_add()", "monkey_add is not supported"),
    ],
)
def test_what_they_refuse(operator: str, said: str) -> None:
    refuses(f"bpy.ops.mesh.primitive_{operator}", said)


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
        "bpy.ops.transform.translate(value=(1, 2, 0))\nbpy.ops.transform.resize(value=(4, 2, 1))\n"
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


def test_curves_pass_and_are_no_shapes() -> None:
    layout = scene(
        CUBE + "bpy.ops.curve.primitive_bezier_circle_add(radius=3, location=(0, 1, 0))\n"
        "rail = bpy.context.object\nrail.name = 'Guardrail'\nrail.data.bevel_depth = 0.1\n"
        "rail.data.splines[0].bezier_points[0].co = (1, 2, 3)\nbpy.ops.curve.subdivide()\n"
        "bpy.ops.surface.primitive_nurbs_surface_sphere_add()\nbpy.ops.object.select_all(action='DESELECT')"
    )
    assert [p.id for p in layout] == ["Car"]
    assert [note.partition(": ")[2] for note in layout.notes] == [
        "CURVE is passed over",
        "bpy.ops.curve.subdivide is passed over",
        "SURFACE is passed over",
    ]


def test_lists_are_gone_through_by_names_where_they_have_some() -> None:
    with_car(
        "assert car.data.vertices.items() == [] and bpy.data.objects.keys() == ['Car']\n"
        "assert [name for name, item in bpy.context.collection.objects.items() if item is car] == ['Car']"
    )
