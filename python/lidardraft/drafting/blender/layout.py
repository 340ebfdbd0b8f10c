"""A Blender Python script becomes a layout. It is read as data, through its syntax tree; it is never run."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import json
import math
import os
import re
from collections import defaultdict
from collections.abc import Mapping
from itertools import count, filterfalse, takewhile
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.drafting.blender.bpy.bmesh import bmesh_module
from lidardraft.drafting.blender.bpy.mathutils import Vector, mathutils_module
from lidardraft.drafting.blender.bpy.meshes import Mesh, MeshShape
from lidardraft.drafting.blender.bpy.objects import SceneObject
from lidardraft.drafting.blender.bpy.operators import Operators
from lidardraft.drafting.blender.bpy.scene import Scene
from lidardraft.drafting.blender.script.limits import Limits, RefusalError, Script
from lidardraft.drafting.blender.script.modules import modules
from lidardraft.drafting.blender.script.reading import read
from lidardraft.drafting.blender.script.values import Namespace
from lidardraft.errors import FormatError, LayoutError, ScriptError, check_type
from lidardraft.files import named, read_bytes, regular_size
from lidardraft.scene.box import THINNEST
from lidardraft.scene.class_names import check_classes, class_of, id_of, without_number, words_of
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.placed_mesh import in_unit_box, placed_mesh
from lidardraft.scene.pose import point_at
from lidardraft.semantics import BY_NAME

_DEFAULT_LIMITS = Limits()
PROVENANCE = "lidardraft"  # the property of the scene in which a layout's provenance and coverage travel
_MOST_NAMES = 50  # in one message
_REMEDY = "say which by --class NAME=CLASS (`classes` in Python)"
_NUMBERED_PART = re.compile(r"(.*?\d+)[._ -]+(\D.*)", re.DOTALL)  # "Car_1_Lamp" is a part of "Car_1"
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_BODY = re.compile("body|chassis|hull|base|main|frame|torso")  # the part of which a thing has one
_PART = re.compile(
    "(?:wheel|tire|tyre|rim|hub|axle|cabin|cab|roof|hood|bonnet|door|trunk|window|windshield|windscreen|glass|bumper"
    "|fender|grille|headlight|taillight|light|mirror|spoiler|seat|saddle|handlebar|fork|pedal|plate|head|arm|leg|hand"
    "|foot|helmet)s?"
)


def layout_from_blender(
    script: str | os.PathLike[str],
    *,
    classes: Mapping[str, str] | None = None,
    strict: bool = False,
    limits: Limits = _DEFAULT_LIMITS,
) -> Layout:
    """The layout of the scene that a Blender Python script makes: its text, or the path of its file, NAME.py.

    Blender's frame is taken as the layout's: x forward, y left, z up, the ego vehicle at the origin. The scene starts
    empty. Classes are those of `classes`, by names of objects, materials or collections, or else what these names say
    ("Car.001", "mat_building"); an object without one is "other", with a note. Upright cubes, spheres, cylinders and
    planes become the layout's own shapes, all else meshes. Numbers of `random` are those of Python's generator for the
    script's seed, or for 0.

    What was passed over because no shape depends on it is in `provenance["notes"]`. Raises `ScriptError` naming the
    line of what is not understood or more than `limits`, and, where `strict`, `LayoutError` listing the names that say
    no class.
    """
    check_type("script", script, str, os.PathLike)
    if isinstance(script, str) and ("\n" in script or not script.endswith(".py")):
        return _layout(script, classes or {}, strict, limits, {"source": "blender"})
    if (size := regular_size(script)) > 4 * limits.file:
        raise FormatError(f"{os.fspath(script)} has {size} bytes; scripts of up to {4 * limits.file} are read")
    with named(script):
        return _layout(_decoded(read_bytes(script)), classes or {}, strict, limits, {"source": Path(script).name})


def _decoded(data: bytes) -> str:
    """The text of a script; a mark at its beginning is no part of it."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ScriptError(f"line {line}: no text in UTF-8: byte {error.start} of the file is wrong") from None


def _layout(text: str, classes: Mapping[str, str], strict: bool, limits: Limits, source: dict[str, Any]) -> Layout:
    check_classes(classes)
    script = Script(limits)
    scene = Scene(script)
    bpy = Namespace("bpy", {"ops": Operators(scene), **scene.modules()})
    script.modules = {**modules(script), "bmesh": bmesh_module(scene), "bpy": bpy, "mathutils": mathutils_module()}
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused where it is used
            read(text, script)
            scene.leave_edit_mode()
            primitives = primitives_of(scene, classes, strict=strict)
    except RefusalError as refusal:
        raise ScriptError(f"line {refusal.line or script.line}: {refusal}") from None
    notes = [f"line {line}: {note}" for note, line in script.notes.items()]
    if not primitives:
        raise ScriptError("; ".join([f"line {script.line}: the script has made no object with a surface", *notes[:3]]))
    if PROVENANCE in scene.current.properties:
        return Layout(primitives=tuple(primitives), **_travelled(scene.current.properties[PROVENANCE]))
    digest = hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()
    return Layout(primitives=tuple(primitives), provenance={**source, "sha256": digest, "notes": notes})


