"""Python's built-in functions that a script may call."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lidardraft.drafting.blender.script.containers import Lazy, Set, iterate, ordered, to_dict
from lidardraft.drafting.blender.script.definitions import CLASS_NAMES, BoundMethod, Function, Instance, ScriptClass
from lidardraft.drafting.blender.script.expressions import attribute_of
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.operators import in_order, to_repr, to_text
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Methods,
    Record,
    TypeFunction,
    Value,
    builtins,
    call,
    checked,
    describe,
    elements,
    is_number,
    is_of,
    length,
    nothing,
    text,
    whole,
)

_CELLS_OF_COLUMN = 20  # the cost of a column of `zip` and `map`
_LONGEST_NUMBER = 40  # characters of a text to convert to a number
_TYPES: dict[str, tuple[type, ...]] = {kind.__name__: (kind,) for kind in (bool, int, float, str, list, tuple, dict)}
_TYPES |= dict.fromkeys(("set", "frozenset"), (Set,))
_NUMBERS: dict[str, type[int] | type[float]] = {"int": int, "float": float}


def builtin_functions(script: Script) -> dict[str, Value]:
    """The functions, and the built-in classes, by name."""
    tables = _of_numbers() | _of_values(script) | _of_collections(script) | _of_functions(script)
    types = {name: TypeFunction(name, tables[name], kinds) for name, kinds in _TYPES.items()}
    return CLASS_NAMES | builtins("", tables) | types


def _of_numbers() -> Methods:
    def parsed(make: type[int] | type[float]) -> Any:
        def number(value: Value = 0, *base: int) -> Value:
            if isinstance(value, str) and len(value) > _LONGEST_NUMBER:
                raise RefusalError(f"a number of {len(value)} characters")
            if not isinstance(value, str | int | float):
                raise RefusalError(f"{describe(value)} is no number")
            return checked(make(value, *base))

        return number

    def rounded(value: Value, digits: Value = None) -> Value:
        return checked(round(value, None if digits is None else whole(digits, "the digits", -18, 18)))

    def power(base: Value, exponent: Value) -> Value:
        if isinstance(exponent, int) and exponent > 64 and isinstance(base, int) and abs(base) > 1:
            raise RefusalError(f"{base} ** {exponent} is too large")
        return checked(pow(base, exponent))

    return {
        "int": parsed(int),
        "float": parsed(float),
        "abs": lambda value: value.attribute("length") if isinstance(value, Record) else abs(value),
        "round": rounded,
        "pow": power,
        "divmod": divmod,
        "range": lambda *bounds: range(*[whole(bound, "a bound of a range") for bound in bounds]),
    }


def _of_values(script: Script) -> Methods:
    def getattr_(owner: Value, name: Value, *default: Value) -> Value:
        name = text(name, "the name of an attribute")
        return default[0] if default and not has(owner, name) else attribute_of(owner, name, script)

    return {
        "bool": lambda value=False: bool(value),
        "str": lambda value="": to_text(value, script),
        "repr": lambda value: to_repr(value, script),
        "print": nothing,
        "isinstance": is_of,
        "type": _type,
        "hasattr": lambda value, name: has(value, text(name, "the name")),
        "getattr": getattr_,
        "callable": lambda value: isinstance(value, Function | Builtin | BoundMethod | ScriptClass),
    }


def _type(value: Value) -> Value:
    if not isinstance(value, Instance):
        raise RefusalError(f"the type of {describe(value)} is not supported")
    return value.of


def has(value: Value, name: str) -> bool:
    """The result of `hasattr`: whether the reader supports the attribute."""
    if isinstance(value, Instance):  # a property is not run
        return value.has_private(name) and value.has(name)
    if not isinstance(value, Record) or name.startswith("_"):
        return False
    try:
        value.attribute(name)
    except RefusalError:
        return False
    return True


def _of_collections(script: Script) -> Methods:
    def as_set(items: Value = ()) -> Set:
        return Set(elements(items, script), script)

    def zipped(*columns: Value, strict: Value = False) -> Value:
        script.take_cells(_CELLS_OF_COLUMN * len(columns))
        parts = [iter(column) if isinstance(column, range) else iterate(column, script) for column in columns]
        return Lazy(zip(*parts, strict=bool(strict)), script)

    def following(items: Value, *default: Value) -> Value:
        if not isinstance(items, Lazy):
            raise RefusalError(f"{describe(items)} is no iterator")
        try:
            return next(items, *default)
        except StopIteration:
            raise RaisedError("StopIteration", "next: there is no value left") from None

    return {
        "len": length,
        "list": lambda items=(): elements(items, script),
        "tuple": lambda items=(): tuple(elements(items, script)),
        "set": as_set,
        "frozenset": as_set,
        "dict": lambda pairs=(), **keywords: to_dict(pairs, keywords, script),
        "enumerate": lambda items, start=0: Lazy(enumerate(iterate(items, script), start), script),
        "zip": zipped,
        "iter": lambda items: items if isinstance(items, Lazy) else Lazy(iterate(items, script), script),
        "next": following,
        "reversed": lambda items: Lazy(iter(elements(items, script)[::-1]), script),
        "any": lambda items: any(iterate(items, script)),
        "all": lambda items: all(iterate(items, script)),
    }


def _of_functions(script: Script) -> Methods:
    def extreme(choose: Any) -> Any:
        def best(*items: Value, key: Value = None, **default: Value) -> Value:
            found = elements(items[0] if len(items) == 1 else items, script)
            if not found and "default" in default:
                return default["default"]
            keys = found if key is None else [call(key, [item], {}, script) for item in found]
            return found[in_order(choose, keys, script)]

        return best

    def total(items: Value, start: Value = 0) -> Value:
        found = elements(items, script)
        if not all(map(is_number, [*found, start])):
            raise RefusalError("sum: only numbers are added up")
        return checked(sum(found, start))

    def mapped(function: Value, *columns: Value) -> Value:
        makes = _NUMBERS.get(function.name) if isinstance(function, Builtin) else None
        if makes and isinstance(columns[0], list) and (numbers := _numbers_of(makes, columns[0])) is not None:
            return Lazy(iter(numbers), script)
        script.take_cells(_CELLS_OF_COLUMN * len(columns))
        rows = zip(*[iterate(each, script) for each in columns], strict=False)
        return Lazy((call(function, list(row), {}, script) for row in rows), script)

    def passing(function: Value, items: Value) -> Iterator[Value]:
        for item in iterate(items, script):
            if item if function is None else call(function, [item], {}, script):
                yield item

    return {
        "map": mapped,
        "filter": lambda function, items: Lazy(passing(function, items), script),
        "sum": total,
        "min": extreme(min),
        "max": extreme(max),
        "sorted": lambda items, *, key=None, reverse=False: ordered(items, key, reverse, script),
    }


def _numbers_of(make: type[int] | type[float], texts: list[Value]) -> list[Value] | None:
    """The numbers of texts; None unless all are short texts of one number."""
    if not set(map(type, texts)) <= {str} or max(map(len, texts), default=0) > _LONGEST_NUMBER:
        return None
    try:
        return list(map(checked, map(make, texts)))
    except ValueError:
        return None
