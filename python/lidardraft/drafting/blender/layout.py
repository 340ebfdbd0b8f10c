"""A layout from a Blender Python script. The script is read as data, through its syntax tree; it is never run."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import json
import math
import os
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.drafting.blender.bpy.bmesh import bmesh_module
from lidardraft.drafting.blender.bpy.mathutils import Vector, mathutils_module
from lidardraft.drafting.blender.bpy.meshes import Mesh, MeshShape
from lidardraft.drafting.blender.bpy.objects import SceneObject
from lidardraft.drafting.blender.bpy.operators import Operators
from lidardraft.drafting.blender.bpy.scene import Scene
from lidardraft.drafting.blender.script.limits import RefusalError, Script, ScriptLimits
from lidardraft.drafting.blender.script.modules import modules
from lidardraft.drafting.blender.script.reading import read
from lidardraft.drafting.blender.script.values import Namespace
from lidardraft.drafting.plausible import settled
from lidardraft.drafting.things import Node, Things
from lidardraft.errors import FormatError, LayoutError, ScriptError, check_type
from lidardraft.files import named, read_bytes, regular_size
from lidardraft.scene.box import THINNEST
from lidardraft.scene.class_names import check_classes, class_of, without_number, words_of
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.placed_mesh import in_unit_box, placed_mesh
from lidardraft.scene.pose import point_at
from lidardraft.semantics import BY_NAME

_Placing = Callable[..., Layout]  # `settled` with the options of placing
_DEFAULT_LIMITS = ScriptLimits()
HEAD = "lidardraft"  # the property of the scene with all of a layout except its primitives
_MOST_NAMES = 50  # in one message
_DEEPEST = 100  # parents of an object
_REMEDY = "say which by --class NAME=CLASS (`classes` in Python)"


def layout_from_blender(
    script: str | os.PathLike[str],
    *,
    classes: Mapping[str, str] | None = None,
    strict: bool = False,
    limits: ScriptLimits = _DEFAULT_LIMITS,
    scale: float = 1.0,
    recentre: bool = False,
    as_is: bool = False,
) -> Layout:
    """The layout of a Blender Python script's scene; `script` is its text, or the path of its file, NAME.py.

    Blender's frame becomes the layout's: x forward, y left, z up, the ego vehicle at the origin. The scene starts
    empty. `classes` maps names of objects, materials or collections to classes; without an entry, a name itself tells
    the class ("Car.001", "mat_building"). An object without a class becomes "other", with a note. Upright cubes,
    spheres, cylinders and planes become the layout's own shapes, all else meshes. Numbers of `random` are those of
    Python's generator for the script's seed, or for 0. If a text is no Python but has Markdown fences, the longest
    block between them is read. `scale`, `recentre` and `as_is` are as in `layout_from_glb`.

    `layout.notes` list ignored parts, on which no shape depends. Raises `ScriptError` naming the line of an unsupported
    part or one beyond `limits`. Raises `LayoutError` for a thing in another unit and, if `strict`, listing the names
    without a class.
    """
    check_type("script", script, str, os.PathLike)
    place = partial(settled, scale=scale, recentre=recentre, as_is=as_is)
    if isinstance(script, str) and ("\n" in script or not script.endswith(".py")):
        return _layout(script, classes or {}, strict, limits, {"source": "blender"}, place)
    if (size := regular_size(script)) > 4 * limits.file:
        raise FormatError(f"{os.fspath(script)} has {size} bytes; scripts of up to {4 * limits.file} are read")
    with named(script):
        text = _decoded(read_bytes(script))
        return _layout(text, classes or {}, strict, limits, {"source": Path(script).name}, place)


def _decoded(data: bytes) -> str:
    """The text of a script, without a byte order mark."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ScriptError(f"line {line}: no text in UTF-8: byte {error.start} of the file is wrong") from None


def _layout(
    text: str, classes: Mapping[str, str], strict: bool, limits: ScriptLimits, source: dict[str, Any], place: _Placing
) -> Layout:
    check_classes(classes)
    script = Script(limits)
    scene = Scene(script)
    bpy = Namespace("bpy", {"ops": Operators(scene), **scene.modules()})
    script.modules = {**modules(script), "bmesh": bmesh_module(scene), "bpy": bpy, "mathutils": mathutils_module()}
    try:
        with np.errstate(all="ignore"):  # numbers that are not finite are refused on use
            read(text, script)
            scene.leave_edit_mode()
            primitives = primitives_of(scene, classes, strict=strict)
    except RefusalError as refusal:
        raise ScriptError(f"line {refusal.line or script.line}: {refusal}") from None
    notes = [f"line {line}: {note}" for note, line in script.notes.items()]
    if not primitives:
        raise ScriptError("; ".join([f"line {script.line}: the script has made no object with a surface", *notes[:3]]))
    if HEAD in scene.current.properties:
        return place(Layout.with_head(primitives, _head_in(scene.current.properties[HEAD])), is_ours=True)
    digest = hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()
    layout = Layout(primitives=tuple(primitives), provenance={**source, "sha256": digest}, notes=tuple(notes))
    return place(layout)


