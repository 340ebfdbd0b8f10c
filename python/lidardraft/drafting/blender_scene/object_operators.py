"""`bpy.ops.object` and `bpy.ops.transform`: what is done to selected objects."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender_scene.blocks import Unread
from lidardraft.drafting.blender_scene.edit_operators import transform_vertices
from lidardraft.drafting.blender_scene.mesh_shapes import Polygons, polyhedron
from lidardraft.drafting.blender_scene.meshes import Mesh
from lidardraft.drafting.blender_scene.objects import SceneObject
from lidardraft.drafting.blender_scene.rotations import affine, rotation_matrix
from lidardraft.drafting.blender_scene.scene import Scene
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Value, describe, real, reals, text, truth

_DONE = ["FINISHED"]
_ORIGIN = (0.0, 0.0, 0.0)
_STEPS = 30  # that an object costs


def object_operators(scene: Scene) -> dict[str, Callable[..., Value]]:
    """The operators by their names behind `bpy.ops.`."""
    operators = _selecting(scene) | _making(scene) | _transforming(scene) | _joining(scene)

    def duplicate_move(OBJECT_OT_duplicate: Value = None, TRANSFORM_OT_translate: Value = None, **_: Value) -> Value:
        for name, given in (
            ("object.duplicate", OBJECT_OT_duplicate),
            ("transform.translate", TRANSFORM_OT_translate),
        ):
            if not isinstance(given, dict | None):
                raise RefusalError(f"what {name} gets is {describe(given)}; it must be a dict")
            operators[name](**(given or {}))
        return _DONE

    return operators | {"object.duplicate_move": duplicate_move}


def _selecting(scene: Scene) -> dict[str, Callable[..., Value]]:
    objects = scene.objects

    def select_all(action: Value = "TOGGLE") -> Value:
        if action not in ("SELECT", "DESELECT", "INVERT", "TOGGLE"):
            raise RefusalError(
                f"the action is {describe(action)}; it must be 'SELECT', 'DESELECT', 'INVERT' or 'TOGGLE'"
            )
        chosen = objects.all()
        if action == "DESELECT" or (action == "TOGGLE" and objects.selection):
            chosen = []
        elif action == "INVERT":
            chosen = [item for item in chosen if item not in objects.selection]
        objects.selection = dict.fromkeys(chosen)
        return _DONE

    def select_by_type(type: Value = "MESH", extend: Value = False) -> Value:
        found = [item for item in objects.all() if item.attribute("type") == type]
        objects.selection = {**(objects.selection if truth(extend) else {}), **dict.fromkeys(found)}
        return _DONE

    def delete(**_: Value) -> Value:
        for item in list(objects.selection):
            objects.remove(item)
        return _DONE

    def mode_set(mode: Value = "OBJECT", **_: Value) -> Value:
        if mode not in ("OBJECT", "EDIT"):
            raise RefusalError(f"the mode {describe(mode)} is not read")
        if mode == "EDIT":
            scene.edit_mode = scene.edits_all = True
        else:
            scene.leave_edit_mode()
        return _DONE

    def read_factory_settings(**_: Value) -> Value:
        scene.clear()
        return _DONE

    return {
        "object.select_all": select_all,
        "object.select_by_type": select_by_type,
        "object.delete": delete,
        "object.mode_set": mode_set,
        "wm.read_factory_settings": read_factory_settings,
        "wm.read_homefile": read_factory_settings,
    }


def _making(scene: Scene) -> dict[str, Callable[..., Value]]:
    def added(name: str, data: Value, location: Value, rotation: Value) -> Value:
        scene.objects.budget.take_steps(_STEPS)
        item = scene.add(name, data)
        item.location.numbers = list(reals(location, 3, "the location"))
        item.rotation.numbers = list(reals(rotation, 3, "the rotation"))
        return _DONE

    def empty_add(location: Value = _ORIGIN, rotation: Value = _ORIGIN, **_: Value) -> Value:
        return added("Empty", None, location, rotation)

    def light_add(type: Value = "POINT", location: Value = _ORIGIN, rotation: Value = _ORIGIN, **_: Value) -> Value:
        return added(text(type, "the type").title(), Unread("LIGHT", scene.note), location, rotation)

    def camera_add(location: Value = _ORIGIN, rotation: Value = _ORIGIN, **_: Value) -> Value:
        return added("Camera", Unread("CAMERA", scene.note), location, rotation)

    def duplicate(linked: Value = False, **_: Value) -> Value:
        copies = []
        for item in list(scene.objects.selection):
            scene.objects.budget.take_steps(_STEPS)
            other = item.copy()
            if not truth(linked) and isinstance(other.data, Mesh):
                other.data = other.data.copy()
            other.collections = dict(item.collections)
            scene.objects.budget.take_cells(len(item.collections))
            copies.append(other)
            if scene.objects.active is item:
                scene.objects.active = other
        scene.objects.selection = dict.fromkeys(copies)
        return _DONE

    def text_add(location: Value = _ORIGIN, rotation: Value = _ORIGIN, **_: Value) -> Value:
        return added("Text", Unread("FONT", scene.note), location, rotation)

    def modifier_add(type: Value = "SUBSURF", **_: Value) -> Value:
        if scene.objects.active is None:
            raise RefusalError("there is no active object that could have a modifier")
        name = text(type, "the modifier").title()
        taken = [array.name for array in scene.objects.active.modifiers.arrays]
        names = (name if not number else f"{name}.{number:03}" for number in range(len(taken) + 1))
        scene.objects.active.modifiers.new(next(each for each in names if each not in taken), type)
        return _DONE

    return {
        "object.empty_add": empty_add,
        "object.light_add": light_add,
        "object.camera_add": camera_add,
        "object.duplicate": duplicate,
        "object.modifier_add": modifier_add,
        "object.text_add": text_add,
        "object.modifier_apply": lambda **_: None,
    }


def _transforming(scene: Scene) -> dict[str, Callable[..., Value]]:
    selection = scene.objects

    def transform_apply(location: Value = True, rotation: Value = True, scale: Value = True, **_: Value) -> Value:
        for item in selection.selection:
            scene.objects.budget.take_steps(2 * _STEPS)
            _apply(item, truth(location), truth(rotation), truth(scale))
        return _DONE

    def translate(value: Value = _ORIGIN, **_: Value) -> Value:
        way = np.array(reals(value, 3, "the way"))
        if scene.edit_mode:
            transform_vertices(scene, np.eye(3), way)
            return _DONE
        for item in _roots(scene):
            world = item.charged_world()
            world[:3, 3] += way
            item.set_world(world)
        return _DONE

    def resize(value: Value = (1.0, 1.0, 1.0), **_: Value) -> Value:
        _about_middle(scene, np.diag(reals(value, 3, "the scale")))
        return _DONE

    def rotate(value: Value = 0.0, orient_axis: Value = "Z", **_: Value) -> Value:
        # Without a view, which is how scripts are run, the operator turns clockwise about the axis.
        angles = [-real(value, "the angle") if axis == orient_axis else 0.0 for axis in "XYZ"]
        _about_middle(scene, rotation_matrix(angles))
        return _DONE

    def origin_set(type: Value = "GEOMETRY_ORIGIN", center: Value = "MEDIAN", **_: Value) -> Value:
        for item in selection.selection:
            scene.objects.budget.take_steps(_STEPS)
            if isinstance(item.data, Mesh) and item.data.shape is not None:
                origin = _origin(scene, item, text(type, "the type"), center)
                _set_origin(item, item.data, origin, keeps_place=type != "GEOMETRY_ORIGIN")
        return _DONE

    return {
        "object.origin_set": origin_set,
        "object.transform_apply": transform_apply,
        "transform.translate": translate,
        "transform.resize": resize,
        "transform.rotate": rotate,
    }


def _origin(scene: Scene, item: SceneObject, type: str, center: Value) -> np.ndarray:
    """Where the origin of an object goes [3], in its own axes."""
    if type == "ORIGIN_CURSOR":
        return np.asarray((np.linalg.pinv(item.charged_world()) @ [*scene.cursor.numbers, 1.0])[:3])
    if type not in ("ORIGIN_GEOMETRY", "GEOMETRY_ORIGIN") or center not in ("MEDIAN", "BOUNDS"):
        raise RefusalError(f"origin_set to {type!r:.40}, {describe(center)} is not read")
    vertices = item.vertices()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return np.asarray(vertices.mean(axis=0) if center == "MEDIAN" else (low + high) / 2)


def _set_origin(item: SceneObject, mesh: Mesh, origin: np.ndarray, *, keeps_place: bool) -> None:
    """Make a place in the axes of an object its origin; its surface stays where it is, or comes to the old one."""
    mesh.matrix = affine(np.eye(3), -origin) @ mesh.matrix
    if keeps_place:
        item.location.numbers = (item.local() @ [*origin, 1.0])[:3].tolist()


def _roots(scene: Scene) -> list[SceneObject]:
    """The selected objects that are not moved by a selected parent."""
    return [item for item in scene.objects.selection if item.parent not in scene.objects.selection]


def _about_middle(scene: Scene, linear: np.ndarray) -> None:
    """Turn or stretch the selected objects about the middle of their origins' bounds."""
    items = _roots(scene)
    if scene.edit_mode:
        transform_vertices(scene, linear, np.zeros(3))
        return
    if not items:
        return
    worlds = [item.charged_world() for item in items]
    origins = np.array([world[:3, 3] for world in worlds])
    middle = (origins.min(axis=0) + origins.max(axis=0)) / 2
    change = affine(linear, middle - linear @ middle)
    for item, world in zip(items, worlds, strict=True):
        scene.objects.budget.take_steps(2 * _STEPS)
        # Blender does not shear: an axis of the object keeps its direction, and becomes as long as the change makes it.
        turned = linear @ world[:3, :3]
        crooked = turned.T @ turned - np.diag(np.diag(turned.T @ turned))
        if abs(crooked).max() > 1e-6 * abs(turned.T @ turned).max():
            axes = world[:3, :3] * (np.linalg.norm(turned, axis=0) / np.linalg.norm(world[:3, :3], axis=0))
            item.set_world(affine(axes, (change @ world)[:3, 3]))
        else:
            item.set_world(change @ world)


