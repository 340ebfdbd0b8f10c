"""The functions that Python has without an import, those that a script may call."""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Iterator as Going
from typing import Any

from lidardraft.drafting.script.arithmetic import is_key
from lidardraft.drafting.script.classes import BoundMethod, Instance, ScriptClass
from lidardraft.drafting.script.formatting import to_text
from lidardraft.drafting.script.frame import Function
from lidardraft.drafting.script.iterators import Iterator, Lazy, going, iterator, next_value
from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.sets import Set
from lidardraft.drafting.script.values import (
    MOST_TYPES,
    Builtin,
    KindOfRecord,
    Record,
    Type,
    TypeFunction,
    Value,
    checked,
    describe,
    elements,
    is_number,
    length,
    text,
    truth,
    whole,
)

_LONGEST_NUMBER = 40  # characters of a text that becomes a number
_TYPES: dict[str, tuple[type, ...]] = {kind.__name__: (kind,) for kind in (bool, int, float, str, list, tuple, dict)}
_TYPES |= dict.fromkeys(("set", "frozenset"), (Set,))
_NUMBERS: dict[str, type[int] | type[float]] = {"int": int, "float": float}
Call = Callable[[Value, list[Value]], Value]


def builtin_functions(budget: Budget, call: Call) -> dict[str, Builtin]:
    """The functions by their names; `call(function, arguments)` calls a function of the script."""
    tables = (_of_numbers(budget), _of_collections(budget), _of_order(budget, call))
    return {
        name: (TypeFunction if name in _TYPES else Builtin)(name, function)
        for table in tables
        for name, function in table.items()
    }


def _of_numbers(budget: Budget) -> dict[str, Callable[..., Value]]:
    def parsed(make: type[int] | type[float]) -> Callable[..., Value]:
        def number(value: Value = 0, *base: int) -> Value:
            if isinstance(value, str) and len(value) > _LONGEST_NUMBER:
                raise RefusalError(f"a number of {len(value)} characters")
            if not isinstance(value, str | int | float):
                raise RefusalError(f"{describe(value)} is no number")
            return checked(make(value, *base))

        return number

    def rounded(value: Value, digits: Value = None) -> Value:
        if digits is not None and not -18 <= whole(digits, "the digits") <= 18:
            raise RefusalError(f"round to {digits} digits")
        return checked(round(value, digits))

    def power(base: Value, exponent: Value) -> Value:
        if isinstance(exponent, int) and exponent > 64 and isinstance(base, int) and abs(base) > 1:
            raise RefusalError(f"{base} ** {exponent} is too large")
        return checked(pow(base, exponent))

    def numbers(*arguments: Value) -> range:
        return range(*[whole(argument, "a bound of a range") for argument in arguments])

    return {
        "int": parsed(int),
        "float": parsed(float),
        "bool": lambda value=False: truth(value),
        "abs": lambda value: abs(value) if is_number(value) else value.attribute("length"),
        "round": rounded,
        "pow": power,
        "divmod": lambda a, b: divmod(a, b) if is_number(a) and is_number(b) else None,
        "range": numbers,
        "str": lambda value="": to_text(value, budget),
        "repr": lambda value: to_text([value], budget)[1:-1],
        "print": lambda *_, **__: None,
        "isinstance": _isinstance,
        "type": _type,
        "hasattr": lambda value, name: has(value, text(name, "the name")),
        "callable": lambda value: isinstance(value, Function | Builtin | BoundMethod | ScriptClass),
    }


def _numbers_of(make: type[int] | type[float], texts: list[Value]) -> list[Value] | None:
    """The numbers that texts say; None where these are not all short texts that say one."""
    if not set(map(type, texts)) <= {str} or max(map(len, texts), default=0) > _LONGEST_NUMBER:
        return None
    try:
        return list(map(checked, map(make, texts)))
    except ValueError:
        return None


def _isinstance(value: Value, kinds: Value) -> bool:
    if isinstance(kinds, tuple) and len(kinds) > MOST_TYPES:
        raise RefusalError(f"isinstance of {len(kinds)} kinds; {MOST_TYPES} are the most")
    asked = kinds if isinstance(kinds, tuple) else (kinds,)
    for kind in [each for one in asked for each in (one.types() if isinstance(one, Type) else (one,))]:
        if kind is None:
            found = value is None
        elif isinstance(kind, ScriptClass):
            found = isinstance(value, Instance) and value.of.derived_from(kind)
        elif isinstance(kind, KindOfRecord):
            found = isinstance(value, kind.of)
        else:
            found = isinstance(kind, Builtin) and isinstance(value, _TYPES.get(kind.name, ()))
        if found:
            return True
    return False


def _type(value: Value) -> Value:
    if not isinstance(value, Instance):
        raise RefusalError(f"the type of {describe(value)} is not read")
    return value.of


def has(value: Value, name: str) -> bool:
    """What `hasattr` says of a value of ours: whether a script that reads the attribute is read on."""
    if isinstance(value, Instance):  # a property is not run
        return value.has_private(name) and value.has(name)
    if not isinstance(value, Record) or name.startswith("_"):
        return False
    try:
        value.attribute(name)
    except RefusalError:
        return False
    return True


def _counted(rows: Going[tuple[Value, ...]], budget: Budget) -> Going[Value]:
    for row in rows:
        budget.take_cells(1 + len(row))
        yield row


def _rows(columns: list[Going[Value]], strict: bool) -> Going[tuple[Value, ...]]:
    try:
        yield from zip(*columns, strict=strict)
    except ValueError:
        raise _not_of_the_same_length() from None


def _not_of_the_same_length() -> RaisedError:
    return RaisedError("ValueError", "zip: the lists are not of the same length")


