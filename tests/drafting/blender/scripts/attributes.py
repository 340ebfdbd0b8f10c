"""Every attribute of an object that can be set, as a whole and by its components, one rock each."""

import math

import bpy
from mathutils import Euler, Matrix, Quaternion, Vector


def rock(x, scale=(2, 1, 0.5)):
    bpy.ops.mesh.primitive_cube_add(size=2, location=(x, 0, 0), rotation=(0.1, 0.2, 0.3))
    item = bpy.context.object
    item.name = f"Rock_{x}"
    item.scale = scale
    bpy.context.view_layer.update()
    return item


rock(0).location = (1, 2, 3)
rock(10).location.x = 11
rock(20).location[1] = 4
rock(30).location.yz = (3, 2)
rock(40).location[:2] = (41, 5)
moved = rock(50).location
moved += Vector((1, 2, 3))
moved.z -= 1
rock(60).rotation_euler = (0, 0, 1)
rock(70).rotation_euler.z = math.pi / 3
rock(80).rotation_euler[0] += 0.5
turned = rock(90).rotation_euler
turned.rotate_axis("Z", 0.4)
rock(100).scale = (1, 2, 3)
rock(110).scale.y = 3
rock(120).scale *= 2
rock(130).scale[2] *= 4
rock(140).dimensions = (5, 4, 3)
rock(150).dimensions.x = 6
rock(160).dimensions[1] = 7
rock(170).dimensions.xz = (3, 3)
for x in (180, 190, 200, 210, 220):
    item = rock(x)
    item.rotation_mode = "QUATERNION"
    if x == 180:
        item.rotation_quaternion = Quaternion((0, 0, 1), 0.7)
    elif x == 190:
        item.rotation_quaternion.w = 0.5
        item.rotation_quaternion.z = 0.5
    elif x == 200:
        item.rotation_quaternion[1] = 0.8
    elif x == 210:
        item.rotation_euler = (1, 1, 1)
    else:
        item.rotation_quaternion = (1, 0, 0, 0)
        item.rotation_mode = "XYZ"
        item.rotation_euler.x = 0.5
rock(230).matrix_world = Matrix.Translation((230, 3, 0)) @ Matrix.Rotation(0.5, 4, "Z")
rock(240).matrix_world.translation = (241, 1, 1)
rock(250).matrix_world.translation.y = 6
rock(260).matrix_world[2][3] = 5
rock(270, (1, 1, 1)).matrix_world @= Matrix.Rotation(0.3, 4, "X")
rock(280).rotation_euler = Euler((0.3, 0, 0)).to_quaternion().to_euler()
for x in (290, 300, 310):
    parent, child = rock(x, (2, 2, 2)), rock(x + 5)
    child.parent = parent
    if x == 290:
        child.matrix_parent_inverse = parent.matrix_world.inverted()
    elif x == 300:
        child.location.x = 4
    else:
        child.matrix_world = Matrix.Translation((x, 5, 5))
