from scene_reading import CUBE, refuses, scene

TREES = "trees = bpy.data.collections.new('Trees')\n"


def test_objects_are_in_the_scene_through_their_collections() -> None:
    moved = CUBE + TREES + "car.name = 'Blob'\nbpy.context.collection.objects.unlink(car)\ntrees.objects.link(car)\n"
    layout = scene(
        moved + "bpy.context.scene.collection.children.link(trees)\nassert trees.objects[:] == [car] or True"
    )
    assert [p.label for p in layout] == ["vegetation"]
    more = "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Bus'"
    layout = scene(moved + more)
    assert [p.label for p in layout] == ["bus"]
    assert layout.provenance["notes"] == ["line 11: Blob is not linked to the scene"]


def test_what_collections_hold() -> None:
    scene(
        CUBE + TREES + "bpy.context.scene.collection.children.link(trees)\n"
        "assert car.users_collection[0].name == 'Scene Collection' and 'Car' in bpy.context.collection.objects\n"
        "assert len(trees.objects) == 0 and [c.name for c in bpy.context.scene.collection.children] == ['Trees']\n"
        "assert bpy.context.collection.objects['Car'] is car and trees.objects.get('Car') is None\n"
        "inner = bpy.data.collections.new('Inner')\ntrees.children.link(inner)\n"
        "inner.children.link(trees)\ninner.objects.link(car)"
    )


def test_what_they_refuse() -> None:
    refuses("bpy.context.collection.objects.link(car)", "the object 'Car' is in this collection already")
    refuses("bpy.context.collection.objects.link(5)", "5 is no object")
    refuses(TREES + "trees.objects.unlink(car)", "an object is not in this collection")
    refuses(TREES + "trees.children.link(car)", "an object is no collection")


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
    assert any("what hides collections" in note for note in layout.provenance["notes"])


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
