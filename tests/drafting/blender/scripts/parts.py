"""Objects of several parts: parents, empties, collections of their own, names with numbers."""

from math import pi

import bpy
from mathutils import Euler, Vector

bpy.ops.wm.read_factory_settings(use_empty=True)
traffic = bpy.data.collections.new("Traffic")
bpy.context.scene.collection.children.link(traffic)


def move_to(obj, collection):
    for other in obj.users_collection:
        other.objects.unlink(obj)
    collection.objects.link(obj)


def bus(number, position, heading):
    root = bpy.data.objects.new(f"Bus_{number}", None)
    traffic.objects.link(root)
    root.location = position
    root.rotation_euler = Euler((0, 0, heading))
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0, 0, 1.7))
    body = bpy.context.object
    body.name = f"Bus_{number}_Body"
    body.scale = (12, 2.5, 3)
    body.parent = root
    move_to(body, traffic)
    for x in (-4, 4):
        for y in (-1.2, 1.2):
            bpy.ops.mesh.primitive_cylinder_add(radius=0.5, depth=0.3, location=(x, y, 0.5), rotation=(pi / 2, 0, 0))
            wheel = bpy.context.active_object
            wheel.name = f"Bus_{number}_Wheel"
            wheel.parent = root
            move_to(wheel, traffic)


bus(1, Vector((15, 3, 0)), 0.2)
bus(2, Vector((15, 3, 0)) + Vector((20, 2, 0)) * 1.5, pi)

bpy.ops.mesh.primitive_cylinder_add(radius=0.1, depth=5, location=(8, -6, 2.5))
pole = bpy.context.object
pole.name = "Street Lamp"
bpy.ops.mesh.primitive_cube_add(size=0.4, location=(9, -6, 5))
arm = bpy.context.object
arm.name = "Street Lamp.head"
arm.select_set(True)
pole.select_set(True)
bpy.context.view_layer.objects.active = pole
bpy.ops.object.parent_set(type="OBJECT", keep_transform=True)
pole.rotation_euler.z = 0.5

sign = pole.copy()
sign.data = pole.data.copy()
sign.name = "Sign_post"
sign.location.x += 20
bpy.context.collection.objects.link(sign)
