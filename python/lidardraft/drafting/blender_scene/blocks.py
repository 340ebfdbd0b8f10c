"""What `bpy.data` holds: objects, meshes, materials and collections, each with a name of its own."""

from __future__ import annotations

import re
from collections.abc import Callable

from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe, text

_STEPS = 3  # that a block costs
_MOST_PROPERTIES = 200  # of an object or a mesh


class Unread(Record):
    """A part of Blender that no shape depends on: what is set in it is passed over, all of it is such a part."""

    def __init__(self, kind: str, note: Callable[[str], None]) -> None:
        self.kind = kind
        self._note = note
        note(f"{kind} is passed over")

    def attribute(self, _name: str) -> Value:
        return self

    def set_attribute(self, _name: str, _value: Value) -> None:
        pass

    def item(self, _key: Value) -> Value:
        return self

    def set_item(self, _key: Value, _value: Value) -> None:
        pass

    def elements(self) -> list[Value]:
        return []

    def call(self, _arguments: list[Value], _keywords: dict[str, Value]) -> Value:
        return self


class Blocks(Record):
    """The blocks of one kind by their names, as `bpy.data.objects` holds them."""

    def __init__(self, kind: str, make: Callable[..., Block], budget: Budget, note: Callable[[str], None]) -> None:
        self.kind = f"bpy.data.{kind}"
        self.note = note
        self.by_name: dict[str, Block] = {}
        self._next: dict[str, int] = {}  # the number that a name gets next, unless a block has gone meanwhile
        self.budget = budget
        self._make = make

    def new(self, name: str, *arguments: Value, **named: Value) -> Value:
        """A new block; its name gets a number where another one has it."""
        self.budget.take_steps(_STEPS)
        block = self._make(self, *arguments, **named)
        block.name = self.free_name(text(name, "the name"))
        self.by_name[block.name] = block
        return block

    def free_name(self, name: str) -> str:
        """The name, or, where it is taken, with the first free number behind it: "Car.001"."""
        self.budget.take_text(len(name))
        if name not in self.by_name:
            return name
        stem = re.sub(r"\.\d+$", "", name) if len(name) < 200 else name
        number = self._next.get(stem, 1)
        while f"{stem}.{number:03}" in self.by_name:
            self.budget.take_steps(1)
            number += 1
        self._next[stem] = number + 1
        return f"{stem}.{number:03}"

    def rename(self, block: Block, name: str) -> None:
        """Give a block another name."""
        del self.by_name[block.name]
        self._next.clear()
        block.name = self.free_name(name)
        self.by_name[block.name] = block

    def remove(self, block: Value) -> None:
        """Forget a block."""
        if not isinstance(block, Block) or self.by_name.get(block.name) is not block:
            raise RefusalError(f"{describe(block)} is not in {self.kind}")
        del self.by_name[block.name]
        self._next.clear()

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "new": self.new,
            "remove": lambda block, **_: self.remove(block),
            "get": lambda key, default=None: self.by_name.get(self._name(key), default),
            "keys": lambda: list(self.by_name),
            "values": self.elements,
            "items": lambda: list(self.by_name.items()),
        }
        return Builtin(f"{self.kind}.{name}", methods[name]) if name in methods else super().attribute(name)

    def _name(self, key: Value) -> str:
        self.budget.take_compared(key)
        return text(key, "a name")

    def elements(self) -> list[Value]:
        self.budget.take_cells(len(self.by_name))
        return list(self.by_name.values())

    def contains(self, value: Value) -> bool:
        return value in self.by_name if isinstance(value, str) else value in self.by_name.values()

    def item(self, key: Value) -> Value:
        self.budget.take_compared(key)
        if isinstance(key, slice):
            return self.elements()[key]
        if isinstance(key, int) and -len(self.by_name) <= key < len(self.by_name):
            return self.elements()[key]
        if key not in self.by_name if isinstance(key, str) else True:
            raise RaisedError("KeyError", f"{self.kind} has no {describe(key)}")
        return self.by_name[key]

    def truth(self) -> bool:
        return bool(self.by_name)


class Block(Record):
    """What has a name and properties of the user's own."""

    ignored: tuple[str, ...] = ()
    is_key = True

    def __init__(self, owner: Blocks) -> None:
        self.name = ""
        self.owner = owner
        self.properties: dict[str, Value] = {}

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "get": lambda key, default=None: self.properties.get(self.owner._name(key), default),
            "keys": lambda: list(self.properties),
            "update": lambda *_: None,
            "update_tag": lambda *_: None,
        }
        if name in ("name", "name_full"):
            return self.name
        if name == "users":
            return 1  # blocks that nothing uses are in no layout anyway
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "name":
            self.owner.rename(self, text(value, "the name"))
        elif name not in self.ignored:
            super().set_attribute(name, value)

    def item(self, key: Value) -> Value:
        self.owner.budget.take_compared(key)
        if key not in self.properties if isinstance(key, str) else True:
            raise RaisedError("KeyError", f"{self.kind} {self.name!r:.60} has no property {describe(key)}")
        return self.properties[key]

    def set_item(self, key: Value, value: Value) -> None:
        if value is not None and not isinstance(value, int | float | str | list | tuple):
            raise RefusalError(f"a property of {describe(value)} is not read")
        if len(self.properties) >= _MOST_PROPERTIES:
            raise RefusalError(f"{self.kind} with more than {_MOST_PROPERTIES} properties")
        self.properties[text(key, "the name of a property")] = value

    def contains(self, value: Value) -> bool:
        return isinstance(value, str) and value in self.properties
