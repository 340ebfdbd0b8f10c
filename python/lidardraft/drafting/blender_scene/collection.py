"""Collections of objects, as `bpy.data.collections` holds them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from lidardraft.drafting.blender_scene.blocks import Block, Blocks
from lidardraft.drafting.blender_scene.objects import Objects, SceneObject
from lidardraft.drafting.script.limits import RaisedError, RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe, elements, reals


class Collection(Block):
    """A collection: objects, and collections within it."""

    kind = "a collection"
    ignored = ("color_tag", "hide_viewport", "hide_render", "hide_select")

    def __init__(self, owner: Blocks, objects: Objects) -> None:
        super().__init__(owner)
        self.all_objects = objects
        self.children: dict[Collection, None] = {}

    def members(self) -> list[SceneObject]:
        """The objects that are in the collection itself, in the order in which they came into it."""
        items = self.all_objects.all()
        self.owner.budget.take_steps(len(items) // 2)
        found = [item for item in items if self in item.collections]
        return sorted(found, key=lambda item: item.collections[self])

    def attribute(self, name: str) -> Value:
        if name in ("objects", "all_objects"):
            return LinkedObjects(self)
        if name == "children":
            return LinkedCollections(self)
        return super().attribute(name)

    def within(self) -> Iterator[Collection]:
        """It and all collections within it."""
        waiting, seen = [self], set()
        while waiting:
            collection = waiting.pop()
            if id(collection) not in seen:
                seen.add(id(collection))
                yield collection
                waiting.extend(reversed(collection.children))


class LayerCollection(Record):
    """A collection as the view layer shows it, or the children of one by their names."""

    kind = "a layer collection"

    def __init__(self, collection: Collection, note: Callable[[str], None]) -> None:
        self.collection = collection
        self._note = note

    def attribute(self, name: str) -> Value:
        if name == "collection":
            return self.collection
        if name == "children":
            return self
        return self.collection.name if name == "name" else super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name not in ("exclude", "hide_viewport", "holdout"):
            return super().set_attribute(name, value)
        self._note("what hides collections is passed over")

    def elements(self) -> list[Value]:
        self.collection.owner.budget.take_steps(len(self.collection.children) + 1)
        return [LayerCollection(child, self._note) for child in self.collection.children]

    def item(self, key: Value) -> Value:
        found = self.elements()
        if isinstance(key, int) and -len(found) <= key < len(found):
            return found[key]
        for child in found:
            if child.collection.name == key:
                return child
        raise RaisedError("KeyError", f"there is no collection {describe(key)} in {self.collection.name!r:.60}")


class LinkedObjects(Record):
    """The objects of a collection."""

    kind = "the objects of a collection"

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

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {"link": self.link, "unlink": self._unlink}
        methods |= {"foreach_set": self._set_all}
        methods |= {"get": self._get, "keys": lambda: [item.name for item in self.elements()], "values": self.elements}
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def _get(self, name: Value, default: Value = None) -> Value:
        return next((item for item in self.elements() if item.name == name), default)

    def _set_all(self, attr: Value, seq: Value) -> None:
        """Give three numbers to every object, one object after the other."""
        items, budget = self.elements(), self._collection.all_objects.budget
        numbers = elements(seq, budget)
        if attr not in ("location", "scale", "rotation_euler") or len(numbers) != 3 * len(items):
            raise RefusalError(f"foreach_set of {describe(attr)} for {len(items)} objects to {len(numbers)} numbers")
        budget.take_steps(3 * len(items) // 2)
        values = reals(numbers, len(numbers), f"the {attr}")
        for number, item in enumerate(items):
            item.set_attribute(attr, values[3 * number : 3 * number + 3])

    def elements(self) -> list[Value]:
        return self._collection.members()

    def item(self, key: Value) -> Value:
        if isinstance(key, slice):
            return self.elements()[key]
        found = self.elements()[key] if isinstance(key, int) and key < len(self.elements()) else self._get(key)
        if found is None:
            raise RefusalError(f"the collection has no object {describe(key)}")
        return found

    def contains(self, value: Value) -> bool:
        return any(value in (item, item.name) for item in self.elements())


class LinkedCollections(Record):
    """The collections within a collection."""

    kind = "the collections within a collection"

    def __init__(self, collection: Collection) -> None:
        self._children = collection.children
        self._budget = collection.owner.budget

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

    def _get(self, name: Value, default: Value = None) -> Value:
        return next((child for child in self.elements() if child.name == name), default)

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {"link": self._link, "unlink": self._unlink}
        methods |= {"get": self._get, "keys": lambda: [child.name for child in self.elements()]}
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def elements(self) -> list[Value]:
        self._budget.take_steps(len(self._children) // 2 + 1)
        return list(self._children)

    def contains(self, value: Value) -> bool:
        return any(value in (child, child.name) for child in self.elements())
