"""Operators on values of a script: what Python makes of them, if it is not too large."""

from __future__ import annotations

import ast
import contextlib
import operator
from collections.abc import Callable

from lidardraft.drafting.blender.script.formatting import percent_format
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import (
    Record,
    Value,
    checked,
    describe,
    elements,
    is_key,
    is_number,
    not_calculated,
    truth,
)

_LONGEST_SHIFT = 64
_NUMBERS: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv},
    **{ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow},
    **{ast.LShift: operator.lshift, ast.RShift: operator.rshift},
    **{ast.BitAnd: operator.and_, ast.BitOr: operator.or_, ast.BitXor: operator.xor},
}
_ORDERS: dict[type, Callable[..., bool]]
_ORDERS = {ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge}


def binary(kind: type[ast.operator], left: Value, right: Value, script: Script) -> Value:
    """The result of an operator between two values."""
    if isinstance(left, Record):
        return left.binary(kind, right)
    if kind is ast.Mod and isinstance(left, str):
        return percent_format(left, right, script)
    if isinstance(right, Record):
        return right.binary(kind, left, reflected=True)
    if is_number(left) and is_number(right) and kind in _NUMBERS:
        return _of_numbers(kind, left, right)
    if kind is ast.Add and any(isinstance(left, each) and isinstance(right, each) for each in (str, list, tuple)):
        script.take_made(joined := left + right)
        return joined
    if kind is ast.BitOr and type(left) is type(right) is dict:
        script.take_made(joined := {**left, **right})
        return joined
    if kind is ast.Mult:
        if isinstance(left, int):
            left, right = right, left
        if isinstance(left, str | list | tuple) and isinstance(right, int):
            (script.take_text if isinstance(left, str) else script.take_cells)(len(left) * max(right, 0))
            return left * right
    raise not_calculated(kind, left, right)


def in_place(kind: type[ast.operator], left: Value, right: Value, script: Script) -> Value:
    """The result of `left += right` and the like: a list, a dict or a set changes itself, whoever else has it."""
    if isinstance(left, Record):
        return left.in_place(kind, right)
    if isinstance(left, list) and kind is ast.Add:
        right = elements(right, script)
    result = binary(kind, left, right, script)
    if isinstance(left, list):
        left[:] = result
    elif isinstance(left, dict):
        left.update(result)
    else:
        return result
    return left


def _of_numbers(kind: type[ast.operator], left: Value, right: Value) -> Value:
    if kind is ast.Pow and isinstance(left, int) and isinstance(right, int):
        if right > _LONGEST_SHIFT and abs(left) > 1:
            raise RefusalError(f"{left} ** {right} is too large")
    elif kind in (ast.LShift, ast.RShift) and isinstance(right, int) and right > _LONGEST_SHIFT:
        raise RefusalError(f"a shift by {right} bits")
    try:
        return checked(_NUMBERS[kind](left, right))
    except TypeError:
        raise not_calculated(kind, left, right) from None
    except (ArithmeticError, ValueError) as error:
        raise RaisedError(type(error).__name__, f"{error}") from None


def unary(kind: type[ast.unaryop], value: Value) -> Value:
    """The result of a sign, `not` or `~`."""
    if kind is ast.Not:
        return not truth(value)
    if isinstance(value, Record) and kind is ast.USub:
        return value.negative()
    if not is_number(value) or (kind is ast.Invert and isinstance(value, float)):
        raise RefusalError(f"{describe(value)} cannot have this sign")
    return -value if kind is ast.USub else +value if kind is ast.UAdd else ~value


def compare(kind: type[ast.cmpop], left: Value, right: Value, script: Script) -> bool:
    """The result of a comparison."""
    if kind in _ORDERS:
        return _ordered(_ORDERS[kind], left, right)
    if kind is ast.Is or kind is ast.IsNot:
        return (left is right) == (kind is ast.Is)
    if kind is ast.Eq or kind is ast.NotEq:
        return equal(left, right, script) == (kind is ast.Eq)
    return contains(right, left, script) == (kind is ast.In)


def _ordered(order: Callable[[Value, Value], bool], left: Value, right: Value) -> bool:
    if not (is_number(left) and is_number(right)) and not (isinstance(left, str) and isinstance(right, str)):
        flat = isinstance(left, tuple) and isinstance(right, tuple) and all(map(is_number, left + right))
        if not flat:
            raise RefusalError(f"{describe(left)} and {describe(right)} have no order")
    return order(left, right)


def in_order(choose: Callable[..., Value], keys: list[Value], script: Script) -> Value:
    """What `sorted`, `min` or `max` makes of the places of keys; raises `RefusalError` where these have no order."""
    if all(is_key(each) and each is not None for each in keys):
        script.take_compared([part for each in keys for part in (each if isinstance(each, tuple) else (each,))])
        with contextlib.suppress(TypeError):
            return choose(range(len(keys)), key=keys.__getitem__)
    raise RefusalError("values without an order are compared")


def equal(left: Value, right: Value, script: Script, level: int = 0) -> bool:
    """Whether two values are equal; lists and the like by their elements, a limited way down."""
    script.take_step()
    left = left.compared_as() if isinstance(left, Record) else left
    right = right.compared_as() if isinstance(right, Record) else right
    if isinstance(left, Record):
        return left.equals(right)
    if isinstance(right, Record):
        return right.equals(left)
    if not isinstance(left, list | tuple | dict):
        return bool(left == right)
    alike = any(isinstance(left, kind) and isinstance(right, kind) for kind in (list, tuple, dict))
    if not alike or len(left) != len(right):
        return False
    if level > 8:
        raise RefusalError("lists within lists, too deep to be compared")
    if isinstance(left, dict):
        return all(key in right and equal(left[key], right[key], script, level + 1) for key in left)
    return all(equal(a, b, script, level + 1) for a, b in zip(left, right, strict=True))


def contains(container: Value, value: Value, script: Script) -> bool:
    """Whether `value` is in `container`."""
    if isinstance(container, str):
        if not isinstance(value, str):
            raise RefusalError(f"{describe(value)} cannot be in a text")
        return value in container
    if isinstance(container, range):
        return is_number(value) and float(value).is_integer() and int(value) in container
    if isinstance(container, dict):
        return is_key(value) and value in container
    if isinstance(container, Record):
        if type(container).contains is not Record.contains:
            return container.contains(value)
        container = container.elements()
    if not isinstance(container, list | tuple):
        raise RefusalError(f"nothing can be in {describe(container)}")
    if not isinstance(value, list | tuple | dict | Record):
        script.take_compared([value] * len(container))
        return value in container
    return any(equal(item, value, script) for item in container)
