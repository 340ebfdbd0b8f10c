"""`bpy.data` and `bpy.context`: the scene that a script fills, and what it is asked about it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lidardraft.drafting.blender_scene.blocks import Block, Blocks, Unread
from lidardraft.drafting.blender_scene.collection import Collection, LayerCollection, LinkedObjects
from lidardraft.drafting.blender_scene.meshes import Material, Mesh
from lidardraft.drafting.blender_scene.objects import Objects, SceneObject
from lidardraft.drafting.blender_scene.vectors import Vector
from lidardraft.drafting.script.class_statements import Surroundings
from lidardraft.drafting.script.limits import Budget, RefusalError
from lidardraft.drafting.script.values import Builtin, KindOfRecord, Namespace, Record, Value, describe, reals

VERSION = (4, 5, 0)  # of Blender, for scripts that ask
# What may be made and is passed over: no shape depends on it, or it is a shape that is not read.
_PASSED_OVER = ("lights", "cameras", "worlds", "curves", "fonts", "metaballs", "images", "textures", "actions")
_UNKNOWN = (
    *("armatures", "lattices", "node_groups"),
    *("particles", "linestyles", "palettes", "grease_pencils", "speakers", "lightprobes", "brushes", "volumes"),
)
_OF_SCENES = (
    *("render", "world", "cycles", "eevee", "display", "view_settings", "unit_settings", "display_settings", "camera"),
    *(
        "frame_start",
        "frame_end",
        "frame_current",
        "frame_set",
        "tool_settings",
        "use_nodes",
        "node_tree",
        "view_layers",
    ),
    *("sequencer_colorspace_settings", "timeline_markers", "gravity", "use_gravity"),
)
_OF_CONTEXT = ("area", "screen", "window", "window_manager", "space_data", "region", "evaluated_depsgraph_get")


class Scene:
    """The blocks of a file that holds nothing yet: no cube, camera or light."""

    def __init__(self, budget: Budget, note: Callable[[str], None], line: Callable[[], int]) -> None:
        self.note = note
        self.objects = Objects(budget, note, line)
        self.meshes = Blocks("meshes", Mesh, budget, note)
        self.materials = Blocks("materials", Material, budget, note)
        self.collections = Blocks("collections", lambda owner: Collection(owner, self.objects), budget, note)
        self.master = Collection(self.collections, self.objects)
        self.master.name = "Scene Collection"
        self.current = CurrentScene(self)
        self.active_collection = self.master
        self.edit_mode = False
        self.edits_all = True  # whether all vertices are selected there, or none
        self.edited: dict[Mesh, Any] = {}  # what is edited in the edit mode
        self.cursor = Vector([0.0, 0.0, 0.0])

    def add(self, name: str, data: Value) -> SceneObject:
        """A new object in the scene, which is then the only selected one, and active."""
        if self.edit_mode:
            raise RefusalError("meshes that are edited are not read; leave the edit mode first")
        item: SceneObject = self.objects.new(name, data)
        LinkedObjects(self.collection()).link(item)
        self.objects.select_only(item)
        return item

    def collection(self) -> Collection:
        """The one that new objects come into."""
        if self.collections.by_name.get(self.active_collection.name) is not self.active_collection:
            self.active_collection = self.master  # it has been removed
        return self.active_collection

    def leave_edit_mode(self) -> None:
        """Let what was edited become the meshes."""
        self.edit_mode = False
        for mesh, edited in self.edited.items():
            edited.to_mesh(mesh)
        self.edited.clear()

    def clear(self) -> None:
        """Forget all there is."""
        for blocks in (self.objects, self.meshes, self.materials, self.collections):
            blocks.by_name.clear()
        self.objects.selection.clear()
        self.objects.active = None
        self.master.children.clear()
        self.active_collection = self.master

    def modules(self) -> dict[str, Value]:
        """`bpy.data`, `bpy.context` and `bpy.app` by their names."""
        data: dict[str, Value] = {
            "objects": self.objects,
            "meshes": self.meshes,
            "materials": self.materials,
            "collections": self.collections,
            "scenes": Scenes(self.current),
            "filepath": "",
        }
        data |= {name: OtherBlocks(name, self.note) for name in (*_PASSED_OVER, *_UNKNOWN)}
        kinds = {"Object": SceneObject, "Mesh": Mesh, "Material": Material, "Collection": Collection}
        types = Namespace("bpy.types", {name: KindOfRecord(kind) for name, kind in kinds.items()})
        app = Namespace("bpy.app", {"version": VERSION, "version_string": "4.5.0", "background": True})
        return {"data": Namespace("bpy.data", data), "context": Context(self), "app": app, "types": types}


class OtherBlocks(Record):
    """Blocks of a kind that is not read: none of them is there, and only those that no shape depends on can be made."""

    def __init__(self, name: str, note: Callable[[str], None]) -> None:
        self.kind = f"bpy.data.{name}"
        self._name = name
        self._note = note

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "remove": lambda *_, **__: None,
            "get": lambda _, default=None: default,
            "keys": list,
            "values": list,
        }
        if name == "new" and self._name in _PASSED_OVER:
            kind = {"metaballs": "META", "fonts": "FONT"}.get(self._name, self._name.removesuffix("s").upper())
            return Builtin(f"{self.kind}.new", lambda *_, **__: Unread(kind, self._note))
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def elements(self) -> list[Value]:
        return []

    def truth(self) -> bool:
        return False


class Scenes(Record):
    """`bpy.data.scenes`, of which there is one."""

    kind = "bpy.data.scenes"

    def __init__(self, current: CurrentScene) -> None:
        self._current = current

    def item(self, key: Value) -> Value:
        if key not in (0, "Scene"):
            return super().item(key)
        return self._current

    def elements(self) -> list[Value]:
        return [self._current]


class CurrentScene(Block):
    """`bpy.context.scene`."""

    kind = "the scene"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene.collections)
        self.name = "Scene"
        self._scene = scene

    def attribute(self, name: str) -> Value:
        if name == "collection":
            return self._scene.master
        if name == "objects":
            return self._scene.objects
        if name == "cursor":
            return Cursor(self._scene)
        if name in _OF_SCENES:
            return Unread(f"{name} of the scene", self._scene.note)
        return super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "name":
            return
        if name not in _OF_SCENES:
            raise RefusalError(f"{name!r} of the scene cannot be set to {describe(value)}")
        self._scene.note(f"{name} of the scene is passed over")


class Cursor(Record):
    """The 3D cursor, where new objects go that are given no location."""

    kind = "the cursor"

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def attribute(self, name: str) -> Value:
        return self._scene.cursor if name == "location" else super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name != "location":
            return super().set_attribute(name, value)
        self._scene.cursor.numbers = list(reals(value, 3, "the location of the cursor"))


class Override(Surroundings):
    """`bpy.context.temp_override(...)`: other objects are selected or active for a block."""

    kind = "temp_override"

    def __init__(self, objects: Objects, named: dict[str, Value]) -> None:
        self._objects = objects
        self._named = named
        self._before = objects.active, objects.selection

    def enter(self) -> None:
        self._before = self._objects.active, self._objects.selection
        for name, value in self._named.items():
            if name in ("object", "active_object") and isinstance(value, SceneObject | None):
                self._objects.active = value
            elif name.startswith("selected_") and isinstance(value, list | tuple):
                self._objects.selection = {item: None for item in value if isinstance(item, SceneObject)}

    def leave(self) -> None:
        active, selection = self._before
        known = set(self._objects.all())
        self._objects.active = active if active in known else None
        self._objects.selection = {item: None for item in selection if item in known}


class Context(Record):
    """`bpy.context`."""

    kind = "bpy.context"

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def attribute(self, name: str) -> Value:
        scene = self._scene
        if name in ("object", "active_object"):
            return scene.objects.active
        if name in ("selected_objects", "selected_editable_objects"):
            return list(scene.objects.selection)
        if name == "view_layer":
            return ViewLayer(scene)
        if name == "collection":
            return scene.collection()
        if name == "mode":
            return "EDIT_MESH" if scene.edit_mode else "OBJECT"
        if name == "temp_override":
            return Builtin(name, lambda **named: Override(scene.objects, named))
        if name in _OF_CONTEXT:
            return Unread(f"bpy.context.{name}", scene.note)
        return scene.current if name == "scene" else super().attribute(name)


class ViewLayer(Record):
    """`bpy.context.view_layer`, and its objects."""

    kind = "the view layer"

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def attribute(self, name: str) -> Value:
        if name == "update":
            return Builtin(name, lambda: None)
        if name == "objects":
            return self
        if name == "active":
            return self._scene.objects.active
        if name in ("layer_collection", "active_layer_collection"):
            is_active = name == "active_layer_collection"
            return LayerCollection(self._scene.collection() if is_active else self._scene.master, self._scene.note)
        if name == "depsgraph":
            return Unread(name, self._scene.note)
        return super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "active" and isinstance(value, SceneObject | None):
            self._scene.objects.active = value
        elif name == "active_layer_collection" and isinstance(value, LayerCollection):
            self._scene.active_collection = value.collection
        else:
            super().set_attribute(name, value)

    def elements(self) -> list[Value]:
        return self._scene.objects.elements()
