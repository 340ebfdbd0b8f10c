"""Objects become shapes of a layout: classes, ids, instances, sizes."""

import math

import numpy as np
import pytest
from scene_reading import CUBE, scene, with_car

from lidardraft.drafting.blender.bpy import meshes
from lidardraft.drafting.blender.bpy.mathutils import rotation_matrix
from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.errors import LayoutError
from lidardraft.scene.layout import primitive_mesh

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


@pytest.mark.parametrize(
    ("body", "wheel"),
    [
        ("CarBody_{k}", "CarWheel_{k}_{w}"),
        ("Car_{k}", "Car_{k}_Wheel_FL"),
        ("Car_Red_Body", "Car_Red_Wheel_FL"),
        ("Car", "Car_Wheel"),
        ("RedCar", "RedCarWheels{w}"),
        ("Truck", "Truck_Tyre_{w}"),
    ],
)
def test_wheels_named_after_their_car_are_parts_of_it(body: str, wheel: str) -> None:
    """By the number before theirs or, where two cars differ in Blender's number alone, of the nearest one."""
    wheels = f"    for w in range(4):\n        add(f'{wheel}', 20 * k + w)\n"
    layout = scene(f"{ADD}for k in range(2):\n    add(f'{body}', 20 * k)\n{wheels}")
    assert [p.instance for p in layout] == [1] * 5 + [2] * 5
    assert len({p.id.partition(".")[0] for p in layout}) == 2
    assert len({p.id for p in layout}) == 10


def test_wheels_without_a_body_are_one_thing() -> None:
    layout = scene(ADD + "for k in (1, 2):\n    for w in (1, 2):\n        add(f'CarWheel_{k}_{w}')\nadd('Bus_Door')")
    assert [p.instance for p in layout] == [1, 1, 2, 2, 3]


def test_an_object_without_a_class_is_other_or_where_asked_refused() -> None:
    script = "import bpy\n" + ADD + "add('Cube')\nadd('Cube')\nadd('Thingy')\nadd('Car')"
    layout = layout_from_blender(script)
    assert [p.label for p in layout] == ["other", "other", "other", "car"]
    assert [note.partition(";")[0] for note in layout.notes] == [
        "line 3: no class for Cube: it becomes 'other'",
        "line 3: no class for Thingy: it becomes 'other'",
    ]
    with pytest.raises(LayoutError, match=r"no class for Cube \(line 3\), .*, Thingy \(line 3\); say which by --class"):
        layout_from_blender(script, strict=True)
    layout = layout_from_blender(script, classes={"Cube": "building", "Thingy": "other"}, strict=True)
    assert [p.label for p in layout] == ["building", "building", "other", "car"]


def test_the_ego_vehicle_is_left_out() -> None:
    layout = scene(ADD + "add('Ego_Car')\nadd('EgoVehicle_Wheel')\nadd('Lego_Car')")
    assert [p.id for p in layout] == ["Lego_Car"]
    assert list(layout.notes) == ["line 8: the ego vehicle is left out: it carries the sensor"]


def test_a_vehicle_modelled_along_y_is_turned() -> None:
    layout = scene(CUBE + "car.scale = (1.8, 4.5, 1.5)\n" + ADD + "add('House')\nbpy.context.object.scale = (2, 8, 3)")
    assert layout.primitives[0].size == (4.5, 1.8, 1.5)
    assert layout.primitives[0].yaw == pytest.approx(1.5707963)
    assert layout.primitives[1].size == (2, 8, 3)


def test_the_class_of_a_mesh_is_that_of_its_objects() -> None:
    car = with_car("car.name = 'Wall'\ncar.data['class'] = 'bus'\ncar.scale = (1, 5, 1)")
    assert (car.label, car.size) == ("bus", (1, 5, 1))
    assert with_car("car.data['class'] = 'bus'\ncar['class'] = 'truck'").label == "truck"


def test_numbers_are_kept_to_the_last_digit() -> None:
    car = with_car(
        "car.location = (0.1, 0.2, 0.3)\ncar.scale = (4.3, 1.7, 1.1)\ncar.rotation_euler = (0, 0, 1 / 3)\n"
        "car['class'] = 'car'"
    )
    assert (car.center, car.size, car.yaw) == ((0.1, 0.2, 0.3), (4.3, 1.7, 1.1), 1 / 3)


@pytest.mark.parametrize(
    ("script", "shape"),
    [
        ("car.rotation_euler = (0.3, 0, 0)", "mesh"),
        ("car.rotation_euler = (math.pi / 2, 0, 0.7)", "box"),
        ("car.scale = (-2, 1, 1)", "box"),
        ("car.scale = (2, 1, 0)", "plane"),
        ("car.scale = (2, 0, 1)", "mesh"),
    ],
)
def test_a_cube_is_a_box_where_it_stands_upright(script: str, shape: str) -> None:
    assert with_car(script).shape == shape


def test_a_cube_scaled_to_a_line_is_left_out() -> None:
    layout = scene(
        "bpy.ops.mesh.primitive_cube_add(scale=(1, 0, 0))\nbpy.context.object.name = 'Wall'\n"
        "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Bus'"
    )
    assert [p.id for p in layout] == ["Bus"]
    assert "Wall has no surface" in layout.notes[0]


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.4, 0.2, 0.9), (math.pi / 2, 0.0, 0.3), (0.0, math.pi, 0.0)])
@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (2.0, 0.5, 3.0), (1.0, -2.0, 1.0)])
@pytest.mark.parametrize("kind", ["cube", "cylinder", "uv_sphere", "plane", "cone", "torus"])
def test_every_shape_keeps_its_place(kind: str, angles: tuple[float, ...], scale: tuple[float, ...]) -> None:
    """Its bounds are those of the operator's mesh under the object's transform, to the rounding of a sphere."""
    (primitive,) = scene(
        f"bpy.ops.mesh.primitive_{kind}_add(location=(3, 4, 5), rotation={angles})\n"
        f"bpy.context.object.name = 'House'\nbpy.context.object.scale = {scale}"
    )
    shape = {
        "cube": meshes.cube(2.0),
        "cylinder": meshes.cone(1.0, 1.0, 2.0, 32),
        "uv_sphere": meshes.sphere(1.0, 32, 16),
        "plane": meshes.grid(2.0, 1, 1),
        "cone": meshes.cone(1.0, 0.0, 2.0, 32),
        "torus": meshes.torus(1.0, 0.25, 48, 12),
    }[kind]
    expected = shape.triangles()[0] * scale @ rotation_matrix(angles).T + (3, 4, 5)
    found = primitive_mesh(primitive).vertices
    off = 0.03 * max(map(abs, scale)) if kind == "uv_sphere" else 1e-6
    np.testing.assert_allclose(found.min(axis=0), expected.min(axis=0), atol=off)
    np.testing.assert_allclose(found.max(axis=0), expected.max(axis=0), atol=off)
