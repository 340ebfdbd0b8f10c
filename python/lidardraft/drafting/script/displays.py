"""Expressions that hold others: lists, dicts, comprehensions, f-strings and lambdas."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator

from lidardraft.drafting.script.arithmetic import dict_key
from lidardraft.drafting.script.expressions import Evaluate
from lidardraft.drafting.script.formatting import format_value, to_text
from lidardraft.drafting.script.frame import STEPS_OF_FUNCTION, Frame, Function
from lidardraft.drafting.script.iterators import Lazy
from lidardraft.drafting.script.limits import Limits, RefusalError
from lidardraft.drafting.script.operators import Operators
from lidardraft.drafting.script.values import Value, truth


class Displays(Operators):
    """Adds these to the other expressions."""

    def __init__(self, limits: Limits) -> None:
        super().__init__(limits)
        self.makers |= {
            ast.List: self._list,
            ast.Tuple: self._tuple,
            ast.Set: self._set,
            ast.Dict: self._dict,
            ast.Lambda: self._lambda,
            ast.JoinedStr: self._formatted_text,
            ast.FormattedValue: self._formatted_value,
            ast.ListComp: self._list_comprehension,
            ast.GeneratorExp: self._generator,
            ast.NamedExpr: self._named,
            ast.SetComp: self._set_comprehension,
            ast.DictComp: self._dict_comprehension,
        }

    def _list(self, node: ast.List) -> Evaluate:
        return self.items(node.elts)

    def _tuple(self, node: ast.Tuple) -> Evaluate:
        items_of = self.items(node.elts)
        return lambda frame: tuple(items_of(frame))

    def _set(self, node: ast.Set) -> Evaluate:
        items_of = self.items(node.elts)
        return lambda frame: self.call(self.builtins.variables["set"], [items_of(frame)])

    def _dict(self, node: ast.Dict) -> Evaluate:
        parts = [
            (None if key is None else self.expression(key), self.expression(value))
            for key, value in zip(node.keys, node.values, strict=True)
        ]

        def evaluate(frame: Frame) -> Value:
            found: dict[Value, Value] = {}
            self.budget.take_cells(3 * len(parts))
            for key_of, value_of in parts:
                if key_of is None:
                    found |= self.call(self.builtins.variables["dict"], [value_of(frame)])
                else:
                    found[dict_key(key_of(frame))] = value_of(frame)
            return found

        return evaluate

    def _lambda(self, node: ast.Lambda) -> Evaluate:
        (body, weight), levels = self.depth_of(lambda: self.weighed(lambda: self.expression(node.body)))
        defaults = self.defaults(node.args)

        def evaluate(frame: Frame) -> Value:
            self.budget.take_steps(STEPS_OF_FUNCTION)
            return Function("<lambda>", node.args, body, frame, levels, weight, defaults(frame))

        return evaluate

    def defaults(self, arguments: ast.arguments) -> Callable[[Frame], list[Value]]:
        """The function that gives the values of the defaults of a function, those of keyword-only arguments last."""
        parts = [
            None if node is None else self.expression(node) for node in (*arguments.defaults, *arguments.kw_defaults)
        ]
        return lambda frame: [None if part is None else part(frame) for part in parts]

    def _formatted_text(self, node: ast.JoinedStr) -> Evaluate:
        parts = [self.expression(part) for part in node.values]

        def evaluate(frame: Frame) -> Value:
            texts = [part(frame) for part in parts]
            self.budget.take_text(sum(map(len, texts)))
            return "".join(texts)

        return evaluate

    def _formatted_value(self, node: ast.FormattedValue) -> Evaluate:
        value_of = self.expression(node.value)
        as_repr, as_text = node.conversion in (ord("r"), ord("a")), node.conversion == ord("s")
        spec_of = (lambda _: "") if node.format_spec is None else self.expression(node.format_spec)

        def evaluate(frame: Frame) -> Value:
            value = value_of(frame)
            if as_repr or as_text:
                value = to_text([value], self.budget)[1:-1] if as_repr else to_text(value, self.budget)
            return format_value(value, spec_of(frame), self.budget)

        return evaluate

    def _list_comprehension(self, node: ast.ListComp | ast.SetComp) -> Evaluate:
        element_of, weight = self.weighed(lambda: self.expression(node.elt))
        rounds = self._rounds(node.generators)

        def evaluate(frame: Frame) -> Value:
            found: list[Value] = []
            for inner in rounds(Frame(frame, {})):
                self.budget.take_steps(weight)
                self.budget.take_cells(1)
                found.append(element_of(inner))
            return found

        return evaluate

    def _generator(self, node: ast.GeneratorExp) -> Evaluate:
        (element_of, weight), levels = self.depth_of(lambda: self.weighed(lambda: self.expression(node.elt)))
        rounds, more = self.depth_of(lambda: self._rounds(node.generators))

        def values(inner_frames: Iterator[Frame]) -> Iterator[Value]:
            for inner in inner_frames:
                self.budget.take_steps(weight)
                yield element_of(inner)

        return lambda frame: Lazy(values(rounds(Frame(frame, {}))), self.budget, max(levels, more))

    def _named(self, node: ast.NamedExpr) -> Evaluate:
        name, value_of = node.target.id, self.expression(node.value)

        def evaluate(frame: Frame) -> Value:
            value = value_of(frame)
            frame.set(name, value)
            return value

        return evaluate

    def _set_comprehension(self, node: ast.SetComp) -> Evaluate:
        items_of = self._list_comprehension(node)
        return lambda frame: self.call(self.builtins.variables["set"], [items_of(frame)])

    def _dict_comprehension(self, node: ast.DictComp) -> Evaluate:
        (key_of, value_of), weight = self.weighed(lambda: (self.expression(node.key), self.expression(node.value)))
        rounds = self._rounds(node.generators)

        def evaluate(frame: Frame) -> Value:
            found: dict[Value, Value] = {}
            for inner in rounds(Frame(frame, {})):
                self.budget.take_steps(weight)
                self.budget.take_cells(3)
                found[dict_key(key_of(inner))] = value_of(inner)
            return found

        return evaluate

    def _rounds(self, generators: list[ast.comprehension]) -> Callable[[Frame], Iterator[Frame]]:
        """The function that gives the frame of a comprehension, once for each of its rounds.

        What the first loop goes through is looked up at once, as Python does.
        """
        first, rest = generators[0], generators[1:]
        if first.is_async:
            raise RefusalError("async is not read in a script", first.target.lineno)
        items_of = self.expression(first.iter)
        assign, weight = self.weighed(lambda: self.target(first.target))
        tests, more = self.weighed(lambda: [self.expression(test) for test in first.ifs])
        within = self._rounds(rest) if rest else None

        def each(frame: Frame, items: Iterator[Value]) -> Iterator[Frame]:
            for item in items:
                self.budget.take_steps(weight + more)
                assign(frame, item)
                if all(truth(test(frame)) for test in tests):
                    if within is None:
                        yield frame
                    else:
                        yield from within(frame)

        return lambda frame: each(frame, self.items_of(items_of(frame)))
