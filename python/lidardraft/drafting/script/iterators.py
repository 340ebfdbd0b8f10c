"""What is gone through once: generators, and the counts that never end."""

from __future__ import annotations

from collections.abc import Iterator as Going

from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.values import Record, Value, describe, elements


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


class Endless(Record):
    """Values without an end; a loop, `zip`, `next` and `islice` take as many as they need."""

    kind = "a sequence without an end"

    def __init__(self, values: Going[Value]) -> None:
        self._values = values

    def rest(self) -> Going[Value]:
        """All that are left."""
        return self._values

    def next(self, *_default: Value) -> Value:
        """The value that comes next."""
        return next(self._values)


def iterator(value: Value, budget: Budget) -> Value:
    """What `iter` gives."""
    return value if isinstance(value, Iterator | Endless) else Iterator(elements(value, budget))


def going(value: Value, budget: Budget) -> Going[Value]:
    """What takes one value after the other out of it; an iterator that is shared goes on for all who share it."""
    return value.rest() if isinstance(value, Iterator | Endless) else iter(elements(value, budget))


def next_value(value: Value, default: tuple[Value, ...]) -> Value:
    """What `next` gives."""
    if not isinstance(value, Iterator | Endless):
        raise RefusalError(f"{describe(value)} is no iterator")
    return value.next(*default)
