"""What is gone through once: values that are made already, those that are made when asked for, those without an end."""

from __future__ import annotations

from collections.abc import Iterator as Going

from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.values import Record, Value, describe, elements

_CELLS = 50  # that the state of what is made when asked for takes


class Iterator(Record):
    """Values that are handed out one after the other, each of them once; all of them are made already."""

    kind = "an iterator"

    def __init__(self, items: list[Value]) -> None:
        self._items = items
        self._place = 0

    def length(self) -> int:
        raise RefusalError("an iterator has no length")

    def left(self) -> int:
        """How many values have not been handed out."""
        return len(self._items) - self._place

    def rest(self) -> Going[Value]:
        """All that are left, of which each is gone once it is handed out."""
        while self._place < len(self._items):
            self._place += 1
            yield self._items[self._place - 1]

    def elements(self) -> list[Value]:
        rest, self._place = self._items[self._place :], len(self._items)
        return rest

    def next(self, *default: Value) -> Value:
        """The value that comes next, or `default` where none does."""
        if self._place == len(self._items):
            if default:
                return default[0]
            raise RaisedError("StopIteration", "next: there is no value left")
        self._place += 1
        return self._items[self._place - 1]


class Lazy(Record):
    """Values each of which is made when it is asked for, as all else may happen between two of them.

    `levels` are the nodes within nodes that making one goes through.
    """

    kind = "an iterator"

    def __init__(self, values: Going[Value], budget: Budget, levels: int = 1) -> None:
        budget.take_cells(_CELLS)
        self._values = values
        self._budget = budget
        self._levels = levels
        self._is_running = False

    def length(self) -> int:
        raise RefusalError(f"{self.kind} has no length")

    def rest(self) -> Going[Value]:
        """All that are left, of which each is gone once it is handed out."""
        budget = self._budget
        while True:
            if self._is_running:
                raise RefusalError(f"{self.kind} that goes on with itself")
            budget.take_steps(1)
            budget.go_within(self._levels)
            self._is_running = True
            try:
                value = next(self._values, self)
            finally:
                self._is_running = False
            budget.levels -= self._levels
            if value is self:
                return
            yield value

    def elements(self) -> list[Value]:
        found = []
        for value in self.rest():
            self._budget.take_cells(1)
            found.append(value)
        return found

    def next(self, *default: Value) -> Value:
        """The value that comes next, or `default` where none does."""
        for value in self.rest():
            return value
        if not default:
            raise RaisedError("StopIteration", "next: there is no value left")
        return default[0]


class Endless(Lazy):
    """Values without an end; a loop, `zip`, `next` and `islice` take as many as they need."""

    kind = "a sequence without an end"

    def elements(self) -> list[Value]:
        raise RefusalError(f"{self.kind} cannot be made a list of")


def iterator(value: Value, budget: Budget) -> Value:
    """What `iter` gives."""
    return value if isinstance(value, Iterator | Lazy) else Iterator(elements(value, budget))


def going(value: Value, budget: Budget) -> Going[Value]:
    """What takes one value after the other out of it; an iterator that is shared goes on for all who share it."""
    return value.rest() if isinstance(value, Iterator | Lazy) else iter(elements(value, budget))


def next_value(value: Value, default: tuple[Value, ...]) -> Value:
    """What `next` gives."""
    if not isinstance(value, Iterator | Lazy):
        raise RefusalError(f"{describe(value)} is no iterator")
    return value.next(*default)
