"""The methods of text, lists, tuples and dicts that a script may call."""

from __future__ import annotations

from collections.abc import Callable

from lidardraft.drafting.script.arithmetic import equal, is_key
from lidardraft.drafting.script.formatting import brace_format
from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.values import (
    Builtin,
    Counter,
    Deque,
    Value,
    checked,
    describe,
    elements,
    take_moved,
    text,
    whole,
)

_WIDEST = 200
_SIMPLE = ("upper", "lower", "title", "capitalize", "strip", "lstrip", "rstrip", "isdigit", "isalpha", "isalnum")
_SEARCHES = ("startswith", "endswith", "find", "rfind", "index", "count", "removeprefix", "removesuffix")


def method(value: Value, name: str, budget: Budget, order: Callable[..., list[Value]]) -> Builtin:
    """The method of a text, list, tuple or dict; `order(items, key, reverse)` is `sorted`."""
    if name == "append" and isinstance(value, list):  # by far the most frequent
        return Builtin(name, lambda item: _append(value, item, budget))
    if isinstance(value, str):
        table = _of_text(value, name, budget)
    elif isinstance(value, list):
        table = _of_list(value, budget, order)
    elif isinstance(value, dict):
        table = _of_dict(value, budget)
        table |= _of_counter(value, budget) if isinstance(value, Counter) else {}
    elif isinstance(value, tuple):
        table = {"index": lambda item: _index(value, item, budget), "count": lambda item: _count(value, item, budget)}
    else:
        table = {}
    if name not in table:
        raise RefusalError(f"{describe(value)} has no {name!r} that is read")
    return Builtin(name, table[name])


def _of_text(value: str, name: str, budget: Budget) -> dict[str, Callable[..., Value]]:
    def counted(function: Callable[..., Value], rounds: int = 1) -> Callable[..., Value]:
        def call(*arguments: Value, **keywords: Value) -> Value:
            for _ in range(rounds):
                budget.take_text(len(value))
            return function(*arguments, **keywords)

        return call

    if name in _SIMPLE or name in _SEARCHES:  # no longer than the text itself
        return {name: counted(getattr(value, name), 2 if name in _SIMPLE else 1)}

    def split(cut: Callable[..., list[str]]) -> Callable[..., list[str]]:
        def call(sep: str | None = None, maxsplit: int = -1) -> list[str]:
            pieces = len(value) // 2 + 1 if sep is None else value.count(text(sep, "the separator")) + 1
            budget.take_cells(2 * pieces)
            return cut(value, sep, maxsplit)

        return call

    def join(parts: Value) -> str:
        words = [text(part, "a part of a text") for part in elements(parts, budget)]
        budget.take_text(sum(map(len, words)) + len(value) * len(words))
        return value.join(words)

    def replace(old: str, new: str, count: int = -1) -> str:
        budget.take_text(len(value) + value.count(old) * len(new) + (len(value) * len(new) if not old else 0))
        return value.replace(old, new, count)

    def padded(pad: Callable[..., str]) -> Callable[..., str]:
        def call(width: int, *fill: str) -> str:
            if whole(width, "the width") > _WIDEST:
                raise RefusalError(f"a width of {width} characters; {_WIDEST} are the most")
            return pad(value, width, *fill)

        return call

    def lines() -> list[str]:
        budget.take_cells(2 * (value.count("\n") + value.count("\r") + 1))
        return value.replace("\r\n", "\n").replace("\r", "\n").removesuffix("\n").split("\n") if value else []

    table: dict[str, Callable[..., Value]] = {
        "split": split(str.split),
        "rsplit": split(str.rsplit),
        "splitlines": lines,
        "join": join,
        "replace": replace,
        "zfill": padded(str.zfill),
        "ljust": padded(str.ljust),
        "rjust": padded(str.rjust),
        "center": padded(str.center),
        "format": lambda *arguments, **keywords: brace_format(value, list(arguments), keywords, budget),
    }
    return {name: counted(table[name])} if name in table else {}