def _travelled(value: Any) -> dict[str, Any]:
    """Provenance and coverage of a layout that has been written as a script."""
    try:
        fields = json.loads(value)
        return {"provenance": fields["provenance"], "coverage": fields["coverage"]}
    except (TypeError, ValueError, KeyError, RecursionError):
        raise ScriptError(f"the property {PROVENANCE!r} of the scene is not what an export writes") from None


def primitives_of(scene: Scene, classes: Mapping[str, str], *, strict: bool) -> list[Primitive]:
    """The primitives of all objects that are linked to the scene and have a surface, in the order of their making.

    An object whose names say no class is "other", with a note. Raises `LayoutError` listing these where `strict`, and
    `RefusalError` for too many vertices and for what is too far away or too large.
    """
    meshes = _meshes_of(scene)
    limit = scene.script.limits.vertices
    if (total := sum(shape.vertices for _, _, shape in meshes if shape.shape in ("mesh", "any"))) > limit:
        raise RefusalError(f"the scene has {total} vertices; {limit} are the most", 1)
    found = [(item, mesh, shape, _class_of(item, classes)) for item, mesh, shape in meshes]
    nameless = {item.name: item.line for item, *_, label in found if label is None}
    if nameless and strict:
        names = ", ".join(f"{name:.60} (line {line})" for name, line in sorted(nameless.items())[:_MOST_NAMES])
        more = f" and {len(nameless) - _MOST_NAMES} more" if len(nameless) > _MOST_NAMES else ""
        raise LayoutError(f"no class for {names}{more}; {_REMEDY}")
    for name, line in nameless.items():
        scene.script.note(f"no class for {without_number(name):.60}: it becomes 'other'; {_REMEDY}", line)
    things = _Things(scene, classes, [item for item, *_, label in found if _is_thing(label)])
    given = {number for item, *_ in meshes if type(number := item.properties.get("instance")) is int}
    numbers = defaultdict[str, int](filterfalse(given.__contains__, count(1)).__next__)
    ids: dict[str, int] = {}
    primitives = []
    for item, mesh, shape, said in found:
        label = said or "other"
        whole, part = things.whole_and_part(item, label)
        fields: dict[str, Any] = {"label": label, "id": item.properties.get("id") or _distinct(whole, part, ids)}
        if "instance" in item.properties:
            fields["instance"] = item.properties["instance"]
        elif _is_thing(label):
            fields["instance"] = numbers[whole]
        for name in {"material", "extinction", "open"} & item.properties.keys():
            fields[name] = item.properties[name]
        try:
            primitive = _placed_shape(item, mesh, shape, **fields)
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
    """An object and those that its arrays make of it, each as an object of its own: a row of cars is many cars."""
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
        if number:  # an object of its own: with an id and an instance of its own
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
    # The mesh comes last: most are called after the operator that made them.
    return class_of(item.class_names(), classes) or class_of([item.data.name], classes)


def _is_thing(label: Any) -> bool:
    return label in BY_NAME and BY_NAME[label].is_thing


class _Name:
    """What the name of a thing says: of which whole it is ("Car_Red" of "Car_Red_Wheel_FL"), the part that it is of
    that, and the numbers behind the part, of which the first may be the whole's ("Car_Wheel_0_1")."""

    def __init__(self, name: str) -> None:
        plain = without_number(name)[:200]
        words = list(_WORD.finditer(plain))
        said = [word.group().lower() for word in words]
        kinds = [_PART.fullmatch(word) or _BODY.fullmatch(word) for word in said]
        place = next((k for k in range(len(said) - 1, 0, -1) if kinds[k]), None)
        numbers = [] if place is None else list(takewhile(str.isdigit, said[place + 1 :]))
        self.is_part = place is not None and _PART.fullmatch(said[place]) is not None
        self.whole, self.part = name, ""
        if place is not None:
            start = plain[: words[place].start()].rstrip("._ -")
            own = numbers[: len(numbers) - 1] if self.is_part else numbers
            self.whole, self.part = "_".join([start, *own]), name[words[place].start() :]
            if not self.is_part:
                self.whole += name[len(plain) :]  # the number that tells one body from another
        self.keys = [(*said[:place], *numbers[:count]) for count in range(len(numbers), -1, -1)]


