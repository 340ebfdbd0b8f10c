"""Classes, ids and instances of the objects of a scene."""

import pytest
from scene_reading import CUBE, scene, with_car

from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.errors import LayoutError

ADD = (
    "def add(name, x=0):\n    bpy.ops.mesh.primitive_cube_add(size=1, location=(x, 0, 1))\n"
    "    bpy.context.object.name = name\n"
)


def test_things_are_numbered_and_stuff_is_not() -> None:
    layout = scene(ADD + "add('Car')\nadd('House')\nadd('Car')\nadd('pedestrian_left')")
    assert [(p.id, p.label, p.instance) for p in layout] == [
        ("Car", "car", 1),
        ("House", "building", 0),
        ("Car_001", "car", 2),
        ("pedestrian_left", "person", 3),
    ]


def test_parts_with_one_number_are_one_thing() -> None:
    layout = scene(ADD + "add('Car_1_Body')\nadd('Car_1_Wheel')\nadd('Car_1_Wheel')\nadd('Car_2_Body')")
    assert [(p.id, p.instance) for p in layout] == [
        ("Car_1.Body", 1),
        ("Car_1.Wheel", 1),
        ("Car_1.Wheel_001", 1),
        ("Car_2.Body", 2),
    ]


def test_parts_of_one_parent_are_one_thing() -> None:
    script = "root = bpy.data.objects.new('Bus', None)\nbpy.context.collection.objects.link(root)\n" + ADD
    layout = scene(
        script + "for name in ('Body', 'Roof'):\n    add(name)\n    bpy.context.object.parent = root\nadd('Car')"
    )
    assert [(p.id, p.label, p.instance) for p in layout] == [
        ("Bus.Body", "bus", 1),
        ("Bus.Roof", "bus", 1),
        ("Car", "car", 2),
    ]


def test_a_parent_that_is_a_part_itself() -> None:
    script = "add('Car_1_Body')\nbody = bpy.context.object\nadd('Car_1_Cabin')\nbpy.context.object.parent = body"
    assert [(p.id, p.instance) for p in scene(ADD + script)] == [("Car_1.Body", 1), ("Car_1.Cabin", 1)]


def test_properties_come_before_names() -> None:
    layout = scene(
        CUBE + "car['class'] = 'truck'\ncar['id'] = 'lorry.body'\ncar['instance'] = 7\ncar['material'] = 'glass'\n"
        "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Car'"
    )
    first, second = layout
    assert (first.label, first.id, first.instance, first.material) == ("truck", "lorry.body", 7, "glass")
    assert second.instance == 1


def test_names_that_say_no_class_are_listed() -> None:
    script = "import bpy\n" + ADD + "add('Cube')\nadd('Thingy')\nadd('Car')"
    with pytest.raises(LayoutError, match=r"no class for Cube \(line 3\), Thingy \(line 3\); say which by --class"):
        layout_from_blender(script)
    layout = layout_from_blender(script, classes={"Cube": "building", "Thingy": "other"})
    assert [p.label for p in layout] == ["building", "other", "car"]


def test_the_ego_vehicle_is_left_out() -> None:
    layout = scene(ADD + "add('Ego_Car')\nadd('EgoVehicle_Wheel')\nadd('Lego_Car')")
    assert [p.id for p in layout] == ["Lego_Car"]
    assert layout.provenance["notes"] == ["line 8: the ego vehicle is left out: it carries the sensor"]


def test_a_vehicle_modelled_along_y_is_turned() -> None:
    layout = scene(CUBE + "car.scale = (1.8, 4.5, 1.5)\n" + ADD + "add('House')\nbpy.context.object.scale = (2, 8, 3)")
    assert layout.primitives[0].size == (4.5, 1.8, 1.5)
    assert layout.primitives[0].yaw == pytest.approx(1.5707963)
    assert layout.primitives[1].size == (2, 8, 3)


def test_the_class_of_a_mesh_is_that_of_its_objects() -> None:
    car = with_car("car.name = 'Wall'\ncar.data['class'] = 'bus'\ncar.scale = (1, 5, 1)")
    assert (car.label, car.size) == ("bus", (1, 5, 1))
    assert with_car("car.data['class'] = 'bus'\ncar['class'] = 'truck'").label == "truck"