def _of_list(value: list[Value], budget: Budget, order: Callable[..., list[Value]]) -> dict[str, Callable[..., Value]]:
    def extend(more: Value) -> None:
        items = elements(more, budget)
        budget.take_cells(len(value) + len(items))
        value.extend(items)

    def insert(place: Value, item: Value) -> None:
        budget.take_cells(1)
        take_moved(value, whole(place, "a place"), budget)
        value.insert(place, item)

    def pop(place: Value = -1) -> Value:
        if not -len(value) <= whole(place, "a place") < len(value):
            raise RaisedError("IndexError", f"a list of {len(value)} has no place {place}")
        take_moved(value, place, budget)
        return value.pop(place)

    def remove(item: Value) -> None:
        place = _index(value, item, budget)
        take_moved(value, place, budget)
        del value[place]

    def sort(*, key: Value = None, reverse: Value = False) -> None:
        value[:] = order(value, key, reverse)

    def copied() -> list[Value]:
        budget.take_cells(len(value))
        return value.copy()

    def reverse() -> None:
        budget.take_cells(len(value))
        value.reverse()

    left: dict[str, Callable[..., Value]] = {"popleft": lambda: pop(0), "appendleft": lambda item: insert(0, item)}
    return (left if isinstance(value, Deque) else {}) | {
        "extend": extend,
        "insert": insert,
        "remove": remove,
        "pop": pop,
        "clear": value.clear,
        "index": lambda item: _index(value, item, budget),
        "count": lambda item: _count(value, item, budget),
        "sort": sort,
        "reverse": reverse,
        "copy": copied,
    }


def _of_dict(value: dict[Value, Value], budget: Budget) -> dict[str, Callable[..., Value]]:
    def as_key(key: Value) -> Value:
        if not is_key(key):
            raise RefusalError(f"{describe(key)} cannot be a key")
        budget.take_compared(key)
        return key

    def setdefault(key: Value, default: Value = None) -> Value:
        budget.take_cells(3)
        return value.setdefault(as_key(key), default)

    def update(more: Value = None, **keywords: Value) -> None:
        if not isinstance(more, dict | None):
            raise RefusalError(f"{describe(more)} is no dict")
        budget.take_cells(3 * (len(more or {}) + len(keywords)))
        value.update(more or {}, **keywords)

    def listed(make: Callable[[], Value]) -> Callable[[], list[Value]]:
        def call() -> list[Value]:
            budget.take_cells(2 * len(value))
            return list(make())

        return call

    def copied() -> dict[Value, Value]:
        budget.take_cells(3 * len(value))
        return value.copy()

    return {
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


def _of_counter(value: Counter, budget: Budget) -> dict[str, Callable[..., Value]]:
    def most_common(n: Value = None) -> list[Value]:
        budget.take_steps(len(value))
        budget.take_cells(3 * len(value))
        numbered = sorted(value.items(), key=lambda pair: pair[1], reverse=True)
        return numbered if n is None else numbered[: max(whole(n, "n"), 0)]

    return {"most_common": most_common, "update": lambda items=(): count_into(value, items, budget)}


def count_into(counter: Counter, items: Value, budget: Budget) -> None:
    """Add what there is of each of the items, or the numbers of another dict."""
    keys = elements(items, budget)
    budget.take_steps(len(keys) // 4)
    budget.take_cells(3 * len(keys))
    for key in keys:
        if not is_key(key):
            raise RefusalError(f"{describe(key)} cannot be a key")
        number = items[key] if isinstance(items, dict) else 1
        counter[key] = checked(counter.get(key, 0) + whole(number, "a count"))


def _append(items: list[Value], item: Value, budget: Budget) -> None:
    budget.take_cells(1)
    items.append(item)


def _index(items: list[Value] | tuple[Value, ...], wanted: Value, budget: Budget) -> int:
    budget.take_steps(len(items) // 4)
    for place, item in enumerate(items):
        if equal(item, wanted, budget):
            return place
    raise RaisedError("ValueError", f"{describe(wanted)} is not in the list")


def _count(items: list[Value] | tuple[Value, ...], wanted: Value, budget: Budget) -> int:
    budget.take_steps(len(items) // 4)
    return sum(equal(item, wanted, budget) for item in items)
