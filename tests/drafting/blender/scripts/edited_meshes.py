import bmesh
import bpy
from mathutils import Vector


def cursor(loc):
    bpy.context.scene.cursor.location = loc


cursor((0, 0, 0))
bpy.ops.mesh.primitive_cube_add(size=1)
house = bpy.context.active_object
house.name = "House_1"
bpy.ops.object.mode_set(mode="EDIT")
bm = bmesh.from_edit_mesh(house.data)
for v in bm.verts:
    v.co.x *= 10
    v.co.y *= 8
    v.co.z = (v.co.z + 0.5) * 6
bmesh.update_edit_mesh(house.data)
bpy.ops.object.mode_set(mode="OBJECT")
house.location = Vector((15, 14, 0))

# Gabled roof
roof_mesh = bpy.data.meshes.new("Roof")
bm = bmesh.new()
pts = [(-5, -4, 0), (5, -4, 0), (5, 4, 0), (-5, 4, 0), (-5, 0, 3), (5, 0, 3)]
vs = [bm.verts.new(Vector(p)) for p in pts]
bm.verts.ensure_lookup_table()
for f in [(0, 1, 5, 4), (1, 2, 5), (2, 3, 4, 5), (3, 0, 4), (0, 3, 2, 1)]:
    bm.faces.new([bm.verts[i] for i in f])
bmesh.ops.recalc_face_normals(bm, faces=bm.faces)
bm.to_mesh(roof_mesh)
bm.free()
roof = bpy.data.objects.new("House_1_Roof", roof_mesh)
bpy.context.collection.objects.link(roof)
roof.parent = house
roof.location = (0, 0, 6)

# duplicates with linked data
for k in range(1, 4):
    for src in (house, roof):
        dup = src.copy()
        if src is house:
            dup.location.x += 14 * k
            dup.name = f"House_{k + 1}"
            last = dup
        else:
            dup.parent = last
            dup.name = f"House_{k + 1}_Roof"
        bpy.context.scene.collection.objects.link(dup)
