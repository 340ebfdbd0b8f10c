"""Operators on values of a script: what Python makes of them, if it is not too large."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable

from lidardraft.drafting.script.formatting import percent_format
from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.values import Record, Value, checked, describe, is_number, truth

_LONGEST_SHIFT = 64
_LONG = 200  # characters of a text that is looked for
_NUMBERS: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
_SIGNS: dict[type[ast.unaryop], Callable[[Value], Value]] = {
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
}
_ORDERS: dict[type[ast.cmpop], Callable[[Value, Value], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


def binary(kind: type[ast.operator], left: Value, right: Value, budget: Budget) -> Value:
    """The result of an operator between two values."""
    if isinstance(left, Record):
        budget.take_steps(left.weight)
        return left.binary(kind, right)
    if kind is ast.Mod and isinstance(left, str):
        return percent_format(left, right, budget)
    if isinstance(right, Record):
        budget.take_steps(right.weight)
        return right.binary(kind, left, reflected=True)
    if is_number(left) and is_number(right):
        return _of_numbers(kind, left, right)
    if kind is ast.Add and type(left) is type(right) and isinstance(left, str | list | tuple):
        _take(len(left) + len(right), left, budget)
        return left + right
    if kind is ast.BitOr and type(left) is type(right) is dict:
        budget.take_cells(3 * (len(left) + len(right)))
        return {**left, **right}
    if kind is ast.Mult:
        if isinstance(left, int):
            left, right = right, left
        if isinstance(left, str | list | tuple) and isinstance(right, int):
            _take(len(left) * max(right, 0), left, budget)
            return left * right
    raise RefusalError(f"{describe(left)} and {describe(right)} cannot be calculated with so")


def _of_numbers(kind: type[ast.operator], left: Value, right: Value) -> Value:
    if kind not in _NUMBERS:
        raise RefusalError("this operator is not read")
    if kind is ast.Pow and isinstance(left, int) and isinstance(right, int):
        if right > _LONGEST_SHIFT and abs(left) > 1:
            raise RefusalError(f"{left} ** {right} is too large")
    elif kind in (ast.LShift, ast.RShift) and isinstance(right, int) and right > _LONGEST_SHIFT:
        raise RefusalError(f"a shift by {right} bits")
    try:
        return checked(_NUMBERS[kind](left, right))
    except TypeError as error:
        raise RefusalError(f"{error}") from None
    except (ArithmeticError, ValueError) as error:
        raise RaisedError(type(error).__name__, f"{error}") from None


def _take(count: int, value: Value, budget: Budget) -> None:
    if isinstance(value, str):
        budget.take_text(count)
    else:
        budget.take_cells(count)


def unary(kind: type[ast.unaryop], value: Value) -> Value:
    """The result of a sign, `not` or `~`."""
    if kind is ast.Not:
        return not truth(value)
    if isinstance(value, Record) and kind is ast.USub:
        return value.negative()
    if not is_number(value) or (kind is ast.Invert and isinstance(value, float)):
        raise RefusalError(f"{describe(value)} cannot have this sign")
    return _SIGNS[kind](value)


def compare(kind: type[ast.cmpop], left: Value, right: Value, budget: Budget) -> bool:
    """The result of a comparison."""
    if kind in _ORDERS:
        return _ordered(_ORDERS[kind], left, right, budget)
    if kind is ast.Is or kind is ast.IsNot:
        return (left is right) == (kind is ast.Is)
    if kind is ast.Eq or kind is ast.NotEq:
        return equal(left, right, budget) == (kind is ast.Eq)
    return contains(right, left, budget) == (kind is ast.In)


def _ordered(order: Callable[[Value, Value], bool], left: Value, right: Value, budget: Budget) -> bool:
    budget.take_compared(left, right)
    if not (is_number(left) and is_number(right)) and not (isinstance(left, str) and isinstance(right, str)):
        flat = isinstance(left, tuple) and isinstance(right, tuple) and all(map(is_number, left + right))
        if not flat:
            raise RefusalError(f"{describe(left)} and {describe(right)} have no order")
    return order(left, right)


def equal(left: Value, right: Value, budget: Budget, level: int = 0) -> bool:
    """Whether two values are equal; lists and the like by their elements, a limited way down."""
    left = left.compared_as() if isinstance(left, Record) else left
    right = right.compared_as() if isinstance(right, Record) else right
    if isinstance(left, Record):
        return left.equals(right)
    if isinstance(right, Record):
        return right.equals(left)
    if not isinstance(left, list | tuple | dict):
        budget.take_compared(left)
        return bool(left == right)
    alike = any(isinstance(left, kind) and isinstance(right, kind) for kind in (list, tuple, dict))
    if not alike or len(left) != len(right):
        return False
    if level > 8:
        raise RefusalError("lists within lists, too deep to be compared")
    budget.take_steps(len(left) + 1)
    if isinstance(left, dict):
        budget.take_compared(*left)
        return all(key in right and equal(left[key], right[key], budget, level + 1) for key in left)
    return all(equal(a, b, budget, level + 1) for a, b in zip(left, right, strict=True))


def contains(container: Value, value: Value, budget: Budget) -> bool:
    """Whether `value` is in `container`."""
    budget.take_compared(value)
    if isinstance(container, str):
        if not isinstance(value, str):
            raise RefusalError(f"{describe(value)} cannot be in a text")
        budget.take_text(len(container))
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
    budget.take_cells(len(container))
    if not isinstance(value, list | tuple | dict | Record):
        if isinstance(value, str) and len(value) > _LONG:
            budget.take_compared(*container)
        return value in container
    budget.take_steps(len(container))
    return any(equal(item, value, budget) for item in container)


def is_key(value: Value) -> bool:
    """Whether a value can be a key of a dict: a number, a text, None, a record that is one, or a tuple of those."""
    if isinstance(value, tuple):
        return len(value) <= 16 and all(not isinstance(item, tuple) and is_key(item) for item in value)
    return value.is_key if isinstance(value, Record) else value is None or isinstance(value, int | float | str)


def dict_key(key: Value) -> Value:
    """The value, which can be a key of a dict."""
    if not is_key(key):
        raise RefusalError(f"{describe(key)} cannot be a key")
    return key
