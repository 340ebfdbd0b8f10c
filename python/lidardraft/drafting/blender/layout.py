"""A Blender Python script becomes a layout. It is read as data, through its syntax tree; it is never run."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.drafting.blender.bpy.bmesh import bmesh_module
from lidardraft.drafting.blender.bpy.mathutils import mathutils_module
from lidardraft.drafting.blender.bpy.operators import Operators
from lidardraft.drafting.blender.bpy.scene import Scene
from lidardraft.drafting.blender.bpy.scene_layout import primitives_of
from lidardraft.drafting.blender.script.limits import Limits, RefusalError, Script
from lidardraft.drafting.blender.script.reading import read
from lidardraft.drafting.blender.script.standard_modules import standard_modules
from lidardraft.drafting.blender.script.stub_modules import stub_modules
from lidardraft.drafting.blender.script.values import Namespace
from lidardraft.errors import FormatError, ScriptError, check_type
from lidardraft.files import named, read_bytes, regular_size
from lidardraft.scene.class_names import check_classes
from lidardraft.scene.layout import Layout

_DEFAULT_LIMITS = Limits()
PROVENANCE = "lidardraft"  # the property of the scene in which a layout's provenance and coverage travel


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
    script.modules = standard_modules(script) | stub_modules(script) | {"bmesh": bmesh_module(scene)}
    script.modules |= {"bpy": Namespace("bpy", {"ops": Operators(scene), **scene.modules()})}
    script.modules |= {"mathutils": mathutils_module()}
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
