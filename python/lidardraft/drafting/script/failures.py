"""Errors within a script: `try`, `assert` and `raise`."""

from __future__ import annotations

import ast

from lidardraft.drafting.script.formatting import to_text
from lidardraft.drafting.script.frame import Frame
from lidardraft.drafting.script.limits import Limits, RaisedError, RefusalError
from lidardraft.drafting.script.statements import Execute, Statements
from lidardraft.drafting.script.values import truth

STEPS_OF_ERROR = 5  # that an error costs which is met on its way
_ALL = ("Exception", "BaseException")
_KINDS = {
    **dict.fromkeys(("KeyError", "IndexError"), "LookupError"),
    **dict.fromkeys(("ZeroDivisionError", "OverflowError"), "ArithmeticError"),
    "JSONDecodeError": "ValueError",
}


class Failures(Statements):
    """Adds these to the other statements. What is not read, and what is too much, is never caught."""

    def __init__(self, limits: Limits) -> None:
        super().__init__(limits)
        self._handled: RaisedError | None = None  # what a bare `raise` raises again
        self.statements |= {ast.Try: self._try, ast.Assert: self._assert, ast.Raise: self._raise}

    def _try(self, node: ast.Try) -> Execute:
        body, orelse, last = (self.block(nodes) for nodes in (node.body, node.orelse, node.finalbody))
        handlers = [(_names(handler.type), handler.name, self.block(handler.body)) for handler in node.handlers]
        for handler, (names, _, _) in zip(node.handlers, handlers, strict=True):
            if handler.type is not None and not names:
                raise RefusalError("`except` of what is no name is not read", handler.lineno)

        def guarded(frame: Frame) -> object:
            levels = self.budget.levels
            try:
                ended = body(frame)
            except RaisedError as error:
                self.budget.levels = levels
                self.budget.take_steps(STEPS_OF_ERROR)
                for names, name, handle in handlers:
                    if not names or is_caught(error, names):
                        if name is not None:
                            frame.set(name, error.said)
                        outside, self._handled = self._handled, error
                        try:
                            return handle(frame)
                        finally:
                            self._handled = outside
                raise
            return orelse(frame) if ended is None else ended

        def execute(frame: Frame) -> object:
            levels = self.budget.levels
            try:
                ended = guarded(frame)
            except RaisedError:
                self.budget.levels = levels
                last(frame)
                raise
            at_last = last(frame)
            return ended if at_last is None else at_last

        return execute

    def _assert(self, node: ast.Assert) -> Execute:
        test = self.expression(node.test)

        def execute(frame: Frame) -> None:
            if not truth(test(frame)):
                raise RaisedError("AssertionError", "what the script asserts is not so")

        return execute

    def _raise(self, node: ast.Raise) -> Execute:
        names = _names(node.exc.func if isinstance(node.exc, ast.Call) else node.exc)
        arguments_of = self.items(node.exc.args if isinstance(node.exc, ast.Call) else [])

        def execute(frame: Frame) -> None:
            if node.exc is None and self._handled is not None:
                raise self._handled
            if not names:
                raise RefusalError("the script ends itself here with an error")
            said = to_text(arguments[0], self.budget) if (arguments := arguments_of(frame)) else ""
            shown = f": {said[:200]!r}" if said else ""
            raise RaisedError(names[0], f"the script ends itself here with {names[0]:.60}{shown}", said)

        return execute


def is_caught(error: RaisedError, names: list[str]) -> bool:
    """Whether `except` of these classes catches the error; `SystemExit` is no `Exception`."""
    kinds = _ALL[1:] if error.name == "SystemExit" else (_KINDS.get(error.name), *_ALL)
    return not {error.name, *kinds}.isdisjoint(names)


def _names(node: ast.expr | None) -> list[str]:
    """The names of classes of errors, as they stand behind `except` or `raise`."""
    if isinstance(node, ast.Tuple):
        return [name for part in node.elts for name in _names(part)]
    if isinstance(node, ast.Attribute):
        return [node.attr]
    return [node.id] if isinstance(node, ast.Name) else []
