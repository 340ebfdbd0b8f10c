"""What operators do to selected objects: moving, scaling, turning, copying, joining, applying."""

import bpy

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()

bpy.ops.mesh.primitive_cube_add(size=1, location=(10, 2, 1))
bpy.context.object.name = "Van"
bpy.ops.transform.resize(value=(5, 2, 2))
bpy.ops.transform.translate(value=(1, 1, 0))
bpy.ops.transform.rotate(value=0.3, orient_axis="Z")

bpy.ops.object.duplicate()
bpy.context.object.name = "Truck"
bpy.context.object.location.x += 15
bpy.context.object.scale *= 1.5

bpy.ops.mesh.primitive_uv_sphere_add(radius=1.5, location=(5, -8, 3), rotation=(0, 0, 0.5))
bush = bpy.context.object
bush.name = "Bush"
bush.scale = (1, 0.6, 0.8)
bpy.ops.object.transform_apply(location=False, rotation=True, scale=True)
bush.scale.z = 2
bpy.ops.object.modifier_add(type="SUBSURF")

bpy.ops.mesh.primitive_cube_add(size=1, location=(20, -8, 1.5), scale=(6, 0.2, 3))
wall = bpy.context.object
wall.name = "Wall"
bpy.ops.mesh.primitive_cube_add(size=1, location=(20, -8, 3.2), scale=(6.4, 0.5, 0.4))
cap = bpy.context.object
bpy.ops.object.select_all(action="DESELECT")
wall.select_set(True)
cap.select_set(True)
bpy.context.view_layer.objects.active = wall
bpy.ops.object.join()
wall.rotation_euler = (0, 0, 1.0)

for obj in list(bpy.context.scene.objects):
    if obj.name.startswith("Tru"):
        copy = obj.copy()
        copy.location = obj.location + obj.location.normalized() * 20
        bpy.context.collection.objects.link(copy)
