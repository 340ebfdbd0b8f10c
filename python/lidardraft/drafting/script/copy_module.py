"""`copy` as a script sees it."""

from __future__ import annotations

import copy

from lidardraft.drafting.script.builtin_functions import has
from lidardraft.drafting.script.classes import Instance
from lidardraft.drafting.script.limits import Budget, RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value, describe

_DEEPEST = 30


def copy_module(budget: Budget) -> dict[str, Value]:
    """`copy` and `deepcopy`."""

    def shallow(x: Value) -> Value:
        if isinstance(x, list | dict):
            budget.take_cells(3 * len(x))
            return copy.copy(x)
        if isinstance(x, Instance) and not x.of.is_enumeration:
            budget.take_cells(3 + 3 * len(x.values))
            other = Instance(x.of)
            other.values = dict(x.values)
            return other
        if not isinstance(x, Record) or not has(x, "copy"):
            return x  # a number, a text, a tuple, a function or a class, which nothing changes
        budget.take_steps(x.weight + 1)
        return x.attribute("copy").call([], {})

    def deep(x: Value, known: dict[int, Value], level: int) -> Value:
        budget.take_steps(2)
        if level > _DEEPEST:
            raise RefusalError(f"deepcopy of {describe(x)}, more than {_DEEPEST} levels deep")
        if id(x) in known or not isinstance(x, list | tuple | dict | Record):
            return known.get(id(x), x)
        if isinstance(x, tuple):
            return tuple(deep(item, known, level + 1) for item in x)
        known[id(x)] = other = shallow(x)
        if isinstance(other, list):
            other[:] = [deep(item, known, level + 1) for item in other]
        elif isinstance(other, dict | Instance):
            values = other.values if isinstance(other, Instance) else other
            for key, item in values.items():
                values[key] = deep(item, known, level + 1)
        return other

    return {"copy": Builtin("copy.copy", shallow), "deepcopy": Builtin("copy.deepcopy", lambda x: deep(x, {}, 0))}