def _apply(item: SceneObject, location: bool, rotation: bool, scale: bool) -> None:
    """Move a part of an object's transform into its mesh."""
    if not isinstance(item.data, Mesh):
        return
    if rotation and not scale and len(set(item.scale.numbers)) > 1:
        raise RefusalError("a rotation that is applied without an uneven scale is not read; apply both")
    before = item.local()
    if location:
        item.location.numbers = [0.0, 0.0, 0.0]
    if rotation:
        item.rotation.numbers = [0.0, 0.0, 0.0]
    if scale:
        item.scale.numbers = [1.0, 1.0, 1.0]
    if not all(item.scale.numbers):
        raise RefusalError("a transform without an inverse is applied")
    item.data.matrix = np.linalg.inv(item.local()) @ before @ item.data.matrix


def _joining(scene: Scene) -> dict[str, Callable[..., Value]]:
    objects = scene.objects

    def parent_set(type: Value = "OBJECT", **_: Value) -> Value:
        active = objects.active
        if active is None or type != "OBJECT":
            raise RefusalError("there is no active object to be the parent, or it is no parent of objects")
        for item in [item for item in objects.selection if item is not active]:
            world = item.charged_world()
            objects.budget.take_steps(2 * _STEPS)
            item.set_parent(active)
            item.parent_inverse = np.eye(4)
            try:
                item.parent_inverse = np.linalg.inv(active.charged_world()) @ world @ np.linalg.inv(item.local())
            except np.linalg.LinAlgError:
                raise RefusalError("a parent, or a part of it, is scaled to nothing") from None
        return _DONE

    def parent_clear(type: Value = "CLEAR") -> Value:
        for item in objects.selection:
            world = item.charged_world()
            item.parent, item.parent_inverse = None, np.eye(4)
            if type == "CLEAR_KEEP_TRANSFORM":
                item.set_world(world)
        return _DONE

    def join() -> Value:
        active = objects.active
        if active is None or active not in objects.selection or not isinstance(active.data, Mesh):
            raise RefusalError("the active object is no selected mesh that others can be joined to")
        inverse = np.linalg.pinv(active.charged_world())
        objects.budget.take_steps(2 * _STEPS)
        vertices: list[np.ndarray] = []
        faces: Polygons = []
        count = 0
        for item in [active, *(other for other in list(objects.selection) if other is not active)]:
            if not isinstance(item.data, Mesh) or item.data.shape is None:
                continue
            objects.budget.take_steps(2 * item.data.shape.vertices + _STEPS)
            points, polygons = item.data.shape.make()
            to_active = inverse @ item.charged_world() @ item.data.matrix
            vertices.append(points @ to_active[:3, :3].T + to_active[:3, 3])
            faces += [each + count for each in polygons]
            count += len(points)
            if item is not active:
                objects.remove(item)
        if not vertices:
            return _DONE
        active.data.shape = polyhedron(np.concatenate(vertices), faces)
        active.data.matrix = np.eye(4)
        return _DONE

    return {"object.parent_set": parent_set, "object.parent_clear": parent_clear, "object.join": join}