def _of_collections(budget: Budget) -> dict[str, Callable[..., Value]]:
    def as_dict(pairs: Value = (), **keywords: Value) -> dict[Value, Value]:
        if isinstance(pairs, dict):
            budget.take_cells(3 * len(pairs))
            return {**pairs, **keywords}
        found: dict[Value, Value] = {}
        for pair in elements(pairs, budget):
            key, value = elements(pair, budget)
            if not is_key(key):
                raise RefusalError(f"{describe(key)} cannot be a key")
            found[key] = value
        budget.take_cells(3 * len(found))
        return {**found, **keywords}

    def as_set(items: Value = ()) -> Set:
        return Set(elements(items, budget), budget)

    def numbered(items: Value, start: Value = 0) -> Value:
        if isinstance(items, Lazy):
            return Lazy(_counted(enumerate(items.rest(), whole(start, "the start")), budget), budget)
        found = elements(items, budget)
        budget.take_cells(3 * len(found))
        return list(enumerate(found, whole(start, "the start")))

    def parts_of(columns: tuple[Value, ...]) -> list[Going[Value]]:
        return [iter(column) if isinstance(column, range) else going(column, budget) for column in columns]

    def zipped(*columns: Value, strict: Value = False) -> Value:
        if not columns:
            return []
        budget.take_steps(2 * len(columns))
        if any(isinstance(column, Lazy) for column in columns):
            return Lazy(_counted(_rows(parts_of(columns), truth(strict)), budget), budget)
        lengths = [column.left() if isinstance(column, Iterator) else length(column) for column in columns]
        if truth(strict) and len({*lengths}) > 1:
            raise _not_of_the_same_length()
        budget.take_cells(3 * min(lengths))
        return list(zip(*parts_of(columns), strict=False))

    return {
        "len": length,
        "list": lambda items=(): elements(items, budget),
        "tuple": lambda items=(): tuple(elements(items, budget)),
        "set": as_set,
        "dict": as_dict,
        "enumerate": numbered,
        "zip": zipped,
        "frozenset": as_set,
        "iter": lambda items: iterator(items, budget),
        "next": lambda items, *default: next_value(items, default),
        "reversed": lambda items: elements(items, budget)[::-1],
        "any": lambda items: any(map(truth, going(items, budget))),
        "all": lambda items: all(map(truth, going(items, budget))),
    }


def _check_order(keys: list[Value], budget: Budget) -> None:
    """Count what it takes to compare keys; raises `RefusalError` where they have no order."""
    if not all(is_key(each) and each is not None for each in keys):
        raise RefusalError("values without an order")
    parts = [part for each in keys for part in (each if isinstance(each, tuple) else (each,))]
    budget.take_compared(*parts)


def ordered(items: Value, key: Value, reverse: Value, budget: Budget, call: Call) -> list[Value]:
    """What `sorted` gives: of numbers, of texts, or of flat tuples of them."""
    found = elements(items, budget)
    budget.take_steps(len(found) if key is None else 3 * len(found))
    keys = found if key is None else [call(key, [item]) for item in found]
    _check_order(keys, budget)
    places = sorted(range(len(found)), key=keys.__getitem__, reverse=truth(reverse))
    return [found[place] for place in places]


def _of_order(budget: Budget, call: Call) -> dict[str, Callable[..., Value]]:
    def extreme(choose: Callable[..., Value]) -> Callable[..., Value]:
        def best(*items: Value, key: Value = None, **default: Value) -> Value:
            found = elements(items[0] if len(items) == 1 else items, budget)
            if not found and "default" in default:
                return default["default"]
            budget.take_steps(0 if key is None else 2 * len(found))
            keys = found if key is None else [call(key, [item]) for item in found]
            _check_order(keys, budget)
            return found[choose(range(len(found)), key=keys.__getitem__)]

        return best

    def total(items: Value, start: Value = 0) -> Value:
        found = elements(items, budget)
        budget.take_steps(len(found) // 8)
        if not all(map(is_number, [*found, start])):
            raise RefusalError("sum: only numbers are added up")
        return checked(sum(found, start))

    def results(function: Value, rows: Going[tuple[Value, ...]]) -> Going[Value]:
        for row in rows:
            budget.take_steps(2)
            yield call(function, list(row))

    def mapped(function: Value, *columns: Value) -> Value:
        if any(isinstance(column, Lazy) for column in columns):
            budget.take_steps(2 * len(columns))
            return Lazy(results(function, _rows([going(each, budget) for each in columns], strict=False)), budget)
        lists = [elements(column, budget) for column in columns]
        shortest = min(map(len, lists))
        if isinstance(function, Builtin) and function.name in _NUMBERS and len(lists) == 1:
            budget.take_steps(shortest // 4)  # data in a text is as quick as data in a list
            if (numbers := _numbers_of(_NUMBERS[function.name], lists[0])) is not None:
                return numbers
        budget.take_steps(2 * shortest)
        return [call(function, [column[k] for column in lists]) for k in range(shortest)]

    def passing(function: Value, items: Going[Value]) -> Going[Value]:
        for item in items:
            budget.take_steps(2)
            if truth(item if function is None else call(function, [item])):
                yield item

    def kept(function: Value, items: Value) -> Value:
        if isinstance(items, Lazy):
            return Lazy(passing(function, items.rest()), budget)
        return list(passing(function, iter(elements(items, budget))))

    table: dict[str, Any] = {"map": mapped, "filter": kept, "sum": total, "min": extreme(min), "max": extreme(max)}
    table["sorted"] = lambda items, *, key=None, reverse=False: ordered(items, key, reverse, budget, call)
    return table
