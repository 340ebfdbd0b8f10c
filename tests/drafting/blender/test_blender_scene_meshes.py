import pytest
from scene_reading import refuses, scene, with_car

TENT = "mesh = bpy.data.meshes.new('Tent')\nmesh.from_pydata(%s, [], %s)\nmesh.update()\nmesh.validate()\n"
LINKED = "tent = bpy.data.objects.new('House', mesh)\nbpy.context.collection.objects.link(tent)\n"
CORNERS = "[(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 3)]"


def test_lists_of_vertices_and_polygons() -> None:
    script = TENT % (CORNERS, "[(0, 1, 2, 3), (0, 1, 4), (1, 2, 4)]") + LINKED
    (tent,) = scene(script + "tent.location = (10, 0, 0)")
    assert (tent.shape, tent.center, tent.size) == ("mesh", (11, 1, 1.5), (2, 2, 3))
    assert tent.mesh is not None
    assert len(tent.mesh.faces) == 4


def test_vectors_and_ranges_are_lists_too() -> None:
    script = TENT % ("[Vector(c) for c in " + CORNERS + "]", "[range(3), [0, 1, 4]]") + LINKED
    assert len(scene(script)) == 1


def test_a_mesh_is_copied_and_moved() -> None:
    script = TENT % (CORNERS, "[(0, 1, 4)]") + LINKED
    script += "other = mesh.copy()\nother.transform(Matrix.Translation((0, 0, 5)))\ntent.data = other\n"
    assert scene(script).primitives[0].center[2] == pytest.approx(6.5)


def test_materials_of_a_mesh() -> None:
    car = with_car(
        "car.name = 'Cube'\nred = bpy.data.materials.new('mat_truck')\nred.diffuse_color = (1, 0, 0, 1)\n"
        "car.data.materials.append(None)\ncar.data.materials[0] = red\n"
        "assert len(car.data.materials) == 1 and car.active_material is red\n"
        "car.active_material = red\ncar.data.materials.clear()\ncar.active_material = red"
    )
    assert car.label == "truck"


@pytest.mark.parametrize(
    ("script", "said"),
    [
        (TENT % ("[(0, 0)]", "[]"), "a vertex is a tuple; it must be 3 numbers"),
        (TENT % (CORNERS, "[(0, 1, 7)]"), r"face 0 is \(0, 1, 7\); the mesh has 5 vertices"),
        (TENT % (CORNERS, "[(0, 1, 0.5)]"), "face 0 is"),
        (TENT % ("5", "[]"), "5 cannot be looped over"),
        ("car.data.materials.append('red')", "'red' is no material"),
        ("car.data.materials[0]", "the list of materials has no 0"),
        ("for e in car.data.edges:\n    e.select = True", "`edges` of a mesh cannot be looped over"),
        ("car.data.vertices[8]", "`vertices` of a mesh has no 8"),
        ("car.data.vertices[0].normal = (0, 0, 1)", "'normal' of a vertex cannot be set"),
        ("car.data.transform(5)", "a mesh is transformed by a matrix of 4 rows"),
        ("car.data = 5", "the data of an object is 5; it must be a mesh"),
    ],
)
def test_what_they_refuse(script: str, said: str) -> None:
    refuses(script, said)


def test_smooth_faces_are_passed_over() -> None:
    with_car("for p in car.data.polygons:\n    p.use_smooth = True\ncar.data.shade_smooth()")
