"""What text, lists, dicts and sets of a script can do, and iterators, whose values are made as they are asked for."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import ClassVar

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
    text,
    truth,
    whole,
)

_WIDEST = 200
_CELLS_OF_ITERATOR = 50
_MOVED_IN_A_STEP, _TAKEN_IN_A_STEP = 2000, 50  # elements of a list
_SIMPLE = ("upper", "lower", "title", "capitalize", "strip", "lstrip", "rstrip", "isdigit", "isalpha", "isalnum")
_SEARCHES = ("startswith", "endswith", "find", "rfind", "index", "count", "removeprefix", "removesuffix")
_END, _LAST = object(), object()


class DefaultDict(dict[Value, Value]):
    """A dict that gets what `factory()` gives for a key that it lacks."""

    factory: Value = None


class Counter(dict[Value, Value]):
    """A dict of numbers, in which what it lacks has the number 0."""


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
        if not isinstance(other, Set) or operator not in _OPERATORS:
            return super().binary(operator, other, reflected=reflected)
        return _OPERATORS[operator](self, other)

    def in_place(self, operator: type[ast.operator], other: Value) -> Value:
        self._members = self.binary(operator, other)._members
        return self

    def _key(self, member: Value) -> Value:
        self._script.take_compared(member)
        return dict_key(member)

    def _add(self, member: Value) -> None:
        self._script.take_cells(3)
        self._members[self._key(member)] = None

    def _update(self, *others: Value) -> None:
        for other in others:
            self._members |= self._of(other)

    def _remove(self, member: Value) -> None:
        if self._key(member) not in self._members:
            raise RaisedError("KeyError", f"{describe(member)} is not in the set")
        del self._members[member]

    def _of(self, other: Value) -> dict[Value, None]:
        found = elements(other, self._script)
        self._script.take_steps(3)
        self._script.take_cells(3 * len(found))
        return dict.fromkeys(map(dict_key, found))

    def _union(self, *others: Value) -> Set:
        return Set([*self._members, *(item for each in others for item in self._of(each))], self._script)

    def _filtered(self, other: Value, shared: bool) -> Set:
        others = self._of(other)
        self._script.take_cells(len(self._members))
        return Set([member for member in self._members if (member in others) == shared], self._script)

    methods: ClassVar[Methods] = {
        "add": _add,
        "update": _update,
        "discard": lambda self, member: self._members.pop(self._key(member), None),
        "remove": _remove,
        "clear": lambda self: self._members.clear(),
        "copy": _union,
        "union": _union,
        "intersection": lambda self, other: self._filtered(other, True),
        "difference": lambda self, other: self._filtered(other, False),
        "issubset": lambda self, other: not self._filtered(other, False)._members,
        "isdisjoint": lambda self, other: not self._filtered(other, True)._members,
    }


_OPERATORS: dict[type[ast.operator], Callable[[Set, Set], Set]] = {
    ast.BitOr: Set._union,
    ast.BitAnd: lambda left, right: left._filtered(right, True),
    ast.Sub: lambda left, right: left._filtered(right, False),
    ast.BitXor: lambda left, right: left._filtered(right, False)._union(right._filtered(left, False)),
}


def take_moved(items: list[Value], places: Value, script: Script) -> None:
    """Count the elements that move or go where those at a place, or within a slice, are taken out or put in."""
    if isinstance(places, slice):
        script.take_steps(len(items) // _TAKEN_IN_A_STEP)
    else:
        behind = -places if places < 0 else len(items) - places
        script.take_steps(min(max(behind, 0), len(items)) // _MOVED_IN_A_STEP)


def method(value: Value, name: str, script: Script) -> Builtin:
    """The method of a text, list, tuple or dict."""
    if name == "append" and isinstance(value, list):  # by far the most frequent
        return Builtin(name, lambda item: _append(value, item, script))
    table: Methods = {}
    if isinstance(value, str):
        table = _of_text(value, name, script)
    elif isinstance(value, list):
        table = _of_list(value, script)
    elif isinstance(value, dict):
        table = _of_dict(value, script)
    elif isinstance(value, tuple):
        table = _searches(value, script)
    if name not in table:
        raise RefusalError(f"{describe(value)} has no {name!r} that is supported")
    return Builtin(name, table[name])


def _of_text(value: str, name: str, script: Script) -> Methods:
    def counted(function: Callable[..., Value], rounds: int = 1) -> Callable[..., Value]:
        def call_(*arguments: Value, **keywords: Value) -> Value:
            for _ in range(rounds):
                script.take_text(len(value))
            return function(*arguments, **keywords)

        return call_

    if name in _SIMPLE or name in _SEARCHES:  # no longer than the text itself
        return {name: counted(getattr(value, name), 2 if name in _SIMPLE else 1)}

    def split(cut: Callable[..., list[str]]) -> Callable[..., list[str]]:
        def call_(sep: str | None = None, maxsplit: int = -1) -> list[str]:
            pieces = len(value) // 2 + 1 if sep is None else value.count(text(sep, "the separator")) + 1
            script.take_cells(2 * pieces)
            return cut(value, sep, maxsplit)

        return call_

    def join(parts: Value) -> str:
        words = [text(part, "a part of a text") for part in elements(parts, script)]
        script.take_text(sum(map(len, words)) + len(value) * len(words))
        return value.join(words)

    def replace(old: str, new: str, count: int = -1) -> str:
        script.take_text(len(value) + value.count(old) * len(new) + (len(value) * len(new) if not old else 0))
        return value.replace(old, new, count)

    def padded(pad: Callable[..., str]) -> Callable[..., str]:
        return lambda width, *fill: pad(value, whole(width, "the width", most=_WIDEST), *fill)

    def lines() -> list[str]:
        script.take_cells(2 * (value.count("\n") + value.count("\r") + 1))
        return value.replace("\r\n", "\n").replace("\r", "\n").removesuffix("\n").split("\n") if value else []

    table: Methods = {"split": split(str.split), "rsplit": split(str.rsplit), "splitlines": lines}
    table |= {pad: padded(getattr(str, pad)) for pad in ("zfill", "ljust", "rjust", "center")}
    table |= {"join": join, "replace": replace}
    table["format"] = lambda *arguments, **keywords: brace_format(value, arguments, keywords, script)
    return {name: counted(table[name])} if name in table else {}


def _searches(value: list[Value] | tuple[Value, ...], script: Script) -> Methods:
    def index(wanted: Value) -> int:
        script.take_steps(len(value) // 4)
        for place, item in enumerate(value):
            if equal(item, wanted, script):
                return place
        raise RaisedError("ValueError", f"{describe(wanted)} is not in the list")

    def count(wanted: Value) -> int:
        script.take_steps(len(value) // 4)
        return sum(equal(item, wanted, script) for item in value)

    return {"index": index, "count": count}


def _append(items: list[Value], item: Value, script: Script) -> None:
    script.take_cells(1)
    items.append(item)


def _of_list(value: list[Value], script: Script) -> Methods:
    searches = _searches(value, script)

    def extend(more: Value) -> None:
        items = elements(more, script)
        script.take_cells(len(value) + len(items))
        value.extend(items)

    def insert(place: Value, item: Value) -> None:
        script.take_cells(1)
        take_moved(value, whole(place, "a place"), script)
        value.insert(place, item)

    def pop(place: Value = -1) -> Value:
        if not -len(value) <= whole(place, "a place") < len(value):
            raise RaisedError("IndexError", f"a list of {len(value)} has no place {place}")
        take_moved(value, place, script)
        return value.pop(place)

    def remove(item: Value) -> None:
        pop(searches["index"](item))

    def sort(*, key: Value = None, reverse: Value = False) -> None:
        value[:] = ordered(value, key, reverse, script)

    def copied() -> list[Value]:
        script.take_cells(len(value))
        return value.copy()

    def reverse() -> None:
        script.take_cells(len(value))
        value.reverse()

    left: Methods = {"popleft": lambda: pop(0), "appendleft": lambda item: insert(0, item)}
    return (left if isinstance(value, Deque) else {}) | {
        **searches,
        "extend": extend,
        "insert": insert,
        "remove": remove,
        "pop": pop,
        "clear": value.clear,
        "sort": sort,
        "reverse": reverse,
        "copy": copied,
    }


def ordered(items: Value, key: Value, reverse: Value, script: Script) -> list[Value]:
    """What `sorted` gives: of numbers, of texts, or of flat tuples of them."""
    found = elements(items, script)
    script.take_steps(len(found) if key is None else 3 * len(found))
    keys = found if key is None else [call(key, [item], {}, script) for item in found]
    return [found[place] for place in in_order(partial(sorted, reverse=truth(reverse)), keys, script)]


def _of_dict(value: dict[Value, Value], script: Script) -> Methods:
    def as_key(key: Value) -> Value:
        script.take_compared(dict_key(key))
        return key

    def setdefault(key: Value, default: Value = None) -> Value:
        script.take_cells(3)
        return value.setdefault(as_key(key), default)

    def update(more: Value = (), **keywords: Value) -> None:
        value.update(to_dict(more, keywords, script))

    def listed(make: Callable[[], Iterable[Value]]) -> Callable[[], list[Value]]:
        def call_() -> list[Value]:
            script.take_cells(2 * len(value))
            return list(make())

        return call_

    def copied() -> dict[Value, Value]:
        script.take_cells(3 * len(value))
        return value.copy()

    def most_common(n: Value = None) -> list[Value]:
        script.take_steps(len(value))
        script.take_cells(3 * len(value))
        numbered = sorted(value.items(), key=lambda pair: pair[1], reverse=True)
        return numbered if n is None else numbered[: max(whole(n, "n"), 0)]

    table: Methods = {
        "get": lambda key, default=None: value.get(as_key(key), default),
        "keys": listed(value.keys),
        "values": listed(value.values),
        "items": listed(value.items),
        "pop": lambda key, *default: value.pop(as_key(key), *default),
        "setdefault": setdefault,
        "update": update,
        "clear": value.clear,
        "copy": copied,
    }
    if isinstance(value, Counter):
        table |= {"most_common": most_common, "update": lambda items=(): count_into(value, items, script)}
    return table


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


def count_into(counter: Counter, items: Value, script: Script) -> None:
    """Add what there is of each of the items, or the numbers of another dict."""
    keys = elements(items, script)
    script.take_steps(len(keys) // 4)
    script.take_cells(3 * len(keys))
    for key in keys:
        number = items[key] if isinstance(items, dict) else 1
        counter[key] = checked(counter.get(dict_key(key), 0) + whole(number, "a count"))