class _Things:
    """The things of a scene, and which of its objects are parts of them: by their parents, or else by their names."""

    def __init__(self, scene: Scene, classes: Mapping[str, str], items: list[SceneObject]) -> None:
        self._script = scene.script
        self._classes = classes
        # Those that are no part, by the words of their names and the suffix of a copy, and where they are [N, 3].
        self._known: dict[tuple[tuple[str, ...], str], list[SceneObject]] = {}
        self._places: dict[tuple[tuple[str, ...], str], np.ndarray] = {}
        for item in items:
            name = _Name(item.name)
            if not name.is_part:
                self._known.setdefault((name.keys[0], item.suffix), []).append(item)

    def whole_and_part(self, item: SceneObject, label: str) -> tuple[str, str]:
        """The names of the object that it is a part of and of the part; that is "" where it is an object of its own.

        It is a part of the uppermost parent of its class, or else of "Car_1" if its name is "Car_1_Wheel".
        """
        top, parent = item, item.parent
        while parent is not None:
            if class_of([parent.name], self._classes) in (label, None) and not isinstance(parent.data, Mesh):
                top = parent  # an empty holds the parts of one object together
            elif isinstance(parent.data, Mesh) and _class_of(parent, self._classes) == label:
                top = parent
            parent = parent.parent
        whole, part = self._named(top) if _is_thing(label) else _own(top, None)
        if item is top:
            return whole, part
        return whole + item.suffix, item.name.removeprefix(whole).lstrip("._ -") or item.name

    def _named(self, item: SceneObject) -> tuple[str, str]:
        name = _Name(item.name)
        keys = [(key, suffix) for key in name.keys for suffix in (item.suffix, "")]
        key = next((key for key in keys if key in self._known), None)
        if not name.is_part or key is None:
            return _own(item, name)
        known = self._known[key]
        if key not in self._places:
            self._places[key] = np.array([each.world()[:3, 3] for each in known])
        # Of several of one name, it is the nearest one's.
        place = item.world()[:3, 3] if len(known) > 1 else 0.0
        nearest = known[int(np.argmin(((self._places[key] - place) ** 2).sum(axis=1)))]
        return _own(nearest, _Name(nearest.name))[0], name.part + item.suffix.removeprefix(key[1])


def _own(item: SceneObject, name: _Name | None) -> tuple[str, str]:
    """What a name says by itself: the whole and the part."""
    if name is not None and name.part:
        return name.whole + item.suffix, name.part
    match = _NUMBERED_PART.fullmatch(item.name[:200])
    return (match.group(1) + item.suffix, match.group(2)) if match else (item.name + item.suffix, "")


def _distinct(whole: str, part: str, taken: dict[str, int]) -> str:
    """The id of an object or of one more part of it: only parts come after a dot."""
    name = id_of(whole).replace(".", "_")
    if part:
        name += "." + part.replace(".", "_")
    taken[name] = taken.get(name, 0) + 1
    return name if taken[name] == 1 else _distinct(f"{whole}_{taken[name]}", part, taken)


def _lengthwise(primitive: Primitive) -> Primitive:
    """A vehicle's box with its length along its yaw: who models one along y has made its width the longer side."""
    length, width, height = primitive.size
    is_vehicle = BY_NAME[primitive.label].is_thing and primitive.label != "person"
    if primitive.shape != "box" or not is_vehicle or length >= width:
        return primitive
    yaw = math.remainder(primitive.yaw + math.pi / 2, math.pi)  # which end is the front is not known
    return dataclasses.replace(primitive, size=(width, length, height), yaw=yaw)


def _placed_shape(item: SceneObject, mesh: Mesh, shape: MeshShape, **fields: Any) -> Primitive | None:
    """The primitive of an object with `fields` (label, id, ...); None where it has no surface.

    An object that is only moved, scaled and turned about z keeps its numbers to the last digit. Raises `LayoutError`
    for what is too far away or too large.
    """
    turned_about_z = item.mode == "XYZ" and item.rotation.numbers[:2] == [0.0, 0.0]
    if turned_about_z and item.parent is None and min(item.scale.numbers) >= 0:
        exact = _placed_exactly(item, mesh, shape, **fields)
        if exact is not None:
            return exact
    vertices, faces = shape.triangles()
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
    vertices, faces = shape.triangles()
    vertices, scale = vertices * stretch, np.array(item.scale.numbers)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if is_unit:
        low, high = np.full(3, -0.5), np.full(3, 0.5)
    x, y, z = ((low + high) / 2 * scale).tolist()
    u, v, w = item.location.numbers
    center = (*point_at((u, v, yaw), x, y), w + z)
    return in_unit_box(vertices, faces, low, high, scale * (high - low), center=center, yaw=yaw, **fields)
