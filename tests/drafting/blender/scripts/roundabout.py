import math

import bpy

# Remove the default cube
if "Cube" in bpy.data.objects:
    bpy.data.objects["Cube"].select_set(True)
    bpy.ops.object.delete()
for name in ["Camera", "Light"]:
    obj = bpy.data.objects.get(name)
    if obj:
        bpy.data.objects.remove(obj)


def roundabout(radius=12.0, segments=32):
    verts, faces = [], []
    for i in range(segments):
        a = 2 * math.pi * i / segments
        verts += [(25 + r * math.cos(a), r * math.sin(a), 0.0) for r in (radius - 3.5, radius + 3.5)]
    for i in range(segments):
        j = (i + 1) % segments
        faces.append([2 * i, 2 * i + 1, 2 * j + 1, 2 * j])
    me = bpy.data.meshes.new("RoundaboutRoad")
    me.from_pydata(verts, [], faces)
    me.validate()
    me.update(calc_edges=True)
    ob = bpy.data.objects.new("RoundaboutRoad", me)
    bpy.context.collection.objects.link(ob)


roundabout()
n = 5
for k in range(n):
    ang = k / n * math.tau
    loc = (25 + 13.5 * math.cos(ang), 13.5 * math.sin(ang), 0.75)
    bpy.ops.mesh.primitive_cube_add(size=1, location=loc, rotation=(0, 0, ang + math.pi / 2))
    bpy.context.object.name = f"Car_{k + 1:02}"
    bpy.ops.transform.resize(value=(4.4, 1.8, 1.5))
bpy.ops.mesh.primitive_cylinder_add(radius=6, depth=0.4, location=(25, 0, 0.2))
bpy.context.object.name = "Grass_island"
bpy.ops.mesh.primitive_uv_sphere_add(radius=2, location=(25, 0, 4))
bush = bpy.context.object
bush.name = "Bush"
bush.scale[2] *= 0.8
bpy.context.scene.frame_end = 120
bush.keyframe_insert(data_path="location", frame=1)
