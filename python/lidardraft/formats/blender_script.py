"""A layout as a Blender Python script, a row a shape: Blender runs it, `layout_from_blender` reads the same layout."""

from __future__ import annotations

import json
import os

from lidardraft.files import written_whole
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import BY_NAME

_HEAD = '''"""A layout of semantic shapes. Run it in Blender, or read it: lidardraft draft --blender FILE.py

Metres and radians; x forward, y left, z up; the ego vehicle stands at the origin. Each call of `add` is one shape: its
name, class, number, center, full extents and yaw.
"""

import bpy

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
bpy.context.scene["lidardraft"] = {travelling}
COLOURS = {{
{colours}
}}
MATERIALS = {{}}
for label, colour in COLOURS.items():
    MATERIALS[label] = bpy.data.materials.new(label)
    MATERIALS[label].diffuse_color = colour


def unit_mesh():
    mesh = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    return mesh


MESHES = {{}}
bpy.ops.mesh.primitive_cube_add(size=1)
MESHES["box"] = unit_mesh()
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5)
MESHES["ellipsoid"] = unit_mesh()
bpy.ops.mesh.primitive_cylinder_add(radius=0.5, depth=1)
MESHES["cylinder"] = unit_mesh()
bpy.ops.mesh.primitive_plane_add(size=1)
MESHES["plane"] = unit_mesh()


def triangles(vertices, faces):
    xyz, abc = list(map(float, vertices.split())), list(map(int, faces.split()))
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(list(zip(xyz[0::3], xyz[1::3], xyz[2::3])), [], list(zip(abc[0::3], abc[1::3], abc[2::3])))
    return mesh


def add(mesh, name, label, instance, center, size, yaw, properties={{}}):
    if mesh in MESHES:
        mesh = MESHES[mesh].copy()
    mesh.materials.append(MATERIALS[label])
    item = bpy.data.objects.new(name, mesh)
    item.location, item.scale, item.rotation_euler = center, (size[0], size[1], size[2] or 1), (0, 0, yaw)
    item["id"], item["class"], item["instance"] = name, label, instance
    for key, value in properties.items():
        item[key] = value
    bpy.context.collection.objects.link(item)


'''


def blender_script(layout: Layout) -> str:
    """The text of the script."""
    labels = dict.fromkeys(primitive.label for primitive in layout)
    colours = [
        f"    {label!r}: {(*(round(part / 255, 3) for part in BY_NAME[label].colour), 1.0)}," for label in labels
    ]
    travelling = json.dumps({"provenance": layout.provenance, "coverage": layout.coverage})
    head = _HEAD.format(colours="\n".join(colours), travelling=repr(travelling))
    return head + "".join(_row(primitive) for primitive in layout)


def write_blender_script(path: str | os.PathLike[str], layout: Layout) -> None:
    """Write the script of `blender_script`."""
    with written_whole(path) as temporary:
        temporary.write_text(blender_script(layout), encoding="utf-8")


def _row(primitive: Primitive) -> str:
    mesh = primitive.mesh
    properties = {name: value for name in ("material", "extinction") if (value := getattr(primitive, name)) is not None}
    shape = repr(primitive.shape)
    if mesh is not None:
        vertices = " ".join(map(repr, mesh.vertices.ravel().tolist()))
        shape = f'triangles("{vertices}", "{" ".join(map(str, mesh.faces.ravel().tolist()))}")'
        properties["unit_box"] = True  # read back as it is, in the box that `size` is of
    fields = [shape, repr(primitive.id), repr(primitive.label), repr(primitive.instance)]
    fields += [
        repr(primitive.center),
        repr(primitive.size),
        repr(primitive.yaw),
        *([repr(properties)] if properties else []),
    ]
    return f"add({', '.join(fields)})\n"
