"""The values of expressions, and assignments: functions of a node of the syntax tree and the frame of its names. Each
node counts as a step and a level each time it is evaluated."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from lidardraft.drafting.blender.script.containers import Lazy, Set, iterate, method, to_dict
from lidardraft.drafting.blender.script.definitions import Frame, Function, Super
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.operators import binary, compare, format_value, to_repr, to_text, unary
from lidardraft.drafting.blender.script.values import (
    Record,
    Value,
    call,
    describe,
    dict_key,
    elements,
    is_key,
    length,
    lone_surrogate,
    place,
    text,
    whole,
)


def value_of(node: ast.expr, frame: Frame) -> Value:
    """The value of an expression. Raises `RefusalError` naming the innermost unsupported line."""
    script = frame.script
    script.go_deeper(node.lineno)
    try:
        return _EXPRESSIONS.get(type(node), _unknown)(node, frame)
    except RefusalError as refusal:
        raise refusal.at(node.lineno) from None
    finally:
        script.levels -= 1


def not_supported(node: ast.AST) -> RefusalError:
    """The error for a part of Python's language that scripts may not use."""
    try:
        said = ast.unparse(node).partition("\n")[0]
    except RecursionError:
        said = type(node).__name__
    return RefusalError(f"`{said:.60}` is not supported in a script")


def _unknown(node: ast.expr, _: Frame) -> Value:
    raise not_supported(node)


def _constant(node: ast.Constant, _: Frame) -> Value:
    value = node.value
    if value is not None and not isinstance(value, int | float | str):
        raise not_supported(node)
    if isinstance(value, int) and value.bit_length() > 63:
        raise RefusalError("a whole number of more than 63 bits")
    if isinstance(value, str) and (wrong := lone_surrogate(value)) is not None:
        raise RefusalError(f"the text holds half a character, {value[wrong]!r}")
    return value


def _attribute(node: ast.Attribute, frame: Frame) -> Value:
    return attribute_of(value_of(node.value, frame), node.attr, frame.script)


def attribute_of(owner: Value, name: str, script: Script) -> Value:
    """The value of an attribute of any value."""
    is_record = isinstance(owner, Record)
    if name.startswith("_") and not (is_record and owner.has_private(name)):
        raise RefusalError(f"the attribute {name!r:.60} is not supported")
    if not is_record:
        return method(owner, name, script)
    return owner.attribute(name)


def _call(node: ast.Call, frame: Frame) -> Value:
    if isinstance(node.func, ast.Name) and node.func.id == "super" and not node.args:
        try:
            return Super(frame.get("__class__"), frame.get("__self__"))
        except RefusalError:
            raise RefusalError("super() outside of a method") from None
    function, arguments = value_of(node.func, frame), values_of(node.args, frame)
    keywords: dict[str, Value] = {}
    for keyword in node.keywords:
        value = value_of(keyword.value, frame)
        if keyword.arg is not None:
            keywords[keyword.arg] = value
        elif not isinstance(value, dict):
            raise RefusalError(f"{describe(value)} behind ** is no dict")
        else:
            frame.script.take_made(value)
            keywords |= {text(name, "the name of an argument"): each for name, each in value.items()}
    return call(function, arguments, keywords, frame.script)


def values_of(nodes: list[ast.expr], frame: Frame) -> list[Value]:
    """The values of expressions; some may have a star."""
    items: list[Value] = []
    for node in nodes:
        if isinstance(node, ast.Starred):
            items += elements(value_of(node.value, frame), frame.script)
        else:
            items.append(value_of(node, frame))
    return items


def item_of(owner: Value, key: Value, script: Script) -> Value:
    """The value of an item, `owner[key]`."""
    if isinstance(owner, Record):
        return owner[key]
    if isinstance(owner, dict):
        try:
            return owner[dict_key(key)]
        except KeyError:
            raise RaisedError("KeyError", f"the key {describe(key)} is not in the dict") from None
    if not isinstance(owner, str | list | tuple | range):
        raise RefusalError(f"{describe(owner)} has no items")
    if isinstance(key, slice):
        script.take_cells(len(range(*key.indices(length(owner)))))
    else:
        place(key, length(owner), describe(owner))
    return owner[key]