def _head_in(value: Any) -> dict[str, Any]:
    """The head of a layout from its export as a script."""
    try:
        head: dict[str, Any] = json.loads(value)
        return head | {name: head[name] for name in ("provenance", "coverage")}
    except (TypeError, ValueError, KeyError, RecursionError):
        raise ScriptError(f"the property {HEAD!r} of the scene is not what an export writes") from None


def primitives_of(scene: Scene, classes: Mapping[str, str], *, strict: bool) -> list[Primitive]:
    """The primitives of all objects with a surface that are linked to the scene, in order of creation.

    An object without a class in its names is "other", with a note. Raises `LayoutError` listing these if `strict`, and
    `RefusalError` for too many vertices and for objects too far away or too large.
    """
    meshes = _meshes_of(scene)
    limit = scene.script.limits.vertices
    if (total := sum(shape.vertices for _, _, shape in meshes if shape.shape in ("mesh", "any"))) > limit:
        raise RefusalError(f"the scene has {total} vertices; the limit is {limit}", 1)
    found = [(item, mesh, shape, _class_of(item, classes)) for item, mesh, shape in meshes]
    nameless = {item.name: item.line for item, *_, label in found if label is None}
    if nameless and strict:
        names = ", ".join(f"{name:.60} (line {line})" for name, line in sorted(nameless.items())[:_MOST_NAMES])
        more = f" and {len(nameless) - _MOST_NAMES} more" if len(nameless) > _MOST_NAMES else ""
        raise LayoutError(f"no class for {names}{more}; {_REMEDY}")
    for name, line in nameless.items():
        scene.script.note(f"no class for {without_number(name):.60}: it becomes 'other'; {_REMEDY}", line)
    nodes = _nodes_of([(item, label) for item, *_, label in found])
    things = Things(nodes, classes, (item.properties.get("instance") for item, *_ in meshes))
    primitives = []
    for (item, mesh, shape, said), node in zip(found, nodes, strict=True):
        try:
            primitive = _placed_shape(item, mesh, shape, **things.fields_of(node, said or "other", item.properties))
        except LayoutError as error:
            raise RefusalError(f"{error!s:.300}", item.line) from None
        if primitive is None:
            scene.script.note(f"{item.name:.60} has no surface")
        else:
            primitives.append(primitive if _given_class(item) is not None else _lengthwise(primitive))
    return primitives


def _meshes_of(scene: Scene) -> list[tuple[SceneObject, Mesh, MeshShape]]:
    linked = set(scene.master.within())
    found = []
    for item in scene.objects.all():
        if "ego" in words_of(item.name):
            scene.script.note("the ego vehicle is left out: it carries the sensor")
        elif not linked.intersection(item.collections):
            scene.script.note(f"{item.name:.60} is not linked to the scene")
        elif isinstance(item.data, Mesh) and item.data.shape is None:
            scene.script.note(f"{item.name:.60} has no faces")
        elif isinstance(item.data, Mesh) and item.data.shape is not None:
            found += [(each, item.data, item.data.shape) for each in _copies(scene, item)]
    return found


def _copies(scene: Scene, item: SceneObject) -> list[SceneObject]:
    """An object and its copies by arrays, each as a separate object: a row of cars is many cars."""
    if not item.modifiers.arrays:
        return [item]
    found: list[SceneObject] = []
    try:
        offsets = item.modifiers.offsets(item.extents())
    except RefusalError as refusal:
        raise refusal.at(item.line) from None
    for number, offset in enumerate(offsets):
        if len(found) >= scene.script.limits.objects:
            raise RefusalError(f"more than {scene.script.limits.objects} objects", item.line)
        other = copy.copy(item)
        scene.script.take_made(item.properties)
        if number:  # a separate object has its own id and instance
            other.suffix = f"_array{number:03}"
            other.properties = {name: value for name, value in item.properties.items() if name != "instance"}
            if isinstance(given := other.properties.get("id"), str):
                scene.script.take_text(len(given))
                other.properties["id"] = given + other.suffix
        other.location = Vector((item.local() @ [*offset, 1.0])[:3].tolist() if number else item.location.numbers)
        found.append(other)
    return found


