"""A layout as a Blender Python script, one row a shape. Blender runs it; `layout_from_blender` reads the same
layout."""

from __future__ import annotations

import json
import os

from lidardraft.files import written_whole
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import BY_NAME

_SCRIPT = '''"""A layout of semantic shapes. Run it in Blender, or read it: lidardraft draft --blender FILE.py

Metres and radians; x forward, y left, z up; the ego vehicle stands at the origin. Each line of ROWS is one shape: its
mesh and instance, center (3), full extents (3; 1 for the height of a plane), angles (3), and name.
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
        mesh = MESHES[shape + ":" + label] = unit.copy()
        mesh["class"] = label
        mesh.materials.append(MATERIALS[label])


def triangles(name, label, vertices, faces):
    xyz, abc = list(map(float, vertices.split())), list(map(int, faces.split()))
    mesh = MESHES[name] = bpy.data.meshes.new("mesh")
    mesh.from_pydata(list(zip(xyz[0::3], xyz[1::3], xyz[2::3])), [], list(zip(abc[0::3], abc[1::3], abc[2::3])))
    mesh["class"] = label
    mesh.materials.append(MATERIALS[label])


{own_meshes}ROWS = """
{rows}"""
cells = ROWS.split({bar})
kinds, names = " ".join(cells[0::5]).split(), cells[4::5]
layout = bpy.data.collections.new("Layout")
bpy.context.scene.collection.children.link(layout)
new, link = bpy.data.objects.new, layout.objects.link
for kind, instance, name in zip(kinds[0::2], map(int, kinds[1::2]), names):
    item = new(name, MESHES[kind])
    item["id"], item["instance"] = name, instance
    link(item)
for numbers, what in enumerate(("location", "scale", "rotation_euler"), 1):
    layout.objects.foreach_set(what, list(map(float, " ".join(cells[numbers::5]).split())))
objects = list(layout.objects)
for row, properties in {properties}.items():
    for key, value in properties.items():
        objects[row][key] = value
'''


def blender_script(layout: Layout) -> str:
    """The text of the script."""
    labels = dict.fromkeys(primitive.label for primitive in layout)
    colours = [
        f"    {label!r}: {(*(round(part / 255, 3) for part in BY_NAME[label].colour), 1.0)}," for label in labels
    ]
    travelling = json.dumps(layout.head())
    bar = _bar_between([primitive.id for primitive in layout])
    kinds = [f"{each.shape}:{each.label if each.mesh is None else row}" for row, each in enumerate(layout)]
    own = [_own_mesh(kind, each) for kind, each in zip(kinds, layout, strict=True) if each.mesh is not None]
    properties = [f"{row}: {found!r}" for row, each in enumerate(layout) if (found := _properties(each))]
    return _SCRIPT.format(
        colours="\n".join(colours),
        travelling=repr(travelling),
        own_meshes="".join(f"{line}\n" for line in own),
        properties="{\n" + "".join(f"    {line},\n" for line in properties) + "}" if properties else "{}",
        rows="".join(_row(kind, each, bar) for kind, each in zip(kinds, layout, strict=True)),
        bar=repr(bar),
    )


def write_blender_script(path: str | os.PathLike[str], layout: Layout) -> None:
    """Write the script of `blender_script`."""
    with written_whole(path) as temporary:
        temporary.write_text(blender_script(layout), encoding="utf-8")


def _bar_between(names: list[str]) -> str:
    """A separator for the cells of a row: a character that occurs in no name."""
    taken = set().union(*names)
    return next(bar for bar in ("|", *map(chr, range(0x2502, 0x110000))) if bar not in taken)


def _row(kind: str, primitive: Primitive, bar: str) -> str:
    length, width, height = primitive.size
    extents = (length, width, 1.0 if primitive.shape == "plane" else height)
    numbers = (" ".join(map(repr, map(float, part))) for part in (primitive.center, extents, (0, 0, primitive.yaw)))
    return _in_quotes(bar.join([f"{kind} {primitive.instance}", *numbers, primitive.id, "\n"]))


def _in_quotes(text: str) -> str:
    """A text escaped for triple quotes."""
    return "".join(
        letter if letter == "\n" or (letter.isprintable() and letter not in '\\"') else f"\\U{ord(letter):08x}"
        for letter in text
    )


def _own_mesh(kind: str, primitive: Primitive) -> str:
    assert primitive.mesh is not None
    vertices = " ".join(map(repr, primitive.mesh.vertices.ravel().tolist()))
    faces = " ".join(map(str, primitive.mesh.faces.ravel().tolist()))
    return f'triangles("{kind}", {primitive.label!r}, "{vertices}", "{faces}")'


def _properties(primitive: Primitive) -> dict[str, object]:
    found = primitive.more()
    return found | {"unit_box": True} if primitive.mesh is not None else found  # read back in the box of `size`
