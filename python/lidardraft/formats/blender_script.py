"""A layout as a Blender Python script, a row a shape: Blender runs it, `layout_from_blender` reads the same layout."""

from __future__ import annotations

import json
import os

from lidardraft.files import written_whole
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import BY_NAME

_SCRIPT = '''"""A layout of semantic shapes. Run it in Blender, or read it: lidardraft draft --blender FILE.py

Metres and radians; x forward, y left, z up; the ego vehicle stands at the origin. Each of ROWS is one shape: its kind,
class and number, center (3), full extents (3), yaw, and name.
"""

import bpy

bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
bpy.context.scene["lidardraft"] = {travelling}
COLOURS = {{
{colours}
}}


def unit_mesh():
    mesh = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    return mesh


UNITS = {{}}
bpy.ops.mesh.primitive_cube_add(size=1)
UNITS["box"] = unit_mesh()
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5)
UNITS["ellipsoid"] = unit_mesh()
bpy.ops.mesh.primitive_cylinder_add(radius=0.5, depth=1)
UNITS["cylinder"] = unit_mesh()
bpy.ops.mesh.primitive_plane_add(size=1)
UNITS["plane"] = unit_mesh()
MESHES, MATERIALS = {{}}, {{}}
for label, colour in COLOURS.items():
    MATERIALS[label] = bpy.data.materials.new(label)
    MATERIALS[label].diffuse_color = colour
    for shape, unit in UNITS.items():
        MESHES[shape + " " + label] = unit.copy()
        MESHES[shape + " " + label].materials.append(MATERIALS[label])


def triangles(label, vertices, faces):
    xyz, abc = list(map(float, vertices.split())), list(map(int, faces.split()))
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(list(zip(xyz[0::3], xyz[1::3], xyz[2::3])), [], list(zip(abc[0::3], abc[1::3], abc[2::3])))
    mesh.materials.append(MATERIALS[label])
    return mesh


OF_ITS_OWN = {own_meshes}
PROPERTIES = {properties}
ROWS = {rows}
for row in ROWS:
    shape, label, instance, *numbers, name = row.split(" ", 10)
    x, y, z, length, width, height, yaw = map(float, numbers)
    item = bpy.data.objects.new(name, OF_ITS_OWN[name] if shape == "mesh" else MESHES[shape + " " + label])
    item.location, item.scale, item.rotation_euler = (x, y, z), (length, width, height or 1), (0, 0, yaw)
    item["id"], item["class"], item["instance"] = name, label, int(instance)
    bpy.context.collection.objects.link(item)
    if name in PROPERTIES:
        for key, value in PROPERTIES[name].items():
            item[key] = value
'''


def blender_script(layout: Layout) -> str:
    """The text of the script."""
    labels = dict.fromkeys(primitive.label for primitive in layout)
    colours = [
        f"    {label!r}: {(*(round(part / 255, 3) for part in BY_NAME[label].colour), 1.0)}," for label in labels
    ]
    travelling = json.dumps({"provenance": layout.provenance, "coverage": layout.coverage})
    return _SCRIPT.format(
        colours="\n".join(colours),
        travelling=repr(travelling),
        own_meshes=_written("{}", [_own_mesh(each) for each in layout if each.mesh is not None]),
        properties=_written("{}", [f"{each.id!r}: {found!r}" for each in layout if (found := _properties(each))]),
        rows=_written("[]", [repr(_row(each)) for each in layout]),
    )


def write_blender_script(path: str | os.PathLike[str], layout: Layout) -> None:
    """Write the script of `blender_script`."""
    with written_whole(path) as temporary:
        temporary.write_text(blender_script(layout), encoding="utf-8")


def _written(brackets: str, parts: list[str]) -> str:
    """The parts of a list or a dict, a line each."""
    lines = "".join(f"    {part},\n" for part in parts)
    return f"{brackets[0]}\n{lines}{brackets[1]}"


def _row(primitive: Primitive) -> str:
    numbers = (repr(float(number)) for number in (*primitive.center, *primitive.size, primitive.yaw))
    return " ".join([primitive.shape, primitive.label, str(primitive.instance), *numbers, primitive.id])


def _own_mesh(primitive: Primitive) -> str:
    assert primitive.mesh is not None
    vertices = " ".join(map(repr, primitive.mesh.vertices.ravel().tolist()))
    faces = " ".join(map(str, primitive.mesh.faces.ravel().tolist()))
    return f'{primitive.id!r}: triangles({primitive.label!r}, "{vertices}", "{faces}")'


def _properties(primitive: Primitive) -> dict[str, object]:
    found = {name: value for name in ("material", "extinction") if (value := getattr(primitive, name)) is not None}
    return found | {"unit_box": True} if primitive.mesh is not None else found  # read back in the box that `size` is of
