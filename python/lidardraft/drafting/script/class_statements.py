"""Classes, and blocks under `with`."""

from __future__ import annotations

import ast

from lidardraft.drafting.script.class_parts import BaseMarker, ErrorClass
from lidardraft.drafting.script.classes import ClassFrame, ScriptClass
from lidardraft.drafting.script.failures import STEPS_OF_ERROR, Failures, is_caught
from lidardraft.drafting.script.frame import STEPS_OF_FUNCTION, Frame
from lidardraft.drafting.script.limits import Limits, RaisedError, RefusalError
from lidardraft.drafting.script.statements import Execute
from lidardraft.drafting.script.values import Record, Value, describe


class Surroundings(Record):
    """What may stand behind `with`: it changes something for a block, and takes it back."""

    def enter(self) -> None:
        """Begin the block."""

    def leave(self) -> None:
        """End the block."""

    def catches(self, _error: RaisedError) -> bool:
        """Whether an error ends the block, and nothing more."""
        return False


class Suppressed(Surroundings):
    """`contextlib.suppress(...)`."""

    kind = "suppress"

    def __init__(self, *errors: Value) -> None:
        self._names = [error.error for error in errors if isinstance(error, ErrorClass)]
        if len(self._names) != len(errors):
            raise RefusalError("suppress of what is no class of errors of Python's own")

    def catches(self, error: RaisedError) -> bool:
        return is_caught(error, self._names)


class ClassStatements(Failures):
    """Adds these to the other statements."""

    def __init__(self, limits: Limits) -> None:
        super().__init__(limits)
        self.statements |= {ast.ClassDef: self._class, ast.With: self._with}

    def _class(self, node: ast.ClassDef) -> Execute:
        if node.keywords or len(node.bases) > 1:
            raise RefusalError("a class with a metaclass, or derived from several, is not read", node.lineno)
        base_of = self.expression(node.bases[0]) if node.bases else None
        decorate, block = self.decorators(node.decorator_list), self.block(node.body)

        def execute(frame: Frame) -> None:
            base = None if base_of is None else base_of(frame)
            if not isinstance(base, ScriptClass | BaseMarker | None):
                raise RefusalError(f"a class derived from {describe(base)} is not read", node.lineno)
            self.budget.take_steps(STEPS_OF_FUNCTION)
            inside = ClassFrame(frame)
            block(inside)
            self.line = node.lineno
            frame.set(node.name, decorate(frame, ScriptClass(node.name, base, inside, self.budget, self.call)))

        return execute

    def _with(self, node: ast.With) -> Execute:
        parts = [(self.expression(item.context_expr), item.optional_vars) for item in node.items]
        block = self.block(node.body)

        def execute(frame: Frame) -> object:
            entered: list[Surroundings] = []
            levels = self.budget.levels
            for value_of, name in parts:
                value = value_of(frame)
                if not isinstance(value, Surroundings) or name is not None:
                    raise RefusalError(f"`with` of {describe(value)} is not read", node.lineno)
                value.enter()
                entered.append(value)
            try:
                return block(frame)
            except RaisedError as error:
                self.budget.take_steps(STEPS_OF_ERROR)
                if not any(value.catches(error) for value in entered):
                    raise
                self.budget.levels = levels
                return None
            finally:
                for value in reversed(entered):
                    value.leave()

        return execute
