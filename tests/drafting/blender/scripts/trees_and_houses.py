import random

import bmesh
import bpy
from mathutils import Vector

random.seed(7)
bpy.ops.wm.read_factory_settings(use_empty=True)


def create_tree(location, height=5.0, radius=1.8):
    """Create tree with trunk (cylinder) and crown (ico sphere)."""
    x, y, z = location
    trunk_h = height * 0.4
    bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.2, depth=trunk_h, location=(x, y, z + trunk_h / 2))
    trunk = bpy.context.active_object
    trunk.name = "Tree_Trunk"
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=radius, location=(x, y, z + trunk_h + radius * 0.8))
    crown = bpy.context.active_object
    crown.name = "Tree_Crown"
    crown.parent = trunk
    crown.matrix_parent_inverse = trunk.matrix_world.inverted()
    return trunk, crown


def create_building(name, w, d, h, loc):
    mesh = bpy.data.meshes.new(name)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    bm = bmesh.new()
    bmesh.ops.create_cube(bm, size=1.0)
    bmesh.ops.scale(bm, vec=Vector((w, d, h)), verts=bm.verts)
    bmesh.ops.translate(bm, vec=(0, 0, h / 2), verts=bm.verts)
    bm.to_mesh(mesh)
    bm.free()
    obj.location = loc
    return obj


for i in range(6):
    create_tree((5 + 6 * i, 7, 0), height=random.uniform(4, 7))
create_building("Building_A", 12, 10, 18, (15, 18, 0))
create_building("Building_B", 14, 9, 11, (32, 18, 0))
bpy.ops.mesh.primitive_plane_add(size=60, location=(20, 0, 0))
bpy.context.active_object.name = "Ground"
