"""Sets of a script. They keep the order in which their members came, so that a script gives the same layout again."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable

from lidardraft.drafting.script.arithmetic import dict_key
from lidardraft.drafting.script.formatting import to_text
from lidardraft.drafting.script.limits import Budget, RaisedError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe, elements


class Set(Record):
    """Members, each of them once."""

    kind = "a set"

    def __init__(self, members: Iterable[Value], budget: Budget) -> None:
        self._members = dict.fromkeys(map(dict_key, members))
        self._budget = budget
        budget.take_cells(3 * len(self._members))

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "add": self._add,
            "update": self._update,
            "discard": lambda member: self._members.pop(self._key(member), None),
            "remove": self._remove,
            "clear": self._members.clear,
            "copy": lambda: self._with(self._members),
            "union": lambda *others: self._with(
                [*self._members, *(item for each in others for item in self._of(each))]
            ),
            "intersection": lambda other: self._with(self._shared(self._of(other))),
            "difference": lambda other: self._with(self._without(self._of(other))),
            "issubset": lambda other: not self._without(self._of(other)),
            "isdisjoint": lambda other: not self._shared(self._of(other)),
        }
        return Builtin(f"set.{name}", methods[name]) if name in methods else super().attribute(name)

    def elements(self) -> list[Value]:
        return list(self._members)

    def length(self) -> int:
        return len(self._members)

    def contains(self, value: Value) -> bool:
        return dict_key(value) in self._members

    def truth(self) -> bool:
        return bool(self._members)

    def equals(self, other: Value) -> bool:
        if isinstance(other, Set):
            self._budget.take_steps(len(self._members) // 4)
            self._budget.take_compared(*self._members)
        return isinstance(other, Set) and self._members == other._members

    def text(self, _as_repr: bool) -> str:
        return f"{{{to_text(list(self._members), self._budget)[1:-1]}}}" if self._members else "set()"

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        if not isinstance(other, Set) or operator not in (ast.BitOr, ast.BitAnd, ast.Sub, ast.BitXor):
            return super().binary(operator, other, reflected=reflected)
        others = self._of(other)
        if operator is ast.BitOr:
            return self._with([*self._members, *others])
        if operator is ast.BitAnd:
            return self._with(self._shared(others))
        more = other._without(self._members) if operator is ast.BitXor else []
        return self._with([*self._without(others), *more])

    def _key(self, member: Value) -> Value:
        self._budget.take_compared(member)
        return dict_key(member)

    def _add(self, member: Value) -> None:
        self._budget.take_cells(3)
        self._members[self._key(member)] = None

    def _update(self, *others: Value) -> None:
        for other in others:
            self._members |= self._of(other)

    def _remove(self, member: Value) -> None:
        if self._key(member) not in self._members:
            raise RaisedError("KeyError", f"{describe(member)} is not in the set")
        del self._members[member]

    def _of(self, other: Value) -> dict[Value, None]:
        found = elements(other, self._budget)
        self._budget.take_steps(3)
        self._budget.take_cells(3 * len(found))
        return dict.fromkeys(map(dict_key, found))

    def _shared(self, others: dict[Value, None]) -> list[Value]:
        self._budget.take_cells(len(self._members))
        return [member for member in self._members if member in others]

    def _without(self, others: dict[Value, None]) -> list[Value]:
        self._budget.take_cells(len(self._members))
        return [member for member in self._members if member not in others]

    def _with(self, members: Iterable[Value]) -> Set:
        return Set(members, self._budget)