def _slice(node: ast.Slice, frame: Frame) -> slice:
    """A slice as Python's own."""
    parts = [None if part is None else value_of(part, frame) for part in (node.lower, node.upper, node.step)]
    bounds = [None if part is None else whole(part, "a bound of a slice") for part in parts]
    if bounds[2] == 0:
        raise RefusalError("the step of a slice is 0")
    return slice(*bounds)


def _boolean(node: ast.BoolOp, frame: Frame) -> Value:
    wanted, value = isinstance(node.op, ast.Or), None
    for part in node.values:
        value = value_of(part, frame)
        if bool(value) == wanted:
            break
    return value


def _compare(node: ast.Compare, frame: Frame) -> Value:
    left = value_of(node.left, frame)
    for kind, part in zip(node.ops, node.comparators, strict=True):
        right = value_of(part, frame)
        if not compare(type(kind), left, right, frame.script):
            return False
        left = right
    return True


def _dict(node: ast.Dict, frame: Frame) -> Value:
    found: dict[Value, Value] = {}
    for key, value in zip(node.keys, node.values, strict=True):
        if key is None:
            found |= to_dict(value_of(value, frame), {}, frame.script)
        else:
            known = dict_key(value_of(key, frame))
            found[known] = value_of(value, frame)
    return found


def _lambda(node: ast.Lambda, frame: Frame) -> Value:
    defaults = defaults_of(node.args, frame)
    return Function("<lambda>", node.args, defaults, frame, lambda inner: value_of(node.body, inner))


def defaults_of(arguments: ast.arguments, frame: Frame) -> list[Value]:
    """The values of a function's defaults, those of keyword-only arguments last."""
    nodes = (*arguments.defaults, *arguments.kw_defaults)
    return [None if node is None else value_of(node, frame) for node in nodes]


def _formatted_text(node: ast.JoinedStr, frame: Frame) -> Value:
    texts = [value_of(part, frame) for part in node.values]
    frame.script.take_text(sum(map(len, texts)))
    return "".join(texts)


def _formatted_value(node: ast.FormattedValue, frame: Frame) -> Value:
    value = value_of(node.value, frame)
    if node.conversion in (ord("r"), ord("a")):
        value = to_repr(value, frame.script)
    elif node.conversion == ord("s"):
        value = to_text(value, frame.script)
    return format_value(value, "" if node.format_spec is None else value_of(node.format_spec, frame), frame.script)


def _list_comprehension(node: ast.ListComp | ast.SetComp, frame: Frame) -> list[Value]:
    return [value_of(node.elt, inner) for inner in _rounds(node.generators, frame.within())]


def _generator(node: ast.GeneratorExp, frame: Frame) -> Value:
    rounds = _rounds(node.generators, frame.within())
    return Lazy((value_of(node.elt, inner) for inner in rounds), frame.script)


def _dict_comprehension(node: ast.DictComp, frame: Frame) -> Value:
    found: dict[Value, Value] = {}
    for inner in _rounds(node.generators, frame.within()):
        key = dict_key(value_of(node.key, inner))
        found[key] = value_of(node.value, inner)
    return found


def _rounds(loops: list[ast.comprehension], frame: Frame) -> Iterator[Frame]:
    """The frame of a comprehension, once for each round. The iterable of the first loop is evaluated at once, as in
    Python."""
    first, rest = loops[0], loops[1:]
    if first.is_async:
        raise RefusalError("`async` is not supported in a script")
    items = loop_over(value_of(first.iter, frame), frame.script)

    def each() -> Iterator[Frame]:
        for item in items:
            assign(first.target, item, frame)
            if all(value_of(test, frame) for test in first.ifs):
                yield from _rounds(rest, frame) if rest else (frame,)

    return each()


def loop_over(value: Value, script: Script) -> Iterator[Value]:
    """The values of a loop, one after another: a range makes no list, and a list may grow meanwhile."""
    return iter(value) if isinstance(value, list | tuple | range) else iterate(value, script)


def _named(node: ast.NamedExpr, frame: Frame) -> Value:
    value = value_of(node.value, frame)
    frame.home.set(node.target.id, value)
    return value


