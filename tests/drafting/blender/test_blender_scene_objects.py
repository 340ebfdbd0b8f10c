import pytest
from scene_reading import CUBE, refuses, scene, with_car


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


def test_a_matrix_places_an_object() -> None:
    matrix = "Matrix.Translation((7, 8, 9)) @ Matrix.Rotation(0.4, 4, 'Z') @ Matrix.Diagonal((4, 2, 1, 1))"
    car = with_car(f"car.matrix_world = {matrix}")
    assert car.center == pytest.approx((7, 8, 9))
    assert (car.size, car.yaw) == (pytest.approx((4, 2, 1)), pytest.approx(0.4))


def test_a_copy_shares_its_mesh_until_that_is_copied() -> None:
    layout = scene(
        CUBE + "twin = car.copy()\nbpy.context.collection.objects.link(twin)\ntwin.location.x = 30\ncar.scale.x = 4"
    )
    assert [(p.id, p.center[0], p.size[0]) for p in layout] == [("Car", 5, 4), ("Car_001", 30, 1)]


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("car.speed = 3", "'speed' of an object cannot be set to 3"),
        ("car.vertices", "an object has no 'vertices' that is supported"),
        ("car.location = (1, 2)", "the location is a tuple; it must be 3 numbers"),
        ("car.scale = (1, 2, float('inf'))", "the scale is inf"),
        ("car.rotation_mode = 'ZYX'", "the rotation mode 'ZYX' is not supported"),
        ("car.parent = 5", "the parent is 5; it must be an object"),
        ("car.matrix_world = Matrix(((1, 1, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)))", "a matrix that shears"),
        ("car.constraints.new('COPY_LOCATION')", "constraints of objects are not supported"),
        (
            "car.matrix_world = Matrix.Scale(1e299, 4) @ Matrix.Scale(1e299, 4)",
            "a matrix with a number that is not finite",
        ),
        (
            "bpy.ops.object.empty_add()\nempty = bpy.context.object\nempty.scale = (0, 0, 0)\ncar.parent = empty\n"
            "car.matrix_world = Matrix()",
            "the parent of 'Car' is scaled to nothing",
        ),
        ("bpy.data.objects.new('x', 5)", "an object of 5 is not supported"),
        ("bpy.data.objects['Bus']", "bpy.data.objects has no 'Bus'"),
    ],
)
def test_what_they_refuse(script: str, said: str) -> None:
    refuses(script, said)


def test_how_objects_look_is_passed_over_with_a_note() -> None:
    layout = scene(CUBE + "car.hide_render = True\ncar.color = (1, 0, 0, 1)\ncar.keyframe_insert(data_path='location')")
    assert len(layout.provenance["notes"]) == 3
