"""Run by a Python that has `bpy`: carries out a script in Blender, and prints the world bounds of every mesh object."""

import json
import sys

import bpy
from mathutils import Vector

bpy.ops.wm.read_factory_settings(use_empty=True)
with open(sys.argv[1], encoding="utf-8") as file:
    exec(compile(file.read(), sys.argv[1], "exec"), {"__name__": "__main__"})
bpy.context.view_layer.update()
bounds = {}
for item in bpy.context.scene.objects:
    if item.type == "MESH" and len(item.data.polygons):
        corners = [item.matrix_world @ vertex.co for vertex in item.data.vertices]
        low, high = (Vector(map(choose, zip(*corners, strict=True))) for choose in (min, max))
        bounds[item.name] = [list(low), list(high)]
print("BOUNDS" + json.dumps(bounds))
