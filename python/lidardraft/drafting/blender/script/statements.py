"""The statements of a script: functions of a node of the syntax tree and the frame of its names. They return a value
that ends the statements around them early, or None."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any

from lidardraft.drafting.blender.script.definitions import (
    BaseMarker,
    ClassFrame,
    Decorator,
    Frame,
    Function,
    ScriptClass,
)
from lidardraft.drafting.blender.script.expressions import (
    assign,
    defaults_of,
    loop_over,
    not_supported,
    place_of,
    value_of,
    values_of,
)
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError
from lidardraft.drafting.blender.script.operators import binary, to_text
from lidardraft.drafting.blender.script.values import (
    Namespace,
    Outside,
    Record,
    Value,
    describe,
    dict_key,
    place,
)

_BREAK, _CONTINUE = object(), object()
_ALL = ("Exception", "BaseException")
_KINDS = {
    **dict.fromkeys(("KeyError", "IndexError"), "LookupError"),
    **dict.fromkeys(("ZeroDivisionError", "OverflowError"), "ArithmeticError"),
}


class _Returned:
    """The value of a `return`, on its way through the statements around it."""

    def __init__(self, value: Value) -> None:
        self.value = value


def block(nodes: list[ast.stmt], frame: Frame) -> object:
    """Execute statements one after another. Raises `RefusalError` naming an unsupported line."""
    script = frame.script
    script.go_deeper(nodes[0].lineno if nodes else script.line)
    try:
        for node in nodes:
            script.line = node.lineno
            script.take_step()
            if (ended := _STATEMENTS.get(type(node), _unknown)(node, frame)) is not None:
                return ended
    except RefusalError as refusal:
        raise refusal.at(node.lineno) from None
    finally:
        script.levels -= 1
    return None


def result_of(nodes: list[ast.stmt], frame: Frame) -> Value:
    """The return value of a function's statements."""
    ended = block(nodes, frame)
    return ended.value if isinstance(ended, _Returned) else None


def _unknown(node: ast.stmt, _: Frame) -> object:
    raise not_supported(node)


def _expression(node: ast.Expr, frame: Frame) -> None:
    value_of(node.value, frame)


def _assign(node: ast.Assign, frame: Frame) -> None:
    value = value_of(node.value, frame)
    for target in node.targets:
        assign(target, value, frame)


def _annotated(node: ast.AnnAssign, frame: Frame) -> None:
    if isinstance(node.target, ast.Name) and isinstance(frame, ClassFrame):
        frame.annotated.append(node.target.id)
    if node.value is not None:
        assign(node.target, value_of(node.value, frame), frame)


def _augmented(node: ast.AugAssign, frame: Frame) -> None:
    read, write = place_of(node.target, frame)
    write(binary(type(node.op), read(), value_of(node.value, frame), frame.script, in_place=True))


def _if(node: ast.If, frame: Frame) -> object:
    return block(node.body if value_of(node.test, frame) else node.orelse, frame)


def _for(node: ast.For, frame: Frame) -> object:
    def rounds() -> Iterator[None]:
        for item in loop_over(value_of(node.iter, frame), frame.script):
            assign(node.target, item, frame)
            yield

    return _loop(node, rounds(), frame)


def _while(node: ast.While, frame: Frame) -> object:
    return _loop(node, iter(lambda: bool(value_of(node.test, frame)), False), frame)


def _loop(node: ast.For | ast.While, rounds: Iterator[object], frame: Frame) -> object:
    for _ in rounds:
        ended = block(node.body, frame)
        if ended is _BREAK:
            return None
        if ended is not None and ended is not _CONTINUE:
            return ended
    return block(node.orelse, frame)


def _function(node: ast.FunctionDef, frame: Frame) -> None:
    function = Function(
        node.name, node.args, defaults_of(node.args, frame), frame, lambda inner: result_of(node.body, inner)
    )
    frame.set(node.name, _decorated(function, node.decorator_list, frame))


def _decorated(value: Value, decorators: list[ast.expr], frame: Frame) -> Value:
    for node in reversed(decorators):
        decorator = value_of(node, frame)
        if not isinstance(decorator, Decorator):
            known = "property, staticmethod, classmethod and dataclass"
            raise RefusalError(f"{describe(decorator)} as a decorator is not supported; {known} are", node.lineno)
        value = decorator.around(value)
    return value


def _class(node: ast.ClassDef, frame: Frame) -> object:
    if node.keywords or len(node.bases) > 1:
        raise RefusalError("a class may have one base class and no metaclass")
    base = value_of(node.bases[0], frame) if node.bases else None
    if not isinstance(base, ScriptClass | BaseMarker | None):
        raise RefusalError(f"a class derived from {describe(base)} is not supported")
    inside = ClassFrame(frame, frame.script)
    block(node.body, inside)
    frame.script.line = node.lineno
    frame.set(node.name, _decorated(ScriptClass(node.name, base, inside), node.decorator_list, frame))
    return None


def _return(node: ast.Return, frame: Frame) -> object:
    return _Returned(None if node.value is None else value_of(node.value, frame))


def _names_elsewhere(node: ast.Global | ast.Nonlocal, frame: Frame) -> None:
    for name in node.names:
        frame.declare(name, nonlocal_=isinstance(node, ast.Nonlocal))


