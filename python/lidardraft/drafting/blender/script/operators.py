"""Operators, comparisons and text of a script's values: Python's results, if they are not too large."""

from __future__ import annotations

import ast
import contextlib
import operator
import re
import string
from collections.abc import Callable, Iterator

from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import Record, Value, checked, describe, elements, is_key, is_number

_LONGEST_SHIFT = 64
_WIDEST = 200  # characters of a padded number or name, and digits after the point
_PERCENT = re.compile(r"%[-+ #0]*([\d.*]*)[^\d.*]")
_OPERATORS: dict[type[ast.operator], tuple[str, Callable[[Value, Value], Value], Callable[[Value, Value], Value]]] = {
    ast.Add: ("+", operator.add, operator.iadd),
    ast.Sub: ("-", operator.sub, operator.isub),
    ast.Mult: ("*", operator.mul, operator.imul),
    ast.Div: ("/", operator.truediv, operator.itruediv),
    ast.FloorDiv: ("//", operator.floordiv, operator.ifloordiv),
    ast.Mod: ("%", operator.mod, operator.imod),
    ast.Pow: ("**", operator.pow, operator.ipow),
    ast.LShift: ("<<", operator.lshift, operator.ilshift),
    ast.RShift: (">>", operator.rshift, operator.irshift),
    ast.BitAnd: ("&", operator.and_, operator.iand),
    ast.BitOr: ("|", operator.or_, operator.ior),
    ast.BitXor: ("^", operator.xor, operator.ixor),
    ast.MatMult: ("@", operator.matmul, operator.imatmul),
}
_ORDERS: dict[type, Callable[..., bool]]
_ORDERS = {ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge}


def binary(kind: type[ast.operator], left: Value, right: Value, script: Script, in_place: bool = False) -> Value:
    """The result of an operator between two values. With `in_place` it changes a list, dict, set or vector itself, for
    all its users."""
    if kind is ast.Mod and isinstance(left, str):
        return percent_format(left, right, script)
    sign, plain, changing = _OPERATORS[kind]
    if in_place and kind is ast.Add and isinstance(left, list):
        right = elements(right, script)
    error = RefusalError(f"{describe(left)} {sign} {describe(right)} is not supported")
    if not _is_bounded(kind, left, right, script):
        raise error
    try:
        result = checked((changing if in_place else plain)(left, right))
    except TypeError:
        raise error from None
    except (ArithmeticError, ValueError) as raised:
        raise RaisedError(type(raised).__name__, f"{raised}") from None
    if kind is not ast.Mult:
        script.take_made(right if result is left else result)
    return result


def _is_bounded(kind: type[ast.operator], left: Value, right: Value, script: Script) -> bool:
    """Whether the values support the operator, with a result no larger than both together; repetitions are counted
    here. Raises `RefusalError` for too large a result."""
    if records := [each for each in (left, right) if isinstance(each, Record)]:
        return type(left) is type(right) or not any(each.only_alike for each in records)
    if is_number(left) and is_number(right):
        grows = kind in (ast.LShift, ast.RShift) or (kind is ast.Pow and abs(left) > 1)
        if grows and isinstance(left, int) and isinstance(right, int) and right > _LONGEST_SHIFT:
            raise RefusalError(f"{left} {_OPERATORS[kind][0]} {right} is too large")
        return True
    if kind is ast.Mult:
        many, number = (right, left) if isinstance(left, int) else (left, right)
        if isinstance(many, str | list | tuple) and isinstance(number, int):
            (script.take_text if isinstance(many, str) else script.take_cells)(len(many) * max(number, 0))
            return True
    if kind is ast.BitOr:
        return type(left) is type(right) is dict
    return kind is ast.Add and any(isinstance(left, each) and isinstance(right, each) for each in (str, list, tuple))


def unary(kind: type[ast.unaryop], value: Value) -> Value:
    """The result of a sign, `not` or `~`."""
    if kind is ast.Not:
        return not value
    try:
        return -value if kind is ast.USub else +value if kind is ast.UAdd else ~value
    except TypeError:
        raise RefusalError(f"{describe(value)} cannot have this sign") from None


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
    """The result of `sorted`, `min` or `max` on the indices of keys; raises `RefusalError` if these have no order."""
    if all(is_key(each) and each is not None for each in keys):
        script.take_compared([part for each in keys for part in (each if isinstance(each, tuple) else (each,))])
        with contextlib.suppress(TypeError):
            return choose(range(len(keys)), key=keys.__getitem__)
    raise RefusalError("values without an order are compared")


