"""Meshes from lists of vertices, and operators of other shapes, leaning ones too."""

import bpy

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()


def prism(name, width, length, eaves, ridge):
    w, d = width / 2, length / 2
    vertices = [(-d, -w, 0), (d, -w, 0), (d, w, 0), (-d, w, 0)]
    vertices += [(x, y, eaves) for x, y, _ in vertices] + [(-d, 0, ridge), (d, 0, ridge)]
    faces = [(0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 9, 5), (3, 0, 4, 8, 7), (4, 5, 9, 8), (6, 7, 8, 9), (3, 2, 1, 0)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.update()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    return obj


house = prism("House", 8, 12, 5, 8)
house.location = (20, 12, 0)
house.rotation_euler = (0, 0, 0.4)
mirrored = prism("House", 8, 12, 5, 8)
mirrored.location = (20, -12, 0)
mirrored.scale = (1, -1.2, 1)

bpy.ops.mesh.primitive_cone_add(vertices=16, radius1=0.3, radius2=0.05, depth=0.8, location=(6, -3, 0.4))
bpy.context.object.name = "Traffic_Cone"
bpy.ops.mesh.primitive_cone_add(radius1=1.6, depth=5, location=(9, 6, 3.5), scale=(1, 1, 1.2))
bpy.context.object.name = "Fir_Tree"
bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=1.2, location=(12, 6, 1), rotation=(0.3, 0, 0))
bpy.context.object.name = "Bush"
bpy.ops.mesh.primitive_torus_add(major_radius=1.5, minor_radius=0.4, location=(14, -8, 0.4), rotation=(0.2, 0.1, 0))
bpy.context.object.name = "Hedge_ring"
bpy.ops.mesh.primitive_circle_add(vertices=24, radius=6, fill_type="NGON", location=(30, 0, 0.01))
bpy.context.object.name = "Roundabout"
bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4, size=30, location=(10, 0, -0.01))
bpy.context.object.name = "Grass"
bpy.ops.mesh.primitive_cylinder_add(vertices=6, radius=0.4, depth=1, location=(4, 4, 0.5))
bpy.context.object.name = "Bollard"
bpy.ops.mesh.primitive_cylinder_add(radius=0.3, depth=4, location=(16, 7, 0.3), rotation=(0, 1.5707963267948966, 0.6))
bpy.context.object.name = "Trunk_lying"
bpy.ops.mesh.primitive_cube_add(size=2, location=(5, 8, 1), rotation=(0.3, 0.2, 0.1), scale=(1, 0.5, 0.7))
bpy.context.object.name = "Rock"
bpy.ops.mesh.primitive_plane_add(size=3, location=(9, 0, 2), rotation=(0, 1.2, 0.3))
bpy.context.object.name = "Billboard_sign"
