"""`bpy.ops`: operators that add, select, move or join objects and so on; those without effect on shapes are ignored."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender.bpy.blocks import Unread
from lidardraft.drafting.blender.bpy.mathutils import IDENTITY, affine, inverse, moved, rotation_matrix
from lidardraft.drafting.blender.bpy.meshes import SHAPES, Mesh, polyhedron, scale_of, shape_of
from lidardraft.drafting.blender.bpy.objects import SceneObject
from lidardraft.drafting.blender.bpy.scene import Scene
from lidardraft.drafting.blender.script.limits import RefusalError
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Record,
    Value,
    describe,
    real,
    reals,
    text,
)

_ORIGIN = (0.0, 0.0, 0.0)
_ACTIONS = ("SELECT", "DESELECT", "INVERT", "TOGGLE")
# Operators that leave all shapes in place: pictures, exports, views, smoothness; and curves.
_PASSED_OVER = (
    *("render.", "export_scene.", "export_mesh.", "export_anim.", "wm.save_", "wm.obj_export", "wm.stl_export"),
    *("wm.ply_export", "wm.usd_export", "view3d.", "screen.", "outliner.", "uv.", "ed.undo", "wm.redraw_timer"),
    *("object.shade_", "object.material_slot_", "object.hide_view_", "material.", "world.", "node."),
    *("mesh.normals_make_consistent", "mesh.flip_normals", "mesh.remove_doubles", "mesh.quads_convert_to_tris"),
    *("mesh.tris_convert_to_quads", "mesh.select_mode", "mesh.faces_shade_", "mesh.mark_sharp", "mesh.mark_seam"),
    *("mesh.subdivide", "curve.", "surface."),
)
# Operators that add an ignored object, by prefixes of their names.
_OTHER_OBJECTS = {
    **{"curve.": "CURVE", "surface.": "SURFACE", "object.text_": "FONT", "object.metaball_": "META"},
    **{"object.camera_": "CAMERA", "object.light_": "LIGHT", "object.lightprobe_": "LIGHT_PROBE"},
    **{"object.armature_": "ARMATURE", "object.lattice_": "LATTICE", "object.speaker_": "SPEAKER"},
    **{"object.grease_pencil_": "GREASEPENCIL", "object.volume_": "VOLUME"},
}
_OF_TEXTURES = ("calc_uvs", "generate_uvs")
_NAMES = {"uv_sphere": "Sphere", "ico_sphere": "Icosphere"}  # of objects not named after their shape


class Operators(Record):
    """`bpy.ops`, or one of its groups: `name` is "" or such as "mesh."."""

    def __init__(self, scene: Scene, name: str = "") -> None:
        self.kind = f"bpy.ops.{name}".rstrip(".")
        self._scene = scene
        self._name = name
        self._made: dict[str, Value] = {}

    def attribute(self, name: str) -> Value:
        if name not in self._made:
            made = self._operator(self._name + name) if self._name else Operators(self._scene, f"{name}.")
            self._made[name] = made
        return self._made[name]

    def _operator(self, name: str) -> Value:
        full, scene = f"bpy.ops.{name}", self._scene
        kind = next((kind for start, kind in _OTHER_OBJECTS.items() if name.startswith(start)), None)
        is_other = kind is not None and name.endswith("_add")
        if not (is_other or name in _OPERATORS or name.startswith(_PASSED_OVER)):
            raise RefusalError(f"{full} is not supported")

        def call(**arguments: Value) -> Value:
            if name in _OPERATORS:
                _OPERATORS[name](scene, **arguments)
            elif is_other:
                _add_placed(scene, str(kind), Unread(str(kind), scene.script), arguments)
            else:
                scene.script.note(f"{full} is passed over")
            return ["FINISHED"]

        return Builtin(full, call, own={"poll": lambda: True})


def _checked(action: Value) -> Value:
    if action not in _ACTIONS:
        raise RefusalError(f"the action is {describe(action)}; it must be one of {', '.join(_ACTIONS)}")
    return action


def _select_all(scene: Scene, action: Value = "TOGGLE") -> None:
    chosen, before = scene.objects.all(), scene.objects.selection
    if _checked(action) == "DESELECT" or (action == "TOGGLE" and before):
        chosen = []
    elif action == "INVERT":
        chosen = [item for item in chosen if item not in before]
    scene.objects.selection = dict.fromkeys(chosen)


def _select_vertices(scene: Scene, action: Value = "TOGGLE") -> None:
    scene.edits_all = _checked(action) == "SELECT" or (action != "DESELECT" and not scene.edits_all)


def _select_by_type(scene: Scene, type: Value = "MESH", extend: Value = False) -> None:
    found = [item for item in scene.objects.all() if item.attribute("type") == type]
    scene.objects.selection = {**(scene.objects.selection if extend else {}), **dict.fromkeys(found)}


def _delete(scene: Scene, **_: Value) -> None:
    for item in list(scene.objects.selection):
        scene.objects.remove(item)


def _mode_set(scene: Scene, mode: Value = "OBJECT", **_: Value) -> None:
    if mode not in ("OBJECT", "EDIT"):
        raise RefusalError(f"the mode {describe(mode)} is not supported")
    if mode == "EDIT":
        scene.edit_mode = scene.edits_all = True
    else:
        scene.leave_edit_mode()


def _primitive(name: str) -> Callable[..., None]:
    def add(
        scene: Scene,
        *,
        location: Value = None,
        rotation: Value = _ORIGIN,
        scale: Value = None,
        align: Value = "WORLD",
        enter_editmode: Value = False,
        **given: Value,
    ) -> None:
        if align != "WORLD" or enter_editmode:
            raise RefusalError(f"align={describe(align)} or enter_editmode is not supported")
        shape = shape_of(name, {key: value for key, value in given.items() if key not in _OF_TEXTURES})
        mesh: Mesh = scene.meshes.new(_NAMES.get(name, name.title()))
        mesh.shape = shape
        if scale is not None:
            mesh.matrix = np.diag([*scale_of(scale), 1.0])
        _add_placed(scene, mesh.name, mesh, {"location": location, "rotation": rotation})

    return add


def _add_placed(scene: Scene, name: str, data: Value, where: dict[str, Value]) -> None:
    item = scene.add(name, data)
    location = where.get("location")
    item.location.change(reals(scene.cursor if location is None else location, 3, "the location"))
    item.rotation.change(reals(where.get("rotation", _ORIGIN), 3, "the rotation"))


def _duplicate(scene: Scene, linked: Value = False, **_: Value) -> None:
    copies = []
    for item in list(scene.objects.selection):
        other = item.copy()
        if not linked and isinstance(other.data, Mesh):
            other.data = other.data.copy()
        other.collections = dict(item.collections)
        scene.script.take_made(other.collections)
        copies.append(other)
        if scene.objects.active is item:
            scene.objects.active = other
    scene.objects.selection = dict.fromkeys(copies)


def _duplicate_move(
    scene: Scene, OBJECT_OT_duplicate: Value = None, TRANSFORM_OT_translate: Value = None, **_: Value
) -> None:
    for given in (OBJECT_OT_duplicate, TRANSFORM_OT_translate):
        if not isinstance(given, dict | None):
            raise RefusalError(f"duplicate_move gets {describe(given)}; it must be a dict")
    _duplicate(scene, **(OBJECT_OT_duplicate or {}))
    _translate(scene, **(TRANSFORM_OT_translate or {}))


def _modifier_add(scene: Scene, type: Value = "SUBSURF", **_: Value) -> None:
    if scene.objects.active is None:
        raise RefusalError("modifier_add needs an active object")
    name = text(type, "the modifier").title()
    taken = [array.name for array in scene.objects.active.modifiers.arrays]
    names = (name if not number else f"{name}.{number:03}" for number in range(len(taken) + 1))
    scene.objects.active.modifiers.new(next(each for each in names if each not in taken), type)


def _translate(scene: Scene, value: Value = _ORIGIN, **_: Value) -> None:
    way = np.array(reals(value, 3, "the way"))
    if scene.edit_mode:
        _transform_vertices(scene, np.eye(3), way)
        return
    for item in _roots(scene):
        world = item.world()
        world[:3, 3] += way
        item.set_world(world)


def _resize(scene: Scene, value: Value = (1.0, 1.0, 1.0), **_: Value) -> None:
    _about_middle(scene, np.diag(reals(value, 3, "the scale")))


def _rotate(scene: Scene, value: Value = 0.0, orient_axis: Value = "Z", **_: Value) -> None:
    # Scripts run without a view; then the operator turns clockwise about the axis.
    angles = [-real(value, "the angle") if axis == orient_axis else 0.0 for axis in "XYZ"]
    _about_middle(scene, rotation_matrix(angles))


def _origin_set(scene: Scene, type: Value = "GEOMETRY_ORIGIN", center: Value = "MEDIAN", **_: Value) -> None:
    for item in scene.objects.selection:
        if isinstance(item.data, Mesh) and item.data.shape is not None:
            origin = _origin(scene, item, text(type, "the type"), center)
            item.data.matrix = affine(np.eye(3), -origin) @ item.data.matrix
            if type != "GEOMETRY_ORIGIN":  # its surface stays in place
                item.location.change((item.local() @ [*origin, 1.0])[:3].tolist())


def _origin(scene: Scene, item: SceneObject, type: str, center: Value) -> np.ndarray:
    """The new origin of an object [3], in its own axes."""
    if type == "ORIGIN_CURSOR":
        return np.asarray((np.linalg.pinv(item.world()) @ [*scene.cursor.numbers, 1.0])[:3])
    if type not in ("ORIGIN_GEOMETRY", "GEOMETRY_ORIGIN") or center not in ("MEDIAN", "BOUNDS"):
        raise RefusalError(f"origin_set to {type!r:.40}, {describe(center)} is not supported")
    vertices = item.vertices()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return np.asarray(vertices.mean(axis=0) if center == "MEDIAN" else (low + high) / 2)


def _roots(scene: Scene) -> list[SceneObject]:
    """The selected objects without a selected parent."""
    return [item for item in scene.objects.selection if item.parent not in scene.objects.selection]


def _about_middle(scene: Scene, linear: np.ndarray) -> None:
    """Turn or stretch the selected objects about the middle of their origins' bounds."""
    items = _roots(scene)
    if scene.edit_mode:
        _transform_vertices(scene, linear, np.zeros(3))
        return
    if not items:
        return
    worlds = [item.world() for item in items]
    origins = np.array([world[:3, 3] for world in worlds])
    middle = (origins.min(axis=0) + origins.max(axis=0)) / 2
    change = affine(linear, middle - linear @ middle)
    for item, world in zip(items, worlds, strict=True):
        # Blender does not shear: each axis of the object keeps its direction and gets its new length.
        turned = linear @ world[:3, :3]
        crooked = turned.T @ turned - np.diag(np.diag(turned.T @ turned))
        if abs(crooked).max() > 1e-6 * abs(turned.T @ turned).max():
            axes = world[:3, :3] * (np.linalg.norm(turned, axis=0) / np.linalg.norm(world[:3, :3], axis=0))
            item.set_world(affine(axes, (change @ world)[:3, 3]))
        else:
            item.set_world(change @ world)