def equal(left: Value, right: Value, script: Script, level: int = 0) -> bool:
    """Whether two values are equal; containers are compared by elements, to a limited depth."""
    script.take_step()
    left, right = (each.compared_as() if isinstance(each, Record) else each for each in (left, right))
    alike = [kind for kind in (list, tuple, dict) if isinstance(left, kind) and isinstance(right, kind)]
    if not alike:
        return bool(left == right)
    if len(left) != len(right):
        return False
    if level > 8:
        raise RefusalError("lists within lists, too deep to be compared")
    if isinstance(left, dict):
        return all(key in right and equal(left[key], right[key], script, level + 1) for key in left)
    return all(equal(a, b, script, level + 1) for a, b in zip(left, right, strict=True))


def contains(container: Value, value: Value, script: Script) -> bool:
    """Whether `value` is in `container`."""
    if isinstance(container, dict):
        return is_key(value) and value in container
    if isinstance(container, range):
        return is_number(value) and float(value).is_integer() and int(value) in container
    if isinstance(container, str) and not isinstance(value, str):
        raise RefusalError(f"{describe(value)} cannot be in a text")
    if isinstance(container, str) or (isinstance(container, Record) and hasattr(type(container), "__contains__")):
        return value in container
    items = container if isinstance(container, list | tuple) else elements(container, script)
    if not isinstance(value, list | tuple | dict | Record):
        script.take_compared([value] * len(items))
        return value in items
    return any(equal(item, value, script) for item in items)


def to_text(value: Value, script: Script, level: int = 0) -> str:
    """The `str` of a value; items of containers are written as in Python."""
    if isinstance(value, Record):
        return value.text(level > 0)
    if not isinstance(value, list | tuple | dict):
        return repr(value) if level and isinstance(value, str) else str(value)
    script.take_step()
    if level > 8:
        raise RefusalError("lists within lists, too deep to be written")
    if isinstance(value, dict):
        parts = [f"{to_text(key, script, 9)}: {to_text(item, script, level + 1)}" for key, item in value.items()]
    else:
        parts = [to_text(item, script, level + 1) for item in value]
    script.take_text(sum(map(len, parts)) + 2 * len(parts) + 2)
    inner = ", ".join(parts)
    if isinstance(value, dict):
        return f"{{{inner}}}"
    return f"[{inner}]" if isinstance(value, list) else f"({inner}{',' * (len(parts) == 1)})"


def to_repr(value: Value, script: Script) -> str:
    """The `repr` of a value."""
    return to_text([value], script)[1:-1]


def format_value(value: Value, spec: str, script: Script) -> str:
    """The text of a value in an f-string with a format `spec`."""
    _check_widths(spec)
    if spec and not isinstance(value, str | int | float):
        raise RefusalError(f"{describe(value)} cannot be formatted as {spec!r}")
    with _telling():
        return format(_plain(value, script), spec)


def brace_format(template: str, arguments: tuple[Value, ...], keywords: dict[str, Value], script: Script) -> str:
    """The result of `template.format(...)`; fields are numbers or names, without attributes or items."""
    script.take_cells(4 * template.count("{"))
    for _, field, spec, conversion in string.Formatter().parse(template):
        if conversion or "{" in (spec or "") or not re.fullmatch(r"\w*", field or ""):
            raise RefusalError(f"the format {template[:40]!r} is not supported")
        _check_widths(spec or "")
    plain = {name: _plain(value, script) for name, value in keywords.items()}
    text = template.format(*[_plain(value, script) for value in arguments], **plain)
    script.take_text(len(text))
    return text


def percent_format(template: str, values: Value, script: Script) -> str:
    """The result of `template % values`."""
    for match in _PERCENT.finditer(template):
        _check_widths(match[1].replace("*", str(10 * _WIDEST)))
    given = values if isinstance(values, tuple) else (values,)
    with _telling():
        text = template % tuple([_plain(value, script) for value in given])
    script.take_text(len(text))
    return text


@contextlib.contextmanager
def _telling() -> Iterator[None]:
    try:
        yield
    except (TypeError, ValueError, OverflowError) as error:
        raise RefusalError(f"a format that is not supported: {error}") from None


def _plain(value: Value, script: Script) -> str | int | float:
    """The value in a form that Python itself can format."""
    return value if isinstance(value, str | int | float) else to_text(value, script)


def _check_widths(spec: str) -> None:
    for width in re.findall(r"\d+", spec):
        if len(width) > 4 or int(width) > _WIDEST:
            raise RefusalError(f"a width of {width[:12]} characters; the limit is {_WIDEST}")
