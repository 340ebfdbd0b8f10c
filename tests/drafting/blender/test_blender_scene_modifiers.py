import pytest
from scene_reading import CUBE, refuses, scene, with_car

from lidardraft.drafting.blender.layout import layout_from_blender


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
    notes = layout_from_blender(script).provenance["notes"]
    assert "line 5: the modifier 'SOLIDIFY' is passed over: the shape is that without it" not in notes  # no quotes
    assert "line 5: the modifier SOLIDIFY is passed over: the shape is that without it" in notes
    assert "line 7: the modifier BEVEL is passed over" in notes
    assert with_car("car.modifiers['none'].width = 2").size == (1, 1, 1)


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("car.modifiers.new('a', 'ARRAY').count = 1001", "the count of an array is 1001; it must be 1 to 1000"),
        ("car.modifiers.new('a', 'ARRAY').fit_type = 'FIT_LENGTH'", "'fit_type' of an array modifier cannot be set"),
        (
            "for i in range(2):\n    car.modifiers.new('a', 'ARRAY').count = 99",
            "^line 3: .* make 9801 copies; 1000 are",
        ),
        ("for i in range(99):\n    car.modifiers.new('a', 'ARRAY')", "an object with more than 8 modifiers"),
    ],
)
def test_what_they_refuse(script: str, said: str) -> None:
    refuses(script, said)