def _transform_vertices(scene: Scene, linear: np.ndarray, offset: np.ndarray) -> None:
    """Turn or stretch the vertices of the active mesh about their middle [3, 3], then move them [3], along the axes of
    the world."""
    item = scene.objects.active
    if item is None or not isinstance(item.data, Mesh) or item.data in scene.edited:
        raise RefusalError("the edit mode transforms a mesh that bmesh does not have open, and nothing else")
    vertices = item.vertices()
    if not scene.edits_all or not len(vertices):
        return
    world = item.world()
    middle = moved(vertices.mean(axis=0), world)
    change = affine(linear, middle - linear @ middle + offset)
    item.data.matrix = inverse(world, "the object") @ change @ world @ item.data.matrix


def _transform_apply(
    scene: Scene, location: Value = True, rotation: Value = True, scale: Value = True, **_: Value
) -> None:
    """Move parts of the transforms of the selected objects into their meshes."""
    for item in scene.objects.selection:
        if not isinstance(item.data, Mesh):
            continue
        if rotation and not scale and len(set(item.scale.numbers)) > 1:
            raise RefusalError("an uneven scale is applied together with the rotation; apply both")
        before = item.local()
        if location:
            item.location.change(_ORIGIN)
        if rotation:
            item.turn(np.eye(3))
        if scale:
            item.scale.change((1.0, 1.0, 1.0))
        item.data.matrix = inverse(item.local(), item.name[:60]) @ before @ item.data.matrix


