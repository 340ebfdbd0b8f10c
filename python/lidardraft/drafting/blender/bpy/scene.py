"""`bpy.data` and `bpy.context`: the scene that a script fills, its collections, and its queries."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from lidardraft.drafting.blender.bpy.blocks import Block, Blocks, Listed, Listing, Unread, ignored, unread
from lidardraft.drafting.blender.bpy.mathutils import Vector
from lidardraft.drafting.blender.bpy.meshes import Material, Mesh
from lidardraft.drafting.blender.bpy.objects import Objects, SceneObject
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import (
    Methods,
    Namespace,
    Record,
    Value,
    describe,
    elements,
    nothing,
    of_kind,
    reals,
    type_of,
)

VERSION = (4, 5, 0)  # of Blender, for scripts that ask
# Blocks that may be made and are ignored: no shape depends on them, or their shapes are unsupported.
_PASSED_OVER = ("lights", "cameras", "worlds", "curves", "fonts", "metaballs", "images", "textures", "actions")
_UNKNOWN = (
    *("armatures", "lattices", "node_groups", "particles", "linestyles", "palettes", "grease_pencils", "speakers"),
    *("lightprobes", "brushes", "volumes"),
)
_OF_SCENES = (
    *("render", "world", "cycles", "eevee", "display", "view_settings", "unit_settings", "display_settings", "camera"),
    *("frame_start", "frame_end", "frame_current", "frame_set", "tool_settings", "use_nodes", "node_tree"),
    *("view_layers", "sequencer_colorspace_settings", "timeline_markers", "gravity", "use_gravity"),
)
_OF_CONTEXT = ("area", "screen", "window", "window_manager", "space_data", "region", "evaluated_depsgraph_get")


class Collection(Block):
    """A collection: objects, and collections within it."""

    kind = "a collection"

    def __init__(self, owner: Blocks, objects: Objects) -> None:
        super().__init__(owner)
        self.all_objects = objects
        self.children: dict[Collection, None] = {}

    def members(self) -> list[SceneObject]:
        """The objects directly in the collection, in the order of their links."""
        items = self.all_objects.all()
        found = [item for item in items if self in item.collections]
        return sorted(found, key=lambda item: item.collections[self])

    def within(self) -> Iterator[Collection]:
        """It and all collections within it."""
        waiting, seen = [self], set()
        while waiting:
            collection = waiting.pop()
            if id(collection) not in seen:
                seen.add(id(collection))
                yield collection
                waiting.extend(reversed(collection.children))

    def link(self, item: Value) -> None:
        """Link an object to it."""
        if self in of_kind(item, SceneObject, "what is linked").collections:
            raise RaisedError("RuntimeError", f"the object {item.name!r:.60} is in this collection already")
        self.all_objects.links += 1
        item.collections[self] = self.all_objects.links

    def _link_child(self, child: Value) -> None:
        if of_kind(child, Collection, "what is linked") in self.children:
            raise RaisedError("RuntimeError", f"the collection {child.name!r:.60} is in this collection already")
        self.children[child] = None

    def _unlink(self, item: Value) -> None:
        links = item.collections if isinstance(item, SceneObject) else self.children
        block = self if isinstance(item, SceneObject) else item
        if not isinstance(item, Block) or block not in links:
            raise RaisedError("RuntimeError", f"{describe(item)} is not in this collection")
        del links[block]

    def _set_all(self, attr: Value, seq: Value) -> None:
        """Set three numbers of each object, one object after another."""
        items, numbers = self.members(), elements(seq, self.script)
        if attr not in ("location", "scale", "rotation_euler") or len(numbers) != 3 * len(items):
            raise RefusalError(f"foreach_set of {describe(attr)} for {len(items)} objects to {len(numbers)} numbers")
        values = reals(numbers, len(numbers), f"the {attr}")
        for number, item in enumerate(items):
            item.set_attribute(attr, values[3 * number : 3 * number + 3])

    def _objects(self) -> Listing:
        own: Methods = {"link": self.link, "unlink": self._unlink, "foreach_set": self._set_all}
        return Listing("the list of objects of a collection", self.members, own)

    def _children(self) -> Listing:
        def held() -> list[Collection]:
            return list(self.children)

        own: Methods = {"link": self._link_child, "unlink": self._unlink}
        return Listing("the list of collections within a collection", held, own)

    fields: ClassVar[Methods] = {
        **Block.fields,
        **dict.fromkeys(("objects", "all_objects"), _objects),
        "children": _children,
    }
    setters: ClassVar[Methods] = Block.setters | ignored("color_tag", "hide_viewport", "hide_render", "hide_select")


class LayerCollection(Listed):
    """A collection in the view layer; also its children by name."""

    def __init__(self, collection: Collection) -> None:
        self.kind = f"the layer collection {collection.name!r:.60}"
        self.collection = collection
        self.name = collection.name

    def set_attribute(self, name: str, value: Value) -> None:
        if name not in ("exclude", "hide_viewport", "holdout"):
            return super().set_attribute(name, value)
        self.collection.script.note("what hides collections is passed over")

    def held(self) -> list[LayerCollection]:
        return [LayerCollection(child) for child in self.collection.children]

    fields: ClassVar[Methods] = {
        "collection": lambda self: self.collection,
        "children": lambda self: self,
        "name": lambda self: self.name,
    }


class Scene:
    """The blocks of an empty file: no cube, camera or light."""

    def __init__(self, script: Script) -> None:
        self.script = script
        self.objects = Objects(script)
        self.meshes = Blocks("meshes", Mesh, script)
        self.materials = Blocks("materials", Material, script)
        self.collections = Blocks("collections", lambda owner: Collection(owner, self.objects), script)
        self.master = Collection(self.collections, self.objects)
        self.master.name = "Scene Collection"
        self.current = CurrentScene(self)
        self.active_collection = self.master
        self.edit_mode = False
        self.edits_all = True  # whether all vertices are selected in the edit mode, or none
        self.edited: dict[Mesh, Any] = {}  # the edited meshes of the edit mode
        self.cursor = Vector([0.0, 0.0, 0.0])

    def add(self, name: str, data: Value) -> SceneObject:
        """A new object in the scene, which becomes the only selected one, and active."""
        if self.edit_mode:
            raise RefusalError("operators add objects in the object mode; leave the edit mode first")
        item: SceneObject = self.objects.new(name, data)
        self.collection().link(item)
        self.objects.select_only(item)
        return item

    def collection(self) -> Collection:
        """The collection of new objects."""
        if self.collections.by_name.get(self.active_collection.name) is not self.active_collection:
            self.active_collection = self.master  # the active one was removed
        return self.active_collection

    def leave_edit_mode(self) -> None:
        """Write the edited meshes back."""
        self.edit_mode = False
        for mesh, edited in self.edited.items():
            edited.to_mesh(mesh)
        self.edited.clear()

    def clear(self) -> None:
        """Remove all blocks."""
        for blocks in (self.objects, self.meshes, self.materials, self.collections):
            blocks.by_name.clear()
        self.objects.selection.clear()
        self.objects.active = None
        self.master.children.clear()
        self.active_collection = self.master

    def modules(self) -> dict[str, Value]:
        """`bpy.data`, `bpy.context` and so on, by name."""
        blocks = (self.objects, self.meshes, self.materials, self.collections)
        data: dict[str, Value] = {each.kind.removeprefix("bpy.data."): each for each in blocks}
        data |= {name: _other_blocks(name, self.script) for name in (*_PASSED_OVER, *_UNKNOWN)}
        data |= {"scenes": Listing("bpy.data.scenes", lambda: [self.current], {}), "filepath": ""}
        kinds = {"Object": SceneObject, "Mesh": Mesh, "Material": Material, "Collection": Collection}
        types = Namespace("bpy.types", {name: type_of(kind) for name, kind in kinds.items()})
        app = Namespace("bpy.app", {"version": VERSION, "version_string": "4.5.0", "background": True})
        return {"data": Namespace("bpy.data", data), "context": Context(self), "app": app, "types": types}


def _other_blocks(name: str, script: Script) -> Listing:
    """Blocks of an unsupported kind: always empty, and only those in `_PASSED_OVER` can be made."""
    kind = f"bpy.data.{name}"

    def new(*_: Value, **__: Value) -> Unread:
        if name not in _PASSED_OVER:
            raise RefusalError(f"{kind}.new is not supported")
        return Unread({"metaballs": "META", "fonts": "FONT"}.get(name, name.removesuffix("s").upper()), script)

    return Listing(kind, lambda: [], {"new": new, "remove": nothing})


class CurrentScene(Block):
    """`bpy.context.scene`."""

    kind = "the scene"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene.collections)
        self.name = "Scene"
        self._scene = scene

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "name":
            return
        if name not in _OF_SCENES:
            raise RefusalError(f"{name!r} of the scene cannot be set to {describe(value)}")
        self.script.note(f"{name} of the scene is passed over")

    fields: ClassVar[Methods] = {
        **Block.fields,
        "collection": lambda self: self._scene.master,
        "objects": lambda self: self._scene.objects,
        "cursor": lambda self: Cursor(self._scene),
        **unread("the scene", *_OF_SCENES),
    }


class Cursor(Record):
    """The 3D cursor: the place of new objects without a location."""

    kind = "the cursor"

    def __init__(self, scene: Scene) -> None:
        self.place = scene.cursor

    fields: ClassVar[Methods] = {"location": lambda self: self.place}
    setters: ClassVar[Methods] = {
        "location": lambda self, value: self.place.change(reals(value, 3, "the location of the cursor"))
    }


class Context(Record):
    """`bpy.context`."""

    kind = "bpy.context"

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    fields: ClassVar[Methods] = {
        "scene": lambda self: self.scene.current,
        **dict.fromkeys(("object", "active_object"), lambda self: self.scene.objects.active),
        **dict.fromkeys(
            ("selected_objects", "selected_editable_objects"), lambda self: list(self.scene.objects.selection)
        ),
        "view_layer": lambda self: ViewLayer(self.scene),
        "collection": lambda self: self.scene.collection(),
        "mode": lambda self: "EDIT_MESH" if self.scene.edit_mode else "OBJECT",
        **{name: lambda self, name=name: Unread(f"bpy.context.{name}", self.scene.script) for name in _OF_CONTEXT},
    }


class ViewLayer(Listed):
    """`bpy.context.view_layer`, and its objects."""

    kind = "the view layer"

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "active" and isinstance(value, SceneObject | None):
            self._scene.objects.active = value
        elif name == "active_layer_collection" and isinstance(value, LayerCollection):
            self._scene.active_collection = value.collection
        else:
            super().set_attribute(name, value)

    def held(self) -> list[Value]:
        return self._scene.objects.held()

    fields: ClassVar[Methods] = {
        "objects": lambda self: self,
        "active": lambda self: self._scene.objects.active,
        "layer_collection": lambda self: LayerCollection(self._scene.master),
        "active_layer_collection": lambda self: LayerCollection(self._scene.collection()),
        "depsgraph": lambda self: Unread("depsgraph", self._scene.script),
    }
    methods: ClassVar[Methods] = Listed.methods | {"update": nothing}
