"""Expressions with operators: sums, signs, comparisons, `and`, `or` and `if`."""

from __future__ import annotations

import ast

from lidardraft.drafting.script.arithmetic import binary, compare, unary
from lidardraft.drafting.script.expressions import Evaluate, Expressions
from lidardraft.drafting.script.frame import Frame
from lidardraft.drafting.script.limits import Limits, RefusalError
from lidardraft.drafting.script.values import Value, truth


class Operators(Expressions):
    """Adds these to the other expressions."""

    def __init__(self, limits: Limits) -> None:
        super().__init__(limits)
        self.makers |= {
            ast.BinOp: self._binary,
            ast.UnaryOp: self._unary,
            ast.BoolOp: self._boolean,
            ast.Compare: self._compare,
            ast.IfExp: self._conditional,
        }

    def _binary(self, node: ast.BinOp) -> Evaluate:
        kind, left, right, line = type(node.op), self.expression(node.left), self.expression(node.right), node.lineno
        budget = self.budget

        def evaluate(frame: Frame) -> Value:
            try:
                return binary(kind, left(frame), right(frame), budget)
            except RefusalError as refusal:
                raise refusal.at(line) from None

        return evaluate

    def _unary(self, node: ast.UnaryOp) -> Evaluate:
        kind, operand = type(node.op), self.expression(node.operand)
        return lambda frame: unary(kind, operand(frame))

    def _boolean(self, node: ast.BoolOp) -> Evaluate:
        wanted, parts = isinstance(node.op, ast.Or), [self.expression(part) for part in node.values]

        def evaluate(frame: Frame) -> Value:
            value = None
            for part in parts:
                value = part(frame)
                if truth(value) == wanted:
                    break
            return value

        return evaluate

    def _compare(self, node: ast.Compare) -> Evaluate:
        first = self.expression(node.left)
        rest = [(type(op), self.expression(part)) for op, part in zip(node.ops, node.comparators, strict=True)]

        def evaluate(frame: Frame) -> Value:
            left = first(frame)
            for kind, part in rest:
                right = part(frame)
                if not compare(kind, left, right, self.budget):
                    return False
                left = right
            return True

        return evaluate

    def _conditional(self, node: ast.IfExp) -> Evaluate:
        test, body, orelse = self.expression(node.test), self.expression(node.body), self.expression(node.orelse)
        return lambda frame: body(frame) if truth(test(frame)) else orelse(frame)