def _parent_set(scene: Scene, type: Value = "OBJECT", **_: Value) -> None:
    active = scene.objects.active
    if active is None or type != "OBJECT":
        raise RefusalError("parent_set needs an active object and type='OBJECT'")
    for item in [item for item in scene.objects.selection if item is not active]:
        world = item.world()
        item.set_parent(active)
        above = inverse(active.world(), "the parent")
        item.parent_inverse = above @ world @ inverse(item.local(), item.name[:60])


def _parent_clear(scene: Scene, type: Value = "CLEAR") -> None:
    for item in scene.objects.selection:
        world = item.world()
        item.parent, item.parent_inverse = None, IDENTITY
        if type == "CLEAR_KEEP_TRANSFORM":
            item.set_world(world)


def _join(scene: Scene) -> None:
    objects, active = scene.objects, scene.objects.active
    if active is None or active not in objects.selection or not isinstance(active.data, Mesh):
        raise RefusalError("join needs an active object that is selected and a mesh")
    own = np.linalg.pinv(active.world())
    vertices, faces = [np.zeros((0, 3))], list[np.ndarray]()
    for item in [active, *(other for other in list(objects.selection) if other is not active)]:
        if not isinstance(item.data, Mesh) or item.data.shape is None:
            continue
        points, polygons = item.data.shape.make()
        faces += [each + sum(map(len, vertices)) for each in polygons]
        vertices.append(moved(points, own @ item.world() @ item.data.matrix))
        if item is not active:
            objects.remove(item)
    if len(vertices) > 1:
        active.data.shape, active.data.matrix = polyhedron(np.concatenate(vertices), faces), IDENTITY


_OPERATORS: dict[str, Callable[..., None]] = {
    **{f"mesh.primitive_{name}_add": _primitive(name) for name in SHAPES if not name.startswith("create_")},
    "mesh.select_all": _select_vertices,
    "object.delete": _delete,
    "object.duplicate": _duplicate,
    "object.duplicate_move": _duplicate_move,
    "object.empty_add": lambda scene, **where: _add_placed(scene, "Empty", None, where),
    "object.join": _join,
    "object.mode_set": _mode_set,
    "object.modifier_add": _modifier_add,
    "object.modifier_apply": lambda *_, **__: None,
    "object.origin_set": _origin_set,
    "object.parent_clear": _parent_clear,
    "object.parent_set": _parent_set,
    "object.select_all": _select_all,
    "object.select_by_type": _select_by_type,
    "object.transform_apply": _transform_apply,
    "transform.resize": _resize,
    "transform.rotate": _rotate,
    "transform.translate": _translate,
    **dict.fromkeys(("wm.read_factory_settings", "wm.read_homefile"), lambda scene, **_: scene.clear()),
}
