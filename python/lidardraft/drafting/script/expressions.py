"""Each kind of expression of a script, made into a function of the frame that its names are looked up in."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any

from lidardraft.drafting.script.arithmetic import dict_key
from lidardraft.drafting.script.builtin_functions import builtin_functions, has, ordered
from lidardraft.drafting.script.classes import Super, builtin_decorators
from lidardraft.drafting.script.frame import Frame, Function
from lidardraft.drafting.script.iterators import going
from lidardraft.drafting.script.limits import Budget, Limits, RaisedError, RefusalError
from lidardraft.drafting.script.methods import method
from lidardraft.drafting.script.source import lone_surrogate
from lidardraft.drafting.script.values import (
    Builtin,
    Counter,
    DefaultDict,
    Record,
    Value,
    describe,
    elements,
    length,
    text,
    whole,
)

Evaluate = Callable[[Frame], Value]
_NO_KEYWORDS: dict[str, Value] = {}


class Expressions:
    """Makes functions of expressions, and counts their nodes: a statement costs as many steps each time."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.budget = Budget(limits)
        self.nodes = 0  # of the statement that is being made a function of
        self.depth = 0  # of nodes within nodes, in what is being made a function of
        self.deepest = 0
        functions = {**builtin_functions(self.budget, self.call), "getattr": Builtin("getattr", self._getattr)}
        self.builtins = Frame(None, {**functions, **builtin_decorators()})
        self.makers: dict[type[ast.expr], Callable[[Any], Evaluate]] = {
            ast.Constant: self._constant,
            ast.Name: self._name,
            ast.Attribute: self._attribute,
            ast.Call: self._call,
            ast.Subscript: self._subscript,
        }

    def expression(self, node: ast.expr) -> Evaluate:
        """The function that gives the value of an expression. Raises `RefusalError` where it is nested too deeply."""
        self.nodes += 1
        self.go_deeper(node.lineno)
        evaluate = self.makers.get(type(node), self._unknown)(node)
        self.depth -= 1
        return evaluate

    def go_deeper(self, line: int) -> None:
        """Count one level more of nodes within nodes."""
        self.depth += 1
        self.deepest = max(self.deepest, self.depth)
        if self.depth > self.limits.levels:
            raise RefusalError(f"nested more than {self.limits.levels} levels deep", line)

    def call(self, function: Value, arguments: list[Value], keywords: dict[str, Value] = _NO_KEYWORDS) -> Value:
        """What a function returns. Raises `RefusalError` where calls are nested too deeply."""
        if not isinstance(function, Record):
            raise RefusalError(f"{describe(function)} cannot be called")
        self.budget.take_steps(function.weight)
        if not isinstance(function, Function):
            return function.call(arguments, keywords)
        self.budget.go_within(function.levels)
        result = function.body(function.bind(arguments, keywords))
        self.budget.levels -= function.levels
        return result

    def ordered(self, items: Value, key: Value, reverse: Value) -> list[Value]:
        """What `sorted` gives."""
        return ordered(items, key, reverse, self.budget, self.call)

    def depth_of(self, make: Callable[[], Any]) -> tuple[Any, int]:
        """What `make` gives, and how many levels of nodes within nodes it has met."""
        outside, self.deepest = self.deepest, self.depth
        made = make()
        levels = self.deepest - self.depth
        self.deepest = max(outside, self.deepest)
        return made, levels

    def weighed(self, make: Callable[[], Any]) -> tuple[Any, int]:
        """What `make` gives, and how many nodes it has met: what costs so much each time it is gone through."""
        before = self.nodes
        made = make()
        return made, self.nodes - before

    def _unknown(self, node: ast.expr) -> Evaluate:
        def evaluate(_: Frame) -> Value:
            raise RefusalError(f"{type(node).__name__} is not read in a script", node.lineno)

        return evaluate

    def _constant(self, node: ast.Constant) -> Evaluate:
        value = node.value
        if value is not None and not isinstance(value, int | float | str):
            return self._unknown(node)
        if isinstance(value, int) and value.bit_length() > 63:
            raise RefusalError("a whole number of more than 63 bits", node.lineno)
        if isinstance(value, str) and (wrong := lone_surrogate(value)) is not None:
            raise RefusalError(f"the text holds half a character, {value[wrong]!r}", node.lineno)
        return lambda _: value

    def _name(self, node: ast.Name) -> Evaluate:
        name, line = node.id, node.lineno

        def evaluate(frame: Frame) -> Value:
            scope: Frame | None = frame
            while scope is not None:
                if name in scope.variables:
                    return scope.variables[name]
                scope = scope.outer
            raise RefusalError(f"the name {name!r:.60} is not known", line)

        return evaluate

    def _attribute(self, node: ast.Attribute) -> Evaluate:
        owner_of, name, line = self.expression(node.value), node.attr, node.lineno

        def evaluate(frame: Frame) -> Value:
            owner = owner_of(frame)
            try:
                return self.attribute_of(owner, name)
            except RefusalError as refusal:
                raise refusal.at(line) from None

        return evaluate

    def _getattr(self, owner: Value, name: Value, *default: Value) -> Value:
        name = text(name, "the name of an attribute")
        return default[0] if default and not has(owner, name) else self.attribute_of(owner, name)

    def attribute_of(self, owner: Value, name: str) -> Value:
        """What stands behind a dot."""
        if not isinstance(owner, Record):
            if name.startswith("_"):
                raise RefusalError(f"the attribute {name!r:.60} is not read")
            return method(owner, name, self.budget, self.ordered)
        if name.startswith("_") and not owner.has_private(name):
            raise RefusalError(f"the attribute {name!r:.60} is not read")
        if owner.weight:
            self.budget.take_steps(owner.weight)
        return owner.attribute(name)

    def _call(self, node: ast.Call) -> Evaluate:
        if isinstance(node.func, ast.Name) and node.func.id == "super" and not node.args:
            return self._super(node.lineno)
        function_of, arguments_of, line = self.expression(node.func), self.items(node.args), node.lineno
        keywords_of = [(keyword.arg, self.expression(keyword.value)) for keyword in node.keywords]

        def evaluate(frame: Frame) -> Value:
            function, arguments = function_of(frame), arguments_of(frame)
            keywords: dict[str, Value] = {}
            try:
                for name, value_of in keywords_of:
                    value = value_of(frame)
                    if name is not None:
                        keywords[name] = value
                    else:
                        self._add_keywords(keywords, value)
                return self.call(function, arguments, keywords)
            except RefusalError as refusal:
                raise refusal.at(line) from None

        return evaluate

    def _super(self, line: int) -> Evaluate:
        def evaluate(frame: Frame) -> Value:
            scope: Frame | None = frame
            while scope is not None and "__class__" not in scope.variables:
                scope = scope.outer
            if scope is None:
                raise RefusalError("super() outside of a method", line)
            return Super(scope.variables["__class__"], scope.variables["__self__"])

        return evaluate

    def _add_keywords(self, keywords: dict[str, Value], more: Value) -> None:
        if not isinstance(more, dict):
            raise RefusalError(f"{describe(more)} behind ** is no dict")
        self.budget.take_cells(3 * len(more))
        for name, value in more.items():
            keywords[text(name, "the name of an argument")] = value

    def _subscript(self, node: ast.Subscript) -> Evaluate:
        owner_of, key_of, line = self.expression(node.value), self.key(node.slice), node.lineno

        def evaluate(frame: Frame) -> Value:
            owner, key = owner_of(frame), key_of(frame)
            try:
                return self._item(owner, key)
            except RefusalError as refusal:
                raise refusal.at(line) from None

        return evaluate

    def _item(self, owner: Value, key: Value) -> Value:
        if isinstance(owner, Record):
            self.budget.take_steps(owner.weight)
            return owner.item(key)
        if isinstance(owner, dict):
            self.budget.take_compared(key)
            if dict_key(key) not in owner:
                if isinstance(owner, Counter):
                    return 0
                if isinstance(owner, DefaultDict) and owner.factory is not None:
                    self.budget.take_cells(3)
                    owner[key] = self.call(owner.factory, [])
                    return owner[key]
                raise RaisedError("KeyError", f"the key {describe(key)} is not in the dict")
        elif not isinstance(owner, str | list | tuple | range):
            raise RefusalError(f"{describe(owner)} has no items")
        elif isinstance(key, slice):
            self.budget.take_cells(len(range(*key.indices(length(owner)))))
        elif not -length(owner) <= whole(key, "a place") < length(owner):
            raise RaisedError("IndexError", f"{describe(owner)} of {length(owner)} has no place {key}")
        return owner[key]

    def key(self, node: ast.expr) -> Evaluate:
        """The function that gives what stands in square brackets: a value, or a slice of Python's own."""
        if not isinstance(node, ast.Slice):
            return self.expression(node)
        parts = [None if part is None else self.expression(part) for part in (node.lower, node.upper, node.step)]

        def evaluate(frame: Frame) -> Value:
            values = [None if part is None else part(frame) for part in parts]
            bounds = [None if value is None else whole(value, "a bound of a slice") for value in values]
            if bounds[2] == 0:
                raise RefusalError("the step of a slice is 0")
            return slice(*bounds)

        return evaluate

    def items(self, nodes: list[ast.expr]) -> Callable[[Frame], list[Value]]:
        budget, count = self.budget, len(nodes)
        if not any(isinstance(node, ast.Starred) for node in nodes):
            parts = [self.expression(node) for node in nodes]

            def evaluate(frame: Frame) -> list[Value]:
                budget.take_cells(count)
                return [part(frame) for part in parts]

            return evaluate
        starred = [
            (isinstance(node, ast.Starred), self.expression(node.value if isinstance(node, ast.Starred) else node))
            for node in nodes
        ]

        def evaluate_starred(frame: Frame) -> list[Value]:
            items: list[Value] = []
            for is_starred, part in starred:
                value = part(frame)
                items += elements(value, budget) if is_starred else [value]
            budget.take_cells(len(items))
            return items

        return evaluate_starred

    def items_of(self, value: Value) -> Iterator[Value]:
        """What a loop goes through, one after the other: a range is not made a list of, a list may grow meanwhile."""
        return iter(value) if isinstance(value, list | tuple | range) else going(value, self.budget)

    def target(self, node: ast.expr) -> Callable[[Frame, Value], None]:
        """The function that gives what stands on the left of an assignment a value."""
        raise NotImplementedError
