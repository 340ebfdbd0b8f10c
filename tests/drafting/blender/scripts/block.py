"""A block as another language model writes it: types, collections, node trees, a camera that looks at the middle."""

from __future__ import annotations

from typing import Optional

import bpy
from mathutils import Vector

CONFIG = {"road": {"length": 100, "width": 7.0}, "cars": [{"x": 12.0, "lane": 0}, {"x": -9, "lane": 1}]}


def clear_scene() -> None:
    if bpy.context.object and bpy.context.mode == "EDIT_MESH":
        bpy.ops.object.mode_set(mode="OBJECT")
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj, do_unlink=True)
    for blocks in (bpy.data.meshes, bpy.data.materials, bpy.data.cameras, bpy.data.lights):
        for block in list(blocks):
            blocks.remove(block)


def collection(name: str):
    if name in bpy.data.collections:
        return bpy.data.collections[name]
    made = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(made)
    return made


def material(name: str, rgba: tuple[float, float, float, float]):
    made = bpy.data.materials.get(name)
    if made is None:
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        nodes = made.node_tree.nodes
        nodes.clear()
        shader = nodes.new(type="ShaderNodeBsdfPrincipled")
        output = nodes.new(type="ShaderNodeOutputMaterial")
        made.node_tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
        shader.inputs["Base Color"].default_value = rgba
    made.diffuse_color = rgba
    return made


def add_box(name: str, size, location, turn: float = 0.0, look=None, into: Optional[object] = None):  # noqa: UP045
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=location, rotation=(0, 0, turn))
    obj = bpy.context.active_object
    obj.name = name
    obj.data.name = f"{name}_mesh"
    obj.scale = size
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    if look is not None:
        if len(obj.data.materials) == 0:
            obj.data.materials.append(look)
        else:
            obj.data.materials[0] = look
    if into:
        for other in list(obj.users_collection):
            other.objects.unlink(obj)
        into.objects.link(obj)
    return obj


def main():
    clear_scene()
    vehicles, surroundings = collection("Vehicles"), collection("Environment")
    road = CONFIG["road"]
    asphalt = material("Asphalt", (0.1, 0.1, 0.1, 1))
    add_box("Road", (road["length"], road["width"], 0.1), (0, 0, -0.05), look=asphalt, into=surroundings)
    for i, spec in enumerate(CONFIG["cars"], start=1):
        y = (-1) ** spec["lane"] * 1.75
        body = add_box(f"Car_{i}_body", (4.4, 1.8, 0.8), (spec["x"], y, 0.7), into=vehicles)
        cabin = add_box(f"Car_{i}_cabin", (2.2, 1.6, 0.6), (spec["x"] - 0.3, y, 1.4), into=vehicles)
        bpy.context.view_layer.update()
        cabin.parent = body
        cabin.matrix_parent_inverse = body.matrix_world.inverted()
    for side in (1, -1):
        for k in range(5):
            x = -40 + 20 * k
            bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.2, depth=2, location=(x, side * 6, 1))
            bpy.context.object.name = f"Tree_{k}_trunk"
            bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=1.4, location=(x, side * 6, 3))
            bpy.context.object.name = f"Tree_{k}_leaves"
            bpy.ops.object.shade_smooth()
    for number, (toward, axes) in enumerate(
        [((1, 2, 3), ("-Z", "Y")), ((0.3, -1, 0.2), ("X", "Z")), ((-1, -1, -2), ("Y", "Z"))]
    ):
        bpy.ops.mesh.primitive_cone_add(radius1=0.4, depth=1, vertices=5, location=(10 + 5 * number, 10, 1))
        bpy.context.object.name = f"Traffic_Cone_{number}"
        bpy.context.object.rotation_euler = Vector(toward).to_track_quat(*axes).to_euler()
    try:
        bpy.context.scene.render.resolution_x = 640
    except AttributeError:
        print("an older Blender")
    camera = bpy.data.objects.new("Cam", bpy.data.cameras.new("Cam"))
    bpy.context.collection.objects.link(camera)
    camera.location = (0, -30, 25)
    camera.rotation_euler = (Vector((0, 0, 0)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = camera


if __name__ == "__main__":
    main()
