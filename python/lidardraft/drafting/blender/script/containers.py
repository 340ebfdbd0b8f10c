"""What text, lists, dicts and sets of a script can do, and iterators, whose values are made as they are asked for."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any, ClassVar

from lidardraft.drafting.blender.script.formatting import brace_format, to_text
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.operators import equal, in_order
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Methods,
    Record,
    Value,
    call,
    checked,
    describe,
    dict_key,
    elements,
    place,
    text,
    truth,
    whole,
)

_WIDEST = 200
_CELLS_OF_ITERATOR = 50
_MOVED_IN_A_STEP, _TAKEN_IN_A_STEP = 2000, 50  # elements of a list
_SIMPLE = ("upper", "lower", "title", "capitalize", "strip", "lstrip", "rstrip", "isdigit", "isalpha", "isalnum")
_SEARCHES = ("startswith", "endswith", "find", "rfind", "index", "count", "removeprefix", "removesuffix")
_LINE_ENDS = "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029"
_END, _LAST = object(), object()
_COMBINED: dict[str, Callable[[dict[Value, None], dict[Value, None]], Iterable[Value]]] = {  # members of two sets
    "union": lambda left, right: [*left, *right],
    "intersection": lambda left, right: [member for member in left if member in right],
    "difference": lambda left, right: [member for member in left if member not in right],
    "symmetric_difference": lambda left, right: [
        *(member for member in left if member not in right),
        *(member for member in right if member not in left),
    ],
}
_SIGNS = {ast.BitOr: "union", ast.BitAnd: "intersection", ast.Sub: "difference", ast.BitXor: "symmetric_difference"}


class DefaultDict(dict[Value, Value]):
    """A dict that gets what `factory()` gives for a key that it lacks."""

    def __init__(self, factory: Value, pairs: dict[Value, Value], script: Script) -> None:
        super().__init__(pairs)
        self._factory = factory
        self._script = script

    def __missing__(self, key: Value) -> Value:
        if self._factory is None:
            raise RaisedError("KeyError", f"the key {describe(key)} is not in the dict")
        self._script.take_cells(3)
        return self.setdefault(key, call(self._factory, [], {}, self._script))

    def copy(self) -> DefaultDict:
        return DefaultDict(self._factory, self, self._script)

    __copy__ = copy


class Deque(list[Value]):
    """A list that a script also takes from, and adds to, on the left."""


class Lazy(Record):
    """An iterator: each value is made when it is asked for, as all else may happen between two of them."""

    def __init__(self, values: Iterator[Value], script: Script, kind: str = "an iterator") -> None:
        script.take_cells(_CELLS_OF_ITERATOR)
        self.kind = kind
        self._values = values
        self._script = script
        self._is_running = False

    def next(self, default: Value = _END) -> Value:
        """The value that comes next, or `default` where none does."""
        if self._is_running:
            raise RefusalError(f"{self.kind} that goes on with itself")
        script, levels, line = self._script, self._script.levels, self._script.line
        script.go_deeper(line)
        self._is_running = True
        try:
            value = next(self._values, default)
        except ValueError as error:  # of columns that must be of one length
            raise RaisedError("ValueError", str(error)) from None
        finally:
            self._is_running, script.levels = False, levels
        script.line = line
        if value is _END:
            raise RaisedError("StopIteration", "next: there is no value left")
        return value

    def rest(self) -> Iterator[Value]:
        """All that are left, of which each is gone once it is handed out."""
        while (value := self.next(_LAST)) is not _LAST:
            yield value

    def length(self) -> int:
        raise RefusalError(f"{self.kind} has no length")

    def elements(self) -> list[Value]:
        found = []
        for value in self.rest():
            self._script.take_cells(1)
            found.append(value)
        return found


def iterate(value: Value, script: Script) -> Iterator[Value]:
    """What takes one value after the other out of it: a list may change meanwhile; all who share an iterator go on with
    it."""
    if isinstance(value, Lazy):
        return value.rest()
    if not isinstance(value, list):
        return iter(elements(value, script))
    script.take_cells(len(value))
    return iter(value)


class Set(Record):
    """Members, each of them once, in the order in which they came, so that a script gives the same layout again."""

    kind = "a set"

    def __init__(self, members: Iterable[Value], script: Script) -> None:
        self._members = dict.fromkeys(map(dict_key, members))
        self._script = script
        script.take_cells(3 * len(self._members))

    def elements(self) -> list[Value]:
        return list(self._members)

    def length(self) -> int:
        return len(self._members)

    def contains(self, value: Value) -> bool:
        return dict_key(value) in self._members

    def truth(self) -> bool:
        return bool(self._members)

    def equals(self, other: Value) -> bool:
        if isinstance(other, Set):
            self._script.take_steps(len(self._members) // 4)
            self._script.take_compared(*self._members)
        return isinstance(other, Set) and self._members == other._members

    def text(self, _as_repr: bool) -> str:
        return f"{{{to_text(list(self._members), self._script)[1:-1]}}}" if self._members else "set()"

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        if not isinstance(other, Set) or operator not in _SIGNS:
            return super().binary(operator, other, reflected=reflected)
        return self._combined(_SIGNS[operator], other)

    def in_place(self, operator: type[ast.operator], other: Value) -> Value:
        self._members = self.binary(operator, other)._members
        return self

    def _combined(self, way: str, *others: Value) -> Set:
        members: Iterable[Value] = self._members
        for other in others:
            self._script.take_cells(len(self._members))
            members = _COMBINED[way](dict.fromkeys(members), self._of(other))
        return Set(members, self._script)

    def _of(self, other: Value) -> dict[Value, None]:
        found = elements(other, self._script)
        self._script.take_steps(3)
        self._script.take_cells(3 * len(found))
        return dict.fromkeys(map(dict_key, found))

    def _key(self, member: Value) -> Value:
        self._script.take_cells(3)
        self._script.take_compared(member)
        return dict_key(member)

    def _update(self, *others: Value) -> None:
        for other in others:
            self._members |= self._of(other)

    methods: ClassVar[Methods] = {
        **{way: lambda self, *others, way=way: self._combined(way, *others) for way in _COMBINED},
        "copy": lambda self: self._combined("union"),
        "add": lambda self, member: self._members.setdefault(self._key(member)),
        "update": _update,
        "discard": lambda self, member: self._members.pop(self._key(member), None),
        "remove": lambda self, member: self._members.pop(self._key(member)),
        "clear": lambda self: self._members.clear(),
        "issubset": lambda self, other: not self._combined("difference", other)._members,
        "isdisjoint": lambda self, other: not self._combined("intersection", other)._members,
    }


def take_moved(items: list[Value], places: Value, script: Script) -> None:
    """Count the elements that move or go where those at a place, or within a slice, are taken out or put in."""
    if isinstance(places, slice):
        script.take_steps(len(items) // _TAKEN_IN_A_STEP)
    else:
        behind = -places if places < 0 else len(items) - places
        script.take_steps(min(max(behind, 0), len(items)) // _MOVED_IN_A_STEP)


def _take_pieces(script: Script, value: str, sep: str | None = None, *_: Value, **__: Value) -> None:
    script.take_text(len(value))
    script.take_cells(2 * (len(value) // 2 if sep is None else value.count(text(sep, "the separator"))) + 2)


def _take_replaced(script: Script, value: str, old: str, new: str, *_: Value) -> None:
    script.take_text(2 * len(value) + value.count(old) * len(new))


def _take_padded(script: Script, value: str, width: Value, *_: Value) -> None:
    script.take_text(len(value) + whole(width, "the width", most=_WIDEST))


def _join(script: Script, value: str, parts: Value) -> str:
    words = [text(part, "a part of a text") for part in elements(parts, script)]
    script.take_text(sum(map(len, words)) + len(value) * len(words))
    return value.join(words)


def _format(script: Script, value: str, /, *arguments: Value, **keywords: Value) -> str:
    return brace_format(value, arguments, keywords, script)


def _index(script: Script, value: list[Value] | tuple[Value, ...], wanted: Value) -> int:
    script.take_steps(len(value) // 4)
    for number, item in enumerate(value):
        if equal(item, wanted, script):
            return number
    raise ValueError(f"{describe(wanted)} is not in the list")


def _count(script: Script, value: list[Value] | tuple[Value, ...], wanted: Value) -> int:
    script.take_steps(len(value) // 4)
    return sum(equal(item, wanted, script) for item in value)


def _extend(script: Script, value: list[Value], more: Value) -> None:
    items = elements(more, script)
    script.take_cells(len(value) + len(items))
    value.extend(items)


def _insert(script: Script, value: list[Value], where: Value, item: Value) -> None:
    script.take_cells(1)
    take_moved(value, whole(where, "a place"), script)
    value.insert(where, item)


def _pop(script: Script, value: list[Value], where: Value = -1) -> Value:
    take_moved(value, place(where, len(value), "a list"), script)
    return value.pop(where)


def _sort(script: Script, value: list[Value], *, key: Value = None, reverse: Value = False) -> None:
    value[:] = ordered(value, key, reverse, script)


def ordered(items: Value, key: Value, reverse: Value, script: Script) -> list[Value]:
    """What `sorted` gives: of numbers, of texts, or of flat tuples of them."""
    found = elements(items, script)
    script.take_steps(len(found) if key is None else 3 * len(found))
    keys = found if key is None else [call(key, [item], {}, script) for item in found]
    return [found[place] for place in in_order(partial(sorted, reverse=truth(reverse)), keys, script)]


def _take_key(script: Script, _: Value, key: Value, *__: Value) -> None:
    script.take_cells(3)
    script.take_compared(dict_key(key))


def _listed(kind: Callable[[dict[Value, Value]], Iterable[Value]]) -> Callable[..., list[Value]]:
    def call_(script: Script, value: dict[Value, Value]) -> list[Value]:
        script.take_cells(2 * len(value))
        return list(kind(value))

    return call_


def _most_common(script: Script, value: Counter[Value], n: Value = None) -> list[Value]:
    script.take_steps(len(value))
    script.take_cells(3 * len(value))
    return value.most_common(None if n is None else whole(n, "n"))


_OWN: dict[type, Methods] = {  # the methods that are written here, which get the script and the value first
    str: {"join": _join, "format": _format},
    Deque: {
        "popleft": lambda script, value: _pop(script, value, 0),
        "appendleft": lambda script, value, item: _insert(script, value, 0, item),
    },
    list: {
        **{"index": _index, "count": _count, "extend": _extend, "insert": _insert, "pop": _pop, "sort": _sort},
        "remove": lambda script, value, item: _pop(script, value, _index(script, value, item)),
    },
    tuple: {"index": _index, "count": _count},
    Counter: {
        "most_common": _most_common,
        "update": lambda script, value, items=(): count_into(value, items, script),
    },
    dict: {
        **{"keys": _listed(dict.keys), "values": _listed(dict.values), "items": _listed(dict.items)},
        "update": lambda script, value, more=(), **named: value.update(to_dict(more, named, script)),
    },
}
_COSTS: dict[type, Methods] = {  # what counts the cost of the methods of Python's own that are called after it
    str: {
        **dict.fromkeys(_SIMPLE, lambda script, value, *_: script.take_text(2 * len(value))),
        **dict.fromkeys(_SEARCHES, lambda script, value, *_: script.take_text(len(value))),
        **{"split": _take_pieces, "rsplit": _take_pieces, "replace": _take_replaced},
        "splitlines": lambda script, value: script.take_cells(2 * sum(map(value.count, _LINE_ENDS)) + 2),
        **dict.fromkeys(("zfill", "ljust", "rjust", "center"), _take_padded),
    },
    list: {
        "append": lambda script, *_: script.take_cells(1),
        **dict.fromkeys(("clear", "copy", "reverse"), lambda script, value: script.take_cells(len(value))),
    },
    dict: {
        **dict.fromkeys(("get", "pop", "setdefault"), _take_key),
        **dict.fromkeys(("clear", "copy"), lambda script, value: script.take_cells(3 * len(value))),
    },
}


def method(value: Value, name: str, script: Script) -> Builtin:
    """The method of a text, list, tuple or dict."""
    for kind in type(value).__mro__:
        if (own := _OWN.get(kind, {}).get(name)) is not None:
            return Builtin(name, partial(own, script, value))
        if (cost := _COSTS.get(kind, {}).get(name)) is not None:
            return Builtin(name, partial(_counted, cost, getattr(value, name), script, value))
    raise RefusalError(f"{describe(value)} has no {name!r} that is supported")


def _counted(cost: Any, function: Any, script: Script, value: Value, /, *arguments: Value, **named: Value) -> Value:
    cost(script, value, *arguments, **named)
    return function(*arguments, **named)


def to_dict(pairs: Value, keywords: dict[str, Value], script: Script) -> dict[Value, Value]:
    """What `dict` gives: of another dict, or of pairs of key and value."""
    if isinstance(pairs, dict):
        script.take_cells(3 * len(pairs))
        return {**pairs, **keywords}
    found: dict[Value, Value] = {}
    for pair in elements(pairs, script):
        key, value = elements(pair, script)
        found[dict_key(key)] = value
    script.take_cells(3 * len(found))
    return {**found, **keywords}


def count_into(counter: Counter[Value], items: Value, script: Script) -> None:
    """Add what there is of each of the items, or the numbers of another dict."""
    keys = elements(items, script)
    script.take_steps(len(keys) // 4)
    script.take_cells(3 * len(keys))
    for key in keys:
        number = items[key] if isinstance(items, dict) else 1
        counter[key] = checked(counter.get(dict_key(key), 0) + whole(number, "a count"))
