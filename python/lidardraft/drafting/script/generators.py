"""Functions with `yield`: they are carried out from one value to the next, as far as their values are asked for."""

from __future__ import annotations

import ast
from collections.abc import Callable, Generator, Iterator

from lidardraft.drafting.script.class_statements import ClassStatements
from lidardraft.drafting.script.frame import Frame
from lidardraft.drafting.script.iterators import Lazy
from lidardraft.drafting.script.limits import Limits, RefusalError
from lidardraft.drafting.script.statements import BREAK, CONTINUE
from lidardraft.drafting.script.values import Value, truth

Going = Generator[Value, None, object]  # its values, and then what ends the statements around it early, or None
# A statement of a generator: its line, what carries it out, or what does if it holds a `yield`, and its nodes then.
_Part = tuple[int, Callable[[Frame], object], Callable[[Frame], Going] | None, int]
_STEPS = 7  # that going on with a generator costs more than with any iterator
_END = object()
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)


def yielding_nodes(tree: ast.Module) -> set[ast.AST]:
    """The functions that have a `yield`, and all in them that holds it."""
    above: dict[ast.AST, ast.AST] = {}
    found: set[ast.AST] = set()
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        for child in ast.iter_child_nodes(node):
            above[child] = node
            waiting.append(child)
        if isinstance(node, ast.Yield | ast.YieldFrom):
            while node in above and node not in found:
                found.add(node)
                if isinstance(node, _FUNCTIONS):
                    break
                node = above[node]
    return found


class YieldedValues(Lazy):
    """The values of a function with `yield`."""

    kind = "a generator"


class Generators(ClassStatements):
    """Adds functions with `yield` to the other statements; `yielding` is what holds one in the script that is read."""

    def __init__(self, limits: Limits) -> None:
        super().__init__(limits)
        self.yielding: set[ast.AST] = set()

    def body(self, node: ast.FunctionDef) -> Callable[[Frame], Value]:
        if node not in self.yielding:
            return super().body(node)
        run, levels = self.depth_of(lambda: self._part(node.body))

        def body(frame: Frame) -> Value:
            return YieldedValues(self._resumed(run(frame)), self.budget, levels)

        return body

    def _resumed(self, going: Going) -> Iterator[Value]:
        """The values, between which the statements that ask for them are carried out."""
        while True:
            line = self.line
            self.budget.take_steps(_STEPS)
            value = next(going, _END)
            self.line = line
            if value is _END:
                return
            yield value

    def _part(self, nodes: list[ast.stmt]) -> Callable[[Frame], Going]:
        """Statements of a generator: those without a `yield` are carried out as anywhere else."""
        outside, parts = self.nodes, list[_Part]()
        for node in nodes:
            if node not in self.yielding or isinstance(node, ast.FunctionDef | ast.ClassDef):
                parts.append((node.lineno, self.block([node]), None, 0))
                continue
            self.nodes = 1
            self.go_deeper(node.lineno)
            yielding = self._yielding(node)
            parts.append((node.lineno, yielding, yielding, self.nodes))
            self.depth -= 1
        self.nodes = outside

        def run(frame: Frame) -> Going:
            for line, plain, yielding, weight in parts:
                self.line = line
                try:
                    self.budget.take_steps(weight)
                    ended = plain(frame) if yielding is None else (yield from yielding(frame))
                except RefusalError as refusal:
                    raise refusal.at(line) from None
                if ended is not None:
                    return ended
            return None

        return run

    def _yielding(self, node: ast.stmt) -> Callable[[Frame], Going]:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Yield | ast.YieldFrom):
            return self._values(node.value)
        if isinstance(node, ast.If):
            test, body, orelse = self.expression(node.test), self._part(node.body), self._part(node.orelse)
            return lambda frame: body(frame) if truth(test(frame)) else orelse(frame)
        if isinstance(node, ast.For | ast.While):
            return self._loop(node)

        def refused(_: Frame) -> Going:
            raise RefusalError("a yield in this statement is not read", node.lineno)

        return refused

    def _values(self, node: ast.Yield | ast.YieldFrom) -> Callable[[Frame], Going]:
        value_of = (lambda _: None) if node.value is None else self.expression(node.value)
        is_one = isinstance(node, ast.Yield)

        def run(frame: Frame) -> Going:
            if is_one:
                yield value_of(frame)
            else:
                yield from self.items_of(value_of(frame))
            return None

        return run

    def _loop(self, node: ast.For | ast.While) -> Callable[[Frame], Going]:
        rounds, weight = self.weighed(lambda: self._rounds_of_loop(node))
        body, orelse = self._part(node.body), self._part(node.orelse)

        def run(frame: Frame) -> Going:
            for _ in rounds(frame):
                self.budget.take_steps(weight)
                ended = yield from body(frame)
                if ended is BREAK:
                    return None
                if ended is not None and ended is not CONTINUE:
                    return ended
            return (yield from orelse(frame))

        return run

    def _rounds_of_loop(self, node: ast.For | ast.While) -> Callable[[Frame], Iterator[None]]:
        """The function that goes on to the next round of a loop each time."""
        if isinstance(node, ast.While):
            test = self.expression(node.test)

            def while_(frame: Frame) -> Iterator[None]:
                while truth(test(frame)):
                    yield

            return while_
        items_of, assign = self.expression(node.iter), self.target(node.target)

        def for_(frame: Frame) -> Iterator[None]:
            for item in self.items_of(items_of(frame)):
                assign(frame, item)
                yield

        return for_
