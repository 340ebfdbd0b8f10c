import math
import random

import bpy
from mathutils import Matrix, Vector

random.seed(5)

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()


# Bicycle: two tori and a frame
def add_bicycle(origin, heading):
    empty = bpy.data.objects.new("Bicycle_1", None)
    bpy.context.collection.objects.link(empty)
    empty.location = origin
    empty.rotation_euler = (0, 0, heading)
    for k, dx in enumerate((-0.5, 0.5)):
        bpy.ops.mesh.primitive_torus_add(
            location=(dx, 0, 0.35), rotation=(math.pi / 2, 0, 0), major_radius=0.33, minor_radius=0.03
        )
        w = bpy.context.object
        w.name = f"Bicycle_1_Wheel{k}"
        w.parent = empty
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.7))
    f = bpy.context.object
    f.name = "Bicycle_1_Frame"
    f.dimensions = (1.0, 0.05, 0.5)
    f.parent = empty


add_bicycle(Vector((7, -3, 0)), math.radians(20))

# Traffic sign
bpy.ops.mesh.primitive_cylinder_add(vertices=16, radius=0.04, depth=2.2, location=(10, -4.5, 1.1))
bpy.context.object.name = "SignPole"
bpy.ops.mesh.primitive_cylinder_add(
    vertices=24, radius=0.35, depth=0.03, location=(10, -4.5, 2.3), rotation=(0, math.pi / 2, 0)
)
bpy.context.object.name = "TrafficSign"
# wall by matrix
wall_mesh = bpy.data.meshes.new("Wall")
wall_mesh.from_pydata([(0, 0, 0), (10, 0, 0), (10, 0, 2), (0, 0, 2)], [], [(0, 1, 2, 3)])
wall = bpy.data.objects.new("Wall", wall_mesh)
wall.matrix_world = Matrix.Translation((5, -8, 0)) @ Matrix.Rotation(math.radians(5), 4, "Z")
bpy.context.scene.collection.objects.link(wall)
sol = wall.modifiers.new("Solidify", "SOLIDIFY")
sol.thickness = 0.3
