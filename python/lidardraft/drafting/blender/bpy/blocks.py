"""The contents of `bpy.data`: objects, meshes, materials and collections, each with its own name."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import ClassVar

from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import Builtin, Methods, Record, Value, describe, place, text


class Unread(Record):
    """A part of Blender without effect on shapes: its settings are ignored, and all its attributes are such parts."""

    def __init__(self, kind: str, script: Script) -> None:
        self.kind = kind
        script.note(f"{kind} is passed over")

    def attribute(self, _name: str) -> Value:
        return self

    def set_attribute(self, _name: str, _value: Value) -> None:
        pass

    def __getitem__(self, _key: Value) -> Value:
        return self

    def __setitem__(self, _key: Value, _value: Value) -> None:
        pass

    def __iter__(self) -> Iterator[Value]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __call__(self, /, *_arguments: Value, **_keywords: Value) -> Value:
        return self


class Listed(Record):
    """Ordered values, found by index or, if they have one, by `name`."""

    def held(self) -> Sequence[Value]:
        """Its values; callers must not change them."""
        raise NotImplementedError

    def __iter__(self) -> Iterator[Value]:
        return iter([*self.held()])

    def __len__(self) -> int:
        return len(self.held())

    def named(self, name: Value) -> Value:
        """The value of that name, or None."""
        return next((each for each in self.held() if getattr(each, "name", None) == name), None)

    def __getitem__(self, key: Value) -> Value:
        if not isinstance(key, str):
            found = self.held()
            return found[key if isinstance(key, slice) else place(key, len(found), self.kind)]
        if (one := self.named(key)) is None:
            raise RaisedError("KeyError", f"{self.kind} has no {describe(key)}")
        return one

    def __contains__(self, value: Value) -> bool:
        return self.named(value) is not None if isinstance(value, str) else value in self.held()

    def __bool__(self) -> bool:
        return len(self) > 0

    def _items(self) -> list[tuple[str, Value]]:
        return [(each.name, each) for each in self.held() if hasattr(each, "name")]

    def _get(self, name: Value, default: Value = None) -> Value:
        found = self.named(text(name, "a name"))
        return default if found is None else found

    methods: ClassVar[Methods] = {
        "get": _get,
        "keys": lambda self: [name for name, _ in self._items()],
        "values": lambda self: list(self),
        "items": _items,
    }


class Listing(Listed):
    """A list of the parts of another value, with extra methods."""

    def __init__(self, kind: str, held: Callable[[], Sequence[Value]], own: Methods) -> None:
        self.kind = kind
        self._held = held
        self._own = own

    def held(self) -> Sequence[Value]:
        return self._held()

    def attribute(self, name: str) -> Value:
        return Builtin(name, self._own[name]) if name in self._own else super().attribute(name)


class Blocks(Listed):
    """The blocks of one kind by their names, as in `bpy.data.objects`."""

    def __init__(self, kind: str, make: Callable[..., Block], script: Script) -> None:
        self.kind = f"bpy.data.{kind}"
        self.by_name: dict[str, Block] = {}
        self._next: dict[str, int] = {}  # the next number of a name, unless a block has been removed meanwhile
        self.script = script
        self._make = make

    def new(self, name: str, *arguments: Value, **named: Value) -> Value:
        """A new block; its name gets a number if it is taken."""
        block = self._make(self, *arguments, **named)
        block.name = self.free_name(text(name, "the name"))
        self.by_name[block.name] = block
        return block

    def free_name(self, name: str) -> str:
        """The name or, if it is taken, the name with the first free number: "Car.001"."""
        self.script.take_text(len(name))
        if name not in self.by_name:
            return name
        stem = re.sub(r"\.\d+$", "", name) if len(name) < 200 else name
        number = self._next.get(stem, 1)
        while f"{stem}.{number:03}" in self.by_name:
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
        """Remove a block."""
        self.script.check_time()
        if not isinstance(block, Block) or self.by_name.get(block.name) is not block:
            raise RefusalError(f"{describe(block)} is not in {self.kind}")
        del self.by_name[block.name]
        self._next.clear()

    def named(self, name: Value) -> Value:
        return self.by_name.get(name)

    def held(self) -> list[Value]:
        return list(self.by_name.values())

    def __len__(self) -> int:
        return len(self.by_name)

    methods: ClassVar[Methods] = Listed.methods | {
        "new": lambda self, *arguments, **named: self.new(*arguments, **named),
        "remove": lambda self, block, **_: self.remove(block),
    }


class Block(Record):
    """A data block with a name and custom properties."""

    is_key = True

    def __init__(self, owner: Blocks) -> None:
        self.name = ""
        self.owner = owner
        self.script = owner.script
        self.properties: dict[str, Value] = {}

    def __getitem__(self, key: Value) -> Value:
        if key not in self:
            raise RaisedError("KeyError", f"{self.kind} {self.name!r:.60} has no property {describe(key)}")
        return self.properties[key]

    def __setitem__(self, key: Value, value: Value) -> None:
        if value is not None and not isinstance(value, int | float | str | list | tuple):
            raise RefusalError(f"a property of {describe(value)} is not supported")
        self.properties[text(key, "the name of a property")] = value

    def __contains__(self, value: Value) -> bool:
        return isinstance(value, str) and value in self.properties

    def _get(self, name: Value, default: Value = None) -> Value:
        return self.properties.get(text(name, "a name"), default)

    fields: ClassVar[Methods] = {
        **dict.fromkeys(("name", "name_full"), lambda self: self.name),
        "users": lambda _: 1,  # blocks that nothing uses are in no layout anyway
    }
    setters: ClassVar[Methods] = {"name": lambda self, value: self.owner.rename(self, text(value, "the name"))}
    methods: ClassVar[Methods] = {
        "get": _get,
        "keys": lambda self: list(self.properties),
        **dict.fromkeys(("update", "update_tag"), lambda *_: None),
    }


def ignored(*names: str) -> Methods:
    """Setters of attributes without effect on shapes."""
    return dict.fromkeys(names, lambda *_: None)


def unread(of: str, *names: str) -> Methods:
    """Getters of attributes without effect on shapes."""
    return {name: lambda self, name=name: Unread(f"{name} of {of}", self.script) for name in names}