def _given_class(item: SceneObject) -> Any:
    """The property `class` of the object, or else of its mesh."""
    of_mesh = item.data.properties.get("class") if isinstance(item.data, Mesh) else None
    return item.properties.get("class", of_mesh)


def _class_of(item: SceneObject, classes: Mapping[str, str]) -> str | None:
    given = _given_class(item)
    if isinstance(given, str) or not isinstance(item.data, Mesh):
        return given
    # The mesh comes last: most are named after their operator.
    return class_of(item.class_names(), classes) or class_of([item.data.name], classes)


def _nodes_of(items: list[tuple[SceneObject, str | None]]) -> list[Node]:
    """Nodes of objects with their classes, below nodes of their parents."""
    made: dict[SceneObject, Node] = {}
    for item, label in items:
        above = item.parents()
        if len(above) > _DEEPEST:
            raise RefusalError(f"{item.name:.60} is more than {_DEEPEST} parents deep", item.line)
        parent: Node | None = None
        for each in (*reversed(above), item):
            if each not in made:
                made[each] = Node(each.name, None, parent, partial(_place_of, each), each.suffix)
            parent = made[each]
        made[item].label = label
    return [made[item] for item, _ in items]


def _place_of(item: SceneObject) -> np.ndarray:
    return item.world()[:3, 3]


def _lengthwise(primitive: Primitive) -> Primitive:
    """A vehicle's box with its length along its yaw; a vehicle modelled along y has its width as the longer side."""
    length, width, height = primitive.size
    is_vehicle = BY_NAME[primitive.label].is_thing and primitive.label != "person"
    if primitive.shape != "box" or not is_vehicle or length >= width:
        return primitive
    yaw = math.remainder(primitive.yaw + math.pi / 2, math.pi)  # the front is unknown
    return dataclasses.replace(primitive, size=(width, length, height), yaw=yaw)


def _placed_shape(item: SceneObject, mesh: Mesh, shape: MeshShape, **fields: Any) -> Primitive | None:
    """The primitive of an object with `fields` (label, id, ...); None if it has no surface.

    An object that is only moved, scaled and turned about z keeps its numbers to the last digit. Raises `LayoutError`
    for objects too far away or too large.
    """
    turned_about_z = item.mode == "XYZ" and item.rotation.numbers[:2] == [0.0, 0.0]
    if turned_about_z and item.parent is None and min(item.scale.numbers) >= 0:
        exact = _placed_exactly(item, mesh, shape, **fields)
        if exact is not None:
            return exact
    vertices, faces = shape.triangles(mesh.script.check_time)
    known = None if shape.shape == "any" else shape.shape
    return placed_mesh(item.world() @ mesh.matrix, vertices, faces, shape=known, **fields)


def _placed_exactly(item: SceneObject, mesh: Mesh, shape: MeshShape, **fields: Any) -> Primitive | None:
    is_unit = item.properties.get("unit_box")
    if shape.shape == "any" and not is_unit:
        return None
    rows = mesh.matrix.tolist()
    if any(number for row, numbers in enumerate(rows) for column, number in enumerate(numbers) if row != column):
        return None
    stretch, yaw = [rows[axis][axis] for axis in range(3)], item.rotation.numbers[2]
    if shape.shape not in ("mesh", "any"):
        edges = zip(item.scale.numbers, stretch, shape.size, strict=True)
        length, width, height = (abs(scale * factor * edge) for scale, factor, edge in edges)
        flat = shape.shape == "plane" or (shape.shape == "box" and height < THINNEST)  # a slab
        if min(length, width, THINNEST if flat else height) < THINNEST:
            return None
        size = (length, width, 0.0 if flat else height)
        fields |= {"center": tuple(item.location.numbers), "size": size, "yaw": yaw}
        return Primitive(shape="plane" if flat else shape.shape, **fields)
    vertices, faces = shape.triangles(mesh.script.check_time)
    vertices, scale = vertices * stretch, np.array(item.scale.numbers)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if is_unit:
        low, high = np.full(3, -0.5), np.full(3, 0.5)
    x, y, z = ((low + high) / 2 * scale).tolist()
    u, v, w = item.location.numbers
    center = (*point_at((u, v, yaw), x, y), w + z)
    return in_unit_box(vertices, faces, low, high, scale * (high - low), center=center, yaw=yaw, **fields)
