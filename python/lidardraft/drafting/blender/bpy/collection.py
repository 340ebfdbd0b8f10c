"""Collections of objects, as `bpy.data.collections` and the view layer hold them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from lidardraft.drafting.blender.bpy.blocks import Block, Blocks, Listed, ignored
from lidardraft.drafting.blender.bpy.objects import Objects, SceneObject
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError
from lidardraft.drafting.blender.script.values import Methods, Value, describe, elements, reals


class Collection(Block):
    """A collection: objects, and collections within it."""

    kind = "a collection"

    def __init__(self, owner: Blocks, objects: Objects) -> None:
        super().__init__(owner)
        self.all_objects = objects
        self.children: dict[Collection, None] = {}

    def members(self) -> list[SceneObject]:
        """The objects that are in the collection itself, in the order in which they came into it."""
        items = self.all_objects.all()
        self.script.take_steps(len(items) // 2)
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

    fields: ClassVar[Methods] = Block.fields | {
        **dict.fromkeys(("objects", "all_objects"), lambda self: LinkedObjects(self)),
        "children": lambda self: LinkedCollections(self),
    }
    setters: ClassVar[Methods] = Block.setters | ignored("color_tag", "hide_viewport", "hide_render", "hide_select")


class LayerCollection(Listed):
    """A collection as the view layer shows it, or the children of one by their names."""

    def __init__(self, collection: Collection) -> None:
        self.kind = f"the layer collection {collection.name!r:.60}"
        self.collection = collection
        self.name = collection.name

    def set_attribute(self, name: str, value: Value) -> None:
        if name not in ("exclude", "hide_viewport", "holdout"):
            return super().set_attribute(name, value)
        self.collection.script.note("what hides collections is passed over")

    def elements(self) -> list[Value]:
        self.collection.script.take_steps(len(self.collection.children) + 1)
        return [LayerCollection(child) for child in self.collection.children]

    fields: ClassVar[Methods] = {
        "collection": lambda self: self.collection,
        "children": lambda self: self,
        "name": lambda self: self.name,
    }


class LinkedObjects(Listed):
    """The objects of a collection."""

    kind = "the list of objects of a collection"

    def __init__(self, collection: Collection) -> None:
        self._collection = collection

    def link(self, item: Value) -> None:
        """Put an object into the collection."""
        if not isinstance(item, SceneObject):
            raise RefusalError(f"{describe(item)} is no object")
        if self._collection in item.collections:
            raise RaisedError("RuntimeError", f"the object {item.name!r:.60} is in this collection already")
        self._collection.all_objects.links += 1
        item.collections[self._collection] = self._collection.all_objects.links

    def _unlink(self, item: Value) -> None:
        if not isinstance(item, SceneObject) or self._collection not in item.collections:
            raise RaisedError("RuntimeError", f"{describe(item)} is not in this collection")
        del item.collections[self._collection]

    def _set_all(self, attr: Value, seq: Value) -> None:
        """Give three numbers to every object, one object after the other."""
        items, script = self.elements(), self._collection.script
        numbers = elements(seq, script)
        if attr not in ("location", "scale", "rotation_euler") or len(numbers) != 3 * len(items):
            raise RefusalError(f"foreach_set of {describe(attr)} for {len(items)} objects to {len(numbers)} numbers")
        script.take_steps(3 * len(items) // 2)
        values = reals(numbers, len(numbers), f"the {attr}")
        for number, item in enumerate(items):
            item.set_attribute(attr, values[3 * number : 3 * number + 3])

    def elements(self) -> list[Value]:
        return list(self._collection.members())

    methods: ClassVar[Methods] = Listed.methods | {"link": link, "unlink": _unlink, "foreach_set": _set_all}


class LinkedCollections(Listed):
    """The collections within a collection."""

    kind = "the list of collections within a collection"

    def __init__(self, collection: Collection) -> None:
        self._children = collection.children
        self._script = collection.script

    def _link(self, item: Value) -> None:
        if not isinstance(item, Collection):
            raise RefusalError(f"{describe(item)} is no collection")
        if item in self._children:
            raise RaisedError("RuntimeError", f"the collection {item.name!r:.60} is in this collection already")
        self._children[item] = None

    def _unlink(self, item: Value) -> None:
        if not isinstance(item, Collection) or item not in self._children:
            raise RaisedError("RuntimeError", f"{describe(item)} is not in this collection")
        del self._children[item]

    def elements(self) -> list[Value]:
        self._script.take_steps(len(self._children) // 2 + 1)
        return list(self._children)

    methods: ClassVar[Methods] = Listed.methods | {"link": _link, "unlink": _unlink}
