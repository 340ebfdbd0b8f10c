"""`itertools` as a script sees it: of lists, what has an end is a list, and counted before it is made."""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Callable, Iterator

from lidardraft.drafting.script.arithmetic import binary
from lidardraft.drafting.script.iterators import Endless, Lazy, going
from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.values import Builtin, Value, elements, whole

Call = Callable[[Value, list[Value], dict[str, Value]], Value]


class Chain(Builtin):
    """`itertools.chain`, which can also be given one list of lists."""

    def attribute(self, name: str) -> Value:
        if name != "from_iterable":
            return super().attribute(name)
        return Builtin(f"chain.{name}", lambda lists: self._call(*lists))


def itertools_module(budget: Budget, call: Call) -> dict[str, Value]:
    """The functions by their names."""
    table = _products(budget) | _sequences(budget, call)
    return {"chain": Chain("chain", _chain(budget))} | {name: Builtin(name, each) for name, each in table.items()}


def _products(budget: Budget) -> dict[str, Callable[..., Value]]:
    def counted(count: int, width: int) -> None:
        budget.take_steps(count // 4)
        budget.take_cells(count * (width + 1) if count < budget.limits.length else count)

    def product(*columns: Value, repeat: Value = 1) -> list[Value]:
        if not 0 <= whole(repeat, "repeat") <= 16:
            raise RefusalError(f"product with itself {repeat} times")
        lists = [elements(column, budget) for column in columns] * repeat
        counted(math.prod(map(len, lists)), len(lists))
        return list(itertools.product(*lists))

    def chosen(choose: Callable[..., Value], number: Callable[[int, int], int]) -> Callable[..., Value]:
        def call_(items: Value, r: Value = None) -> list[Value]:
            found = elements(items, budget)
            width = len(found) if r is None else whole(r, "r")
            if not 0 <= width <= 16:
                raise RefusalError(f"{width} at a time; 16 are the most")
            counted(number(len(found), width), width)
            return list(choose(found, width))

        return call_

    return {
        "product": product,
        "combinations": chosen(itertools.combinations, math.comb),
        "permutations": chosen(itertools.permutations, math.perm),
    }


def _chain(budget: Budget) -> Callable[..., Value]:
    def chain(*lists: Value) -> Value:
        budget.take_steps(2 * len(lists))
        if any(isinstance(items, Lazy) for items in lists):
            return Lazy(itertools.chain(*[going(items, budget) for items in lists]), budget)
        parts = [elements(items, budget) for items in lists]
        budget.take_cells(sum(map(len, parts)))
        return [item for part in parts for item in part]

    return chain


def _kept(items: Iterator[Value], budget: Budget) -> Iterator[Value]:
    for item in items:
        budget.take_cells(1)
        yield item


def _sequences(budget: Budget, call: Call) -> dict[str, Callable[..., Value]]:
    def count(start: Value = 0, step: Value = 1) -> Endless:
        if not all(isinstance(number, int | float) for number in (start, step)):
            raise RefusalError("count: a number is no number")
        return Endless(itertools.count(start, step), budget)

    def cycle(items: Value) -> Lazy:
        if isinstance(items, Lazy):
            return Lazy(itertools.cycle(_kept(items.rest(), budget)), budget)
        found = elements(items, budget)
        if not found:
            raise RefusalError("cycle: there is nothing to go through")
        return Endless(itertools.cycle(found), budget)

    def repeat(value: Value, times: Value = None) -> Value:
        if times is None:
            return Endless(itertools.repeat(value), budget)
        budget.take_cells(max(whole(times, "the times"), 0))
        return [value] * times

    def islice(items: Value, *bounds: Value) -> Value:
        if not 1 <= len(bounds) <= 3:
            raise RefusalError("islice takes one to three bounds")
        limits = [None if bound is None else whole(bound, "a bound") for bound in bounds]
        if any(limit is not None and limit < 0 for limit in limits):
            raise RaisedError("ValueError", "islice: a bound below 0")
        part = itertools.islice(going(items, budget), *limits)
        return Lazy(part, budget) if isinstance(items, Lazy) else list(part)

    def sums(items: Iterator[Value], function: Value) -> Iterator[Value]:
        for total in itertools.islice(items, 1):
            yield total
            for item in items:
                budget.take_steps(2)
                total = binary(ast.Add, total, item, budget) if function is None else call(function, [total, item], {})
                yield total

    def accumulate(items: Value, function: Value = None, *, initial: Value = None) -> Value:
        found = going(items, budget)
        found = sums(found if initial is None else itertools.chain([initial], found), function)
        return Lazy(found, budget) if isinstance(items, Lazy) else list(found)

    def pairwise(items: Value) -> Value:
        if isinstance(items, Lazy):
            return Lazy(itertools.pairwise(items.rest()), budget)
        found = elements(items, budget)
        budget.take_cells(3 * len(found))
        return list(itertools.pairwise(found))

    return {
        "count": count,
        "cycle": cycle,
        "repeat": repeat,
        "islice": islice,
        "accumulate": accumulate,
        "pairwise": pairwise,
    }