_EXPRESSIONS: dict[type[ast.expr], Callable[[Any, Frame], Value]] = {
    ast.Constant: _constant,
    ast.Name: lambda node, frame: frame.get(node.id),
    ast.Attribute: _attribute,
    ast.Call: _call,
    ast.Subscript: lambda node, frame: item_of(value_of(node.value, frame), value_of(node.slice, frame), frame.script),
    ast.Slice: _slice,
    ast.BinOp: lambda node, frame: binary(
        type(node.op), value_of(node.left, frame), value_of(node.right, frame), frame.script
    ),
    ast.UnaryOp: lambda node, frame: unary(type(node.op), value_of(node.operand, frame)),
    ast.BoolOp: _boolean,
    ast.Compare: _compare,
    ast.IfExp: lambda node, frame: value_of(node.body if value_of(node.test, frame) else node.orelse, frame),
    ast.List: lambda node, frame: values_of(node.elts, frame),
    ast.Tuple: lambda node, frame: tuple(values_of(node.elts, frame)),
    ast.Set: lambda node, frame: Set(values_of(node.elts, frame), frame.script),
    ast.Dict: _dict,
    ast.Lambda: _lambda,
    ast.JoinedStr: _formatted_text,
    ast.FormattedValue: _formatted_value,
    ast.ListComp: _list_comprehension,
    ast.SetComp: lambda node, frame: Set(_list_comprehension(node, frame), frame.script),
    ast.DictComp: _dict_comprehension,
    ast.GeneratorExp: _generator,
    ast.NamedExpr: _named,
}


def place_of(node: ast.expr, frame: Frame) -> tuple[Callable[[], Value], Callable[[Value], None]]:
    """The getter and the setter of an assignment's target; owner and key are evaluated once."""
    if isinstance(node, ast.Name):
        return partial(frame.get, node.id), partial(frame.set, node.id)
    if not isinstance(node, ast.Attribute | ast.Subscript):
        raise not_supported(node)
    owner, script = value_of(node.value, frame), frame.script
    if isinstance(node, ast.Attribute):
        return partial(attribute_of, owner, node.attr, script), partial(_set_attribute, owner, node.attr)
    key = value_of(node.slice, frame)
    return partial(item_of, owner, key, script), partial(_set_item, owner, key, script)


def assign(node: ast.expr, value: Value, frame: Frame) -> None:
    """Assign a value to the target `node`."""
    if isinstance(node, ast.Name):
        frame.set(node.id, value)
        return
    frame.script.go_deeper(node.lineno)
    try:
        if isinstance(node, ast.Tuple | ast.List):
            _unpack(node.elts, value, frame)
        else:
            place_of(node, frame)[1](value)
    finally:
        frame.script.levels -= 1


def _unpack(nodes: list[ast.expr], value: Value, frame: Frame) -> None:
    items = elements(value, frame.script)
    starred = [k for k, node in enumerate(nodes) if isinstance(node, ast.Starred)]
    if starred and len(items) >= len(nodes) - 1:
        first, end = starred[0], len(items) - (len(nodes) - 1 - starred[0])
        items = [*items[:first], items[first:end], *items[end:]]
    if len(items) != len(nodes):
        raise RaisedError("ValueError", f"{len(items)} values for {len(nodes)} names")
    for node, item in zip(nodes, items, strict=True):
        assign(node.value if isinstance(node, ast.Starred) else node, item, frame)


def _set_attribute(owner: Value, name: str, value: Value) -> None:
    if not isinstance(owner, Record) or (name.startswith("_") and not owner.has_private(name)):
        raise RefusalError(f"the attribute {name!r:.60} of {describe(owner)} cannot be set")
    owner.set_attribute(name, value)


def _set_item(owner: Value, key: Value, script: Script, value: Value) -> None:
    if isinstance(owner, Record) or (isinstance(owner, dict) and is_key(key)):
        owner[key] = value
    elif isinstance(owner, list) and isinstance(key, slice) and key.step in (None, 1):
        owner[key] = elements(value, script)
    elif isinstance(owner, list) and isinstance(key, int):
        owner[place(key, len(owner), "a list")] = value
    else:
        raise RefusalError(f"{describe(owner)} has no place {describe(key)} that can be set")
