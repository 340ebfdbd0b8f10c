"""Methods of a script's text, lists, dicts and sets, and iterators, which make their values on demand."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, MutableSet
from functools import partial, reduce
from typing import ClassVar

from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.operators import brace_format, equal, in_order, to_text
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Methods,
    Record,
    Value,
    call,
    describe,
    dict_key,
    elements,
    text,
    whole,
)

_WIDEST = 200  # characters of padded text
_CELLS_OF_ITERATOR = 20
_PYTHONS: dict[type, tuple[str, ...]] = {  # Python's methods with results no larger than their input
    str: (
        *("upper", "lower", "title", "capitalize", "strip", "lstrip", "rstrip", "isdigit", "isalpha", "isalnum"),
        *("startswith", "endswith", "find", "rfind", "index", "count", "removeprefix", "removesuffix"),
        *("split", "rsplit", "splitlines"),
    ),
    list: ("append", "clear", "copy", "insert", "reverse"),
    dict: ("clear", "copy"),
}
_COMBINED = {"union": operator.or_, "intersection": operator.and_, "difference": operator.sub}
_COMBINED |= {"symmetric_difference": operator.xor}


class Lazy(Record):
    """An iterator: each value is made on demand, since other code may run between two values."""

    kind = "an iterator"

    def __init__(self, values: Iterator[Value], script: Script) -> None:
        script.take_cells(_CELLS_OF_ITERATOR)
        self._values = values
        self._script = script
        self._is_running = False

    def __iter__(self) -> Iterator[Value]:
        return self

    def __next__(self) -> Value:
        if self._is_running:
            raise RefusalError(f"{self.kind} that goes on with itself")
        script, levels, line = self._script, self._script.levels, self._script.line
        script.go_deeper(line)
        self._is_running = True
        try:
            value = next(self._values)
        except ValueError as error:  # columns of different lengths
            raise RaisedError("ValueError", str(error)) from None
        finally:
            self._is_running, script.levels = False, levels
        script.line = line
        return value


def iterate(value: Value, script: Script) -> Iterator[Value]:
    """An iterator over a value. A list may change meanwhile; all users of an iterator share its position."""
    if isinstance(value, Lazy):
        return value
    if not isinstance(value, list):
        return iter(elements(value, script))
    script.take_cells(len(value))
    return iter(value)


class Set(Record, MutableSet[Value]):
    """A set in insertion order, so that a script always gives the same layout."""

    kind = "a set"
    only_alike = True

    def __init__(self, members: Iterable[Value], script: Script) -> None:
        self._members = dict.fromkeys(map(dict_key, members))
        self._script = script
        script.take_cells(3 * len(self._members))

    def _from_iterable(self, members: Iterable[Value]) -> Set:  # type: ignore[override]
        return Set(members, self._script)

    def __contains__(self, value: Value) -> bool:
        return dict_key(value) in self._members

    def __iter__(self) -> Iterator[Value]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    def __bool__(self) -> bool:
        return bool(self._members)

    def add(self, value: Value) -> None:
        self._members.setdefault(dict_key(value))

    def discard(self, value: Value) -> None:
        self._members.pop(dict_key(value), None)

    def text(self, _as_repr: bool) -> str:
        return f"{{{to_text(list(self), self._script)[1:-1]}}}" if self else "set()"

    def _combined(self, way: Callable[[Value, Value], Value], *others: Value) -> Set:
        return reduce(way, [self._of(other) for other in others], self._of(self))

    def _of(self, other: Value) -> Set:
        return Set(elements(other, self._script), self._script)

    def _update(self, *others: Value) -> None:
        for other in others:
            self |= self._of(other)

    methods: ClassVar[Methods] = {
        **{name: lambda self, *others, way=way: self._combined(way, *others) for name, way in _COMBINED.items()},
        "copy": lambda self: self._of(self),
        "add": add,
        "update": _update,
        "discard": discard,
        "remove": lambda self, member: self._members.pop(dict_key(member)),
        "clear": lambda self: self._members.clear(),
        "issubset": lambda self, other: self <= self._of(other),
        "isdisjoint": lambda self, other: self.isdisjoint(self._of(other)),
    }


def _replace(script: Script, value: str, old: str, new: str, *count: Value) -> str:
    script.take_text(len(value) + value.count(old) * len(new))
    return value.replace(old, new, *count)


def _join(script: Script, value: str, parts: Value) -> str:
    words = [text(part, "a part of a text") for part in elements(parts, script)]
    script.take_text(sum(map(len, words)) + len(value) * len(words))
    return value.join(words)


def _format(script: Script, value: str, /, *arguments: Value, **keywords: Value) -> str:
    return brace_format(value, arguments, keywords, script)


def _index(script: Script, value: list[Value] | tuple[Value, ...], wanted: Value) -> int:
    for number, item in enumerate(value):
        if equal(item, wanted, script):
            return number
    raise ValueError(f"{describe(wanted)} is not in the list")


def _count(script: Script, value: list[Value] | tuple[Value, ...], wanted: Value) -> int:
    return sum(equal(item, wanted, script) for item in value)


def _extend(script: Script, value: list[Value], more: Value) -> None:
    value.extend(elements(more, script))


def _sort(script: Script, value: list[Value], *, key: Value = None, reverse: Value = False) -> None:
    value[:] = ordered(value, key, reverse, script)


def ordered(items: Value, key: Value, reverse: Value, script: Script) -> list[Value]:
    """The result of `sorted`: for numbers, texts, or flat tuples of them."""
    found = elements(items, script)
    keys = found if key is None else [call(key, [item], {}, script) for item in found]
    return [found[place] for place in in_order(partial(sorted, reverse=bool(reverse)), keys, script)]


_OWN: dict[type, Methods] = {  # own implementations, which get the script and the value first
    str: {
        **{"join": _join, "format": _format, "replace": _replace},
        **{
            name: lambda _, value, width, *fill, name=name: getattr(value, name)(
                whole(width, "the width", most=_WIDEST), *fill
            )
            for name in ("zfill", "ljust", "rjust", "center")
        },
    },
    list: {
        **{"index": _index, "count": _count, "extend": _extend, "sort": _sort},
        "pop": lambda _, value, where=-1: value.pop(where),
        "remove": lambda script, value, item: value.pop(_index(script, value, item)),
    },
    tuple: {"index": _index, "count": _count},
    dict: {
        **{
            name: lambda _, value, key, *default, name=name: getattr(value, name)(dict_key(key), *default)
            for name in ("get", "pop", "setdefault")
        },
        "keys": lambda script, value: elements(value, script),
        "values": lambda script, value: elements(tuple(value.values()), script),
        "items": lambda script, value: elements(tuple(value.items()), script),
        "update": lambda script, value, more=(), **named: value.update(to_dict(more, named, script)),
    },
}


def method(value: Value, name: str, script: Script) -> Builtin:
    """The method of a text, list, tuple or dict."""
    for kind in type(value).__mro__:
        if (own := _OWN.get(kind, {}).get(name)) is not None:
            return Builtin(name, partial(own, script, value))
        if name in _PYTHONS.get(kind, ()):
            return Builtin(name, partial(_counted, getattr(value, name), script))
    raise RefusalError(f"{describe(value)} has no {name!r} that is supported")


def _counted(function: Callable[..., Value], script: Script, /, *arguments: Value, **named: Value) -> Value:
    script.take_made(made := function(*arguments, **named))
    return made


def to_dict(pairs: Value, keywords: dict[str, Value], script: Script) -> dict[Value, Value]:
    """The result of `dict`: from another dict, or from pairs of key and value."""
    found: dict[Value, Value] = pairs
    if not isinstance(pairs, dict):
        rows = [elements(pair, script) for pair in elements(pairs, script)]
        found = {dict_key(key): value for key, value in rows}
    script.take_made(found)
    return {**found, **keywords}
