import pytest
from scene_reading import refuses, scene, with_car

QUATERNION = "from mathutils import Quaternion\n"


def test_a_quaternion_turns_an_object_in_its_mode() -> None:
    for value in ("Quaternion((0, 0, 1), math.pi / 3)", "(math.cos(math.pi / 6), 0, 0, math.sin(math.pi / 6))"):
        car = with_car(QUATERNION + f"car.rotation_mode = 'QUATERNION'\ncar.rotation_quaternion = {value}")
        assert car.yaw == pytest.approx(1.0471975512)
    assert with_car(QUATERNION + "car.rotation_quaternion = Quaternion((0, 0, 1), 1)").yaw == 0  # as in Blender


def test_rotations_are_combined() -> None:
    scene(
        QUATERNION + "import bpy\nq = Quaternion((0, 0, 1), math.pi / 2)\nv = q @ Vector((1, 0, 0))\n"
        "assert abs(v.y - 1) < 1e-9 and abs((q @ q).to_euler().z) > 3.1\n"
        "assert abs((Euler((0, 0, 1)).to_quaternion().inverted() @ Vector((1, 0, 0))).y + math.sin(1)) < 1e-9\n"
        "e = Euler((0, 0, 0.5))\ne.rotate_axis('Z', 0.25)\nassert abs(e.z - 0.75) < 1e-9\n"
        "bpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Car'"
    )


def test_what_it_refuses() -> None:
    refuses(QUATERNION + "Quaternion((1, 2))", "the quaternion is a tuple; it must be 4 numbers")
    refuses(QUATERNION + "Quaternion((0, 0, 0), 1)", "a rotation about an axis without length")
    refuses("from mathutils import noise\nnoise.noise((0, 0, 0))", "a call of mathutils.noise.noise")
    refuses("Euler((0, 0, 0), 'ZYX')", "angles in the order 'ZYX'; only 'XYZ' is supported")
