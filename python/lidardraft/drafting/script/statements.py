"""Each kind of statement of a script, made into a function of the frame that its names are looked up in."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from lidardraft.drafting.script.arithmetic import binary, dict_key
from lidardraft.drafting.script.class_parts import Decorator
from lidardraft.drafting.script.classes import ClassFrame
from lidardraft.drafting.script.displays import Displays
from lidardraft.drafting.script.frame import STEPS_OF_FUNCTION, Frame, Function
from lidardraft.drafting.script.limits import Limits, RaisedError, RefusalError
from lidardraft.drafting.script.values import Record, Value, describe, elements, take_moved, truth, whole

Execute = Callable[[Frame], object]  # gives what ends the statements around it early, or None
BREAK, CONTINUE = object(), object()


class _Returned:
    """What a `return` hands on, through the statements around it."""

    def __init__(self, value: Value) -> None:
        self.value = value


class Statements(Displays):
    """Adds statements to expressions; `line` is the line of the one that is being carried out."""

    def __init__(self, limits: Limits) -> None:
        super().__init__(limits)
        self.line = 1
        self.statements: dict[type[ast.stmt], Callable[[Any], Execute]] = {
            ast.Expr: self._expression,
            ast.Pass: self._pass,
            ast.Assign: self._assign,
            ast.AnnAssign: self._annotated,
            ast.AugAssign: self._augmented,
            ast.If: self._if,
            ast.For: self._for,
            ast.While: self._while,
            ast.Break: lambda _: lambda _: BREAK,
            ast.Continue: lambda _: lambda _: CONTINUE,
            ast.FunctionDef: self._function,
            ast.Return: self._return,
            ast.Global: self._names_elsewhere,
            ast.Nonlocal: self._names_elsewhere,
            ast.Delete: self._delete,
        }

    def block(self, nodes: list[ast.stmt]) -> Execute:
        """The function that carries out statements one after the other, each for as many steps as it has nodes."""
        outside, parts = self.nodes, []
        for node in nodes:
            self.nodes = 1
            self.go_deeper(node.lineno)
            make = self.statements.get(type(node), self._unknown_statement)
            parts.append((node.lineno, make(node), self.nodes))
            self.depth -= 1
        self.nodes, budget = outside, self.budget

        def execute(frame: Frame) -> object:
            for line, run, weight in parts:
                self.line = line
                budget.steps -= weight
                try:
                    if budget.steps < 0:
                        budget.take_steps(0)
                    ended = run(frame)
                except RefusalError as refusal:
                    raise refusal.at(line) from None
                if ended is not None:
                    return ended
            return None

        return execute

    def _unknown_statement(self, node: ast.stmt) -> Execute:
        def execute(_: Frame) -> object:
            raise RefusalError(f"{type(node).__name__} is not read in a script")

        return execute

    def _expression(self, node: ast.Expr) -> Execute:
        evaluate = self.expression(node.value)

        def execute(frame: Frame) -> None:
            evaluate(frame)

        return execute

    def _pass(self, _: ast.Pass) -> Execute:
        return lambda _: None

    def _assign(self, node: ast.Assign) -> Execute:
        evaluate, targets = self.expression(node.value), [self.target(target) for target in node.targets]

        def execute(frame: Frame) -> None:
            value = evaluate(frame)
            for assign in targets:
                assign(frame, value)

        return execute

    def _annotated(self, node: ast.AnnAssign) -> Execute:
        name = node.target.id if isinstance(node.target, ast.Name) else None
        evaluate = None if node.value is None else self.expression(node.value)
        assign = self.target(node.target)

        def execute(frame: Frame) -> None:
            if name is not None and isinstance(frame, ClassFrame):
                frame.annotated.append(name)
            if evaluate is not None:
                assign(frame, evaluate(frame))

        return execute

    def _augmented(self, node: ast.AugAssign) -> Execute:
        before_of, assign = self.expression(node.target), self.target(node.target)
        value_of = self.expression(node.value)
        kind, budget = type(node.op), self.budget

        def execute(frame: Frame) -> None:
            before, value = before_of(frame), value_of(frame)
            if isinstance(before, list) and kind is ast.Add:  # the list itself grows, whoever else has it
                more = elements(value, budget)
                budget.take_cells(len(before) + len(more))
                before.extend(more)
                assign(frame, before)
            else:
                assign(frame, binary(kind, before, value, budget))

        return execute

    def target(self, node: ast.expr) -> Callable[[Frame, Value], None]:
        self.nodes += 1
        self.go_deeper(node.lineno)
        assign = self._target(node)
        self.depth -= 1
        return assign

    def _target(self, node: ast.expr) -> Callable[[Frame, Value], None]:
        if isinstance(node, ast.Name):
            name = node.id
            return lambda frame, value: frame.set(name, value)
        if isinstance(node, ast.Tuple | ast.List):
            return self._unpacked(node.elts)
        if isinstance(node, ast.Attribute):
            owner_of, attribute = self.expression(node.value), node.attr

            def set_attribute(frame: Frame, value: Value) -> None:
                owner = owner_of(frame)
                if not isinstance(owner, Record) or (attribute.startswith("_") and not owner.has_private(attribute)):
                    raise RefusalError(f"the attribute {attribute!r:.60} of {describe(owner)} cannot be set")
                owner.set_attribute(attribute, value)

            return set_attribute
        if isinstance(node, ast.Subscript):
            container_of, key_of = self.expression(node.value), self.key(node.slice)
            return lambda frame, value: self._set_item(container_of(frame), key_of(frame), value)
        raise RefusalError(f"an assignment to {type(node).__name__} is not read", node.lineno)

    def _unpacked(self, nodes: list[ast.expr]) -> Callable[[Frame, Value], None]:
        targets = [self.target(node.value if isinstance(node, ast.Starred) else node) for node in nodes]
        starred = [k for k, node in enumerate(nodes) if isinstance(node, ast.Starred)]

        def unpack(frame: Frame, value: Value) -> None:
            items = elements(value, self.budget)
            if starred and len(items) >= len(targets) - 1:
                first, end = starred[0], len(items) - (len(targets) - 1 - starred[0])
                items = [*items[:first], items[first:end], *items[end:]]
            if len(items) != len(targets):
                raise RaisedError("ValueError", f"{len(items)} values for {len(targets)} names")
            for assign, item in zip(targets, items, strict=True):
                assign(frame, item)

        return unpack

    def _set_item(self, owner: Value, key: Value, value: Value) -> None:
        if isinstance(owner, Record):
            owner.set_item(key, value)
        elif isinstance(owner, dict):
            self.budget.take_cells(3)
            self.budget.take_compared(key)
            owner[dict_key(key)] = value
        elif isinstance(owner, list) and isinstance(key, slice) and key.step in (None, 1):
            items = elements(value, self.budget)
            self.budget.take_cells(len(owner) + len(items))
            owner[key] = items
        elif isinstance(owner, list) and isinstance(key, int) and -len(owner) <= key < len(owner):
            owner[key] = value
        else:
            raise RefusalError(f"{describe(owner)} has no place {describe(key)} that can be set")

    def _if(self, node: ast.If) -> Execute:
        test, body, orelse = self.expression(node.test), self.block(node.body), self.block(node.orelse)
        return lambda frame: body(frame) if truth(test(frame)) else orelse(frame)

    def _for(self, node: ast.For) -> Execute:
        items_of = self.expression(node.iter)
        assign, weight = self.weighed(lambda: self.target(node.target))
        body, orelse = self.block(node.body), self.block(node.orelse)

        def execute(frame: Frame) -> object:
            for item in self.items_of(items_of(frame)):
                self.budget.take_steps(weight)
                assign(frame, item)
                ended = body(frame)
                if ended is BREAK:
                    return None
                if ended is not None and ended is not CONTINUE:
                    return ended
            return orelse(frame)

        return execute

    def _while(self, node: ast.While) -> Execute:
        test, weight = self.weighed(lambda: self.expression(node.test))
        body, orelse = self.block(node.body), self.block(node.orelse)

        def execute(frame: Frame) -> object:
            while truth(test(frame)):
                self.budget.take_steps(weight)
                ended = body(frame)
                if ended is BREAK:
                    return None
                if ended is not None and ended is not CONTINUE:
                    return ended
            return orelse(frame)

        return execute

    def _function(self, node: ast.FunctionDef) -> Execute:
        decorate = self.decorators(node.decorator_list)
        defaults = self.defaults(node.args)
        (body, weight), levels = self.depth_of(lambda: self.weighed(lambda: self.body(node)))

        def execute(frame: Frame) -> None:
            home = frame.outer if isinstance(frame, ClassFrame) else frame  # a method does not see the names beside it
            assert home is not None
            self.budget.take_steps(STEPS_OF_FUNCTION)
            function = Function(node.name, node.args, body, home, levels, weight + 1, defaults(frame))
            frame.set(node.name, decorate(frame, function))

        return execute

    def body(self, node: ast.FunctionDef) -> Callable[[Frame], Value]:
        """The function that gives what a call returns."""
        block = self.block(node.body)

        def body(frame: Frame) -> Value:
            line = self.line
            ended = block(frame)
            self.line = line
            return ended.value if isinstance(ended, _Returned) else None

        return body

    def decorators(self, nodes: list[ast.expr]) -> Callable[[Frame, Value], Value]:
        """The function that puts the decorators of a function or a class around it."""
        parts = [(self.expression(node), node.lineno) for node in reversed(nodes)]

        def decorate(frame: Frame, value: Value) -> Value:
            for decorator_of, line in parts:
                decorator = decorator_of(frame)
                if not isinstance(decorator, Decorator):
                    known = "property, staticmethod, classmethod and dataclass"
                    raise RefusalError(f"{describe(decorator)} as a decorator is not read; only {known} are", line)
                value = decorator.around(value)
            return value

        return decorate

    def _return(self, node: ast.Return) -> Execute:
        if node.value is None:
            return lambda _: _Returned(None)
        evaluate = self.expression(node.value)
        return lambda frame: _Returned(evaluate(frame))

    def _names_elsewhere(self, node: ast.Global | ast.Nonlocal) -> Execute:
        def execute(frame: Frame) -> None:
            for name in node.names:
                if isinstance(node, ast.Nonlocal) or not frame.is_module():
                    frame.declare(name, nonlocal_=isinstance(node, ast.Nonlocal))

        return execute

    def _delete(self, node: ast.Delete) -> Execute:
        deletes = [self._deletion(target) for target in node.targets]

        def execute(frame: Frame) -> None:
            for delete in deletes:
                delete(frame)

        return execute

    def _deletion(self, target: ast.expr) -> Callable[[Frame], None]:
        if isinstance(target, ast.Name):
            name = target.id
            return lambda frame: frame.delete(name)
        if not isinstance(target, ast.Subscript):
            raise RefusalError(f"`del` of {type(target).__name__} is not read", target.lineno)
        owner_of, key_of = self.expression(target.value), self.key(target.slice)

        def delete(frame: Frame) -> None:
            owner, key = owner_of(frame), key_of(frame)
            if (isinstance(owner, dict) and dict_key(key) in owner) or (
                isinstance(owner, list)
                and (isinstance(key, slice) or -len(owner) <= whole(key, "a place") < len(owner))
            ):
                if isinstance(owner, list):
                    take_moved(owner, key, self.budget)
                del owner[key]
            else:
                raise RefusalError(f"{describe(owner)} has no place {describe(key)}")

        return delete