def _delete(node: ast.Delete, frame: Frame) -> None:
    for target in node.targets:
        if isinstance(target, ast.Name):
            frame.delete(target.id)
            continue
        if not isinstance(target, ast.Subscript):
            raise not_supported(node)
        owner, key = (value_of(part, frame) for part in (target.value, target.slice))
        if isinstance(owner, list):
            if not isinstance(key, slice):
                place(key, len(owner), "a list")
        elif not isinstance(owner, dict):
            raise not_supported(node)
        elif dict_key(key) not in owner:
            raise RaisedError("KeyError", f"the key {describe(key)} is not in the dict")
        del owner[key]


class Suppress(Record):
    """The only context manager for `with`: errors of these names end the block without further effect."""

    kind = "suppress"

    def __init__(self, names: list[str]) -> None:
        self.names = names


def _with(node: ast.With, frame: Frame) -> object:
    suppressed = list[str]()
    for item in node.items:
        value = value_of(item.context_expr, frame)
        if not isinstance(value, Suppress) or item.optional_vars is not None:
            raise RefusalError(f"`with` of {describe(value)} is not supported")
        suppressed += value.names
    try:
        return block(node.body, frame)
    except RaisedError as error:
        if not _is_caught(error, suppressed):
            raise
        return None


def _try(node: ast.Try, frame: Frame) -> object:
    for handler in node.handlers:
        if handler.type is not None and not _names(handler.type):
            raise RefusalError("`except` takes names of errors", handler.lineno)
    try:
        ended = _guarded(node, frame)
    except RaisedError:
        if (at_last := block(node.finalbody, frame)) is not None:
            return at_last
        raise
    at_last = block(node.finalbody, frame)
    return ended if at_last is None else at_last


def _guarded(node: ast.Try, frame: Frame) -> object:
    script = frame.script
    try:
        ended = block(node.body, frame)
    except RaisedError as error:
        for handler in node.handlers:
            if handler.type is None or _is_caught(error, _names(handler.type)):
                if handler.name is not None:
                    frame.set(handler.name, error.said)
                outside, script.handled = script.handled, error
                try:
                    return block(handler.body, frame)
                finally:
                    script.handled = outside
        raise
    return block(node.orelse, frame) if ended is None else ended


def _assert(node: ast.Assert, frame: Frame) -> None:
    if not value_of(node.test, frame):
        raise RaisedError("AssertionError", "an assertion of the script fails", "")


def _raise(node: ast.Raise, frame: Frame) -> None:
    script = frame.script
    if node.exc is None and script.handled is not None:
        raise script.handled
    names = _names(node.exc.func if isinstance(node.exc, ast.Call) else node.exc)
    if not names:
        raise RefusalError("the script raises an error here")
    arguments = values_of(node.exc.args, frame) if isinstance(node.exc, ast.Call) else []
    said = to_text(arguments[0], script) if arguments else ""
    shown = f": {said[:200]!r}" if said else ""
    raise RaisedError(names[0], f"the script ends here with {names[0]:.60}{shown}", said)


def _is_caught(error: RaisedError, names: list[str]) -> bool:
    """Whether `except` of these classes catches the error; `SystemExit` is no `Exception`."""
    kinds = _ALL[1:] if error.name == "SystemExit" else (_KINDS.get(error.name), *_ALL)
    return not {error.name, *kinds}.isdisjoint(names)


def _names(node: ast.expr | None) -> list[str]:
    """The names of classes of errors after `except` or `raise`."""
    if isinstance(node, ast.Tuple):
        return [name for part in node.elts for name in _names(part)]
    if isinstance(node, ast.Attribute):
        return [node.attr]
    return [node.id] if isinstance(node, ast.Name) else []


def _import(node: ast.Import, frame: Frame) -> None:
    for alias in node.names:
        top = alias.name.split(".")[0]
        frame.set(alias.asname or top, _module(alias.name if alias.asname else top, frame))


def _import_from(node: ast.ImportFrom, frame: Frame) -> None:
    if node.level or node.module is None:
        raise RefusalError("a script cannot import from other files")
    found = _module(node.module, frame)
    for alias in node.names:
        if alias.name != "*":
            frame.set(alias.asname or alias.name, _name_in(found, alias.name))
        elif not isinstance(found, Namespace):
            raise RefusalError(f"the names of the module {node.module:.60} are not known")
        else:
            for name, value in found.values.items():
                frame.set(name, value)


def _module(path: str, frame: Frame) -> Value:
    top, *parts = path.split(".")
    found = frame.script.modules[top] if top in frame.script.modules else Outside(top)
    for part in parts:
        found = _name_in(found, part)
    return found


def _name_in(owner: Value, name: str) -> Value:
    """The value of a name in a module; an unusable one if it is unknown."""
    try:
        return owner.attribute(name) if isinstance(owner, Record) else Outside(name)
    except RefusalError:
        return Outside(f"{owner.kind}.{name:.60}")


_STATEMENTS: dict[type[ast.stmt], Callable[[Any, Frame], object]] = {
    ast.Pass: lambda *_: None,
    ast.Break: lambda *_: _BREAK,
    ast.Continue: lambda *_: _CONTINUE,
    ast.Expr: _expression,
    ast.Assign: _assign,
    ast.AnnAssign: _annotated,
    ast.AugAssign: _augmented,
    ast.FunctionDef: _function,
    ast.Return: _return,
    ast.Global: _names_elsewhere,
    ast.Nonlocal: _names_elsewhere,
    ast.Delete: _delete,
    ast.Assert: _assert,
    ast.Raise: _raise,
    ast.Import: _import,
    ast.ImportFrom: _import_from,
    ast.If: _if,
    ast.For: _for,
    ast.While: _while,
    ast.Try: _try,
    ast.With: _with,
    ast.ClassDef: _class,
}
