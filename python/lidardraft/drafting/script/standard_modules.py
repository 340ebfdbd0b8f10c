"""The modules of Python's own library as a script sees them: what is in them that changes nothing outside."""

from __future__ import annotations

from collections.abc import Callable

from lidardraft.drafting.script.argparse_module import argparse_module
from lidardraft.drafting.script.arithmetic import is_key
from lidardraft.drafting.script.class_parts import AutoValue, BaseMarker, Decorator, FieldDefault
from lidardraft.drafting.script.class_statements import Suppressed
from lidardraft.drafting.script.classes import ClassFrame, ScriptClass, dataclass
from lidardraft.drafting.script.clock_modules import clock_modules
from lidardraft.drafting.script.copy_module import copy_module
from lidardraft.drafting.script.frame import Frame
from lidardraft.drafting.script.itertools_module import itertools_module
from lidardraft.drafting.script.json_module import json_module
from lidardraft.drafting.script.limits import Budget, RefusalError
from lidardraft.drafting.script.methods import count_into
from lidardraft.drafting.script.os_modules import os_modules
from lidardraft.drafting.script.silent_modules import silent_modules
from lidardraft.drafting.script.values import (
    Builtin,
    Counter,
    DefaultDict,
    Deque,
    Namespace,
    Record,
    Value,
    describe,
    elements,
    length,
    text,
)

Call = Callable[[Value, list[Value], dict[str, Value]], Value]


def standard_modules(budget: Budget, call: Call, note: Callable[[str], None]) -> dict[str, Value]:
    """The modules by their names."""
    enum = {name: BaseMarker(name) for name in ("Enum", "IntEnum", "StrEnum")}
    modules: dict[str, dict[str, Value]] = {
        "itertools": itertools_module(budget, call),
        "functools": _functools(budget, call),
        "collections": _collections(budget, call),
        "contextlib": {"suppress": Builtin("suppress", Suppressed)},
        "dataclasses": {"dataclass": Decorator(dataclass), "field": Builtin("field", FieldDefault)},
        "enum": {**enum, "auto": Builtin("auto", AutoValue)},
        "abc": {"ABC": BaseMarker("object"), "abstractmethod": Decorator(lambda function: function)},
        "copy": copy_module(budget),
        "json": json_module(budget),
        "argparse": argparse_module(budget, call),
        **os_modules(budget, note),
        **clock_modules(note),
        **silent_modules(),
    }
    return {name: Namespace(name, values) for name, values in modules.items()}


class Cached(Record):
    """A function that is called once for the same arguments, as `functools.cache` makes it."""

    kind = "a cached function"

    def __init__(self, function: Value, budget: Budget, call: Call) -> None:
        self._function = function
        self._budget = budget
        self._run = call
        self._results: dict[Value, Value] = {}

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        key = (*arguments, *keywords.items())
        if not all(is_key(each) for each in (*arguments, *keywords.values())):
            raise RefusalError("a cached function of what cannot be a key")
        self._budget.take_cells(3 + len(key))
        if key not in self._results:
            self._results[key] = self._run(self._function, arguments, keywords)
        return self._results[key]


class Partial(Record):
    """A function with its first arguments, and some of its named ones."""

    kind = "a partial function"

    def __init__(self, function: Value, arguments: tuple[Value, ...], keywords: dict[str, Value], call: Call) -> None:
        self._function = function
        self._arguments = arguments
        self._keywords = keywords
        self._run = call
        self.depth: int = 1 + (function.depth if isinstance(function, Partial) else 0)
        if self.depth > 8:
            raise RefusalError("partial of partial of more than 8 functions")

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        return self._run(self._function, [*self._arguments, *arguments], self._keywords | keywords)


def _functools(budget: Budget, call: Call) -> dict[str, Value]:
    def partial(function: Value, *arguments: Value, **keywords: Value) -> Partial:
        budget.take_cells(len(arguments) + 3 * len(keywords))
        return Partial(function, arguments, keywords, call)

    def reduce(function: Value, items: Value, *start: Value) -> Value:
        found = [*start[:1], *elements(items, budget)]
        budget.take_steps(5 * len(found))
        if not found:
            raise RefusalError("reduce of nothing")
        result = found[0]
        for item in found[1:]:
            result = call(function, [result, item], {})
        return result

    cached = Decorator(lambda function: Cached(function, budget, call))
    functions = {"partial": Builtin("partial", partial), "reduce": Builtin("reduce", reduce)}
    return {**functions, "cache": cached, "lru_cache": cached}


def _collections(budget: Budget, call: Call) -> dict[str, Value]:
    def defaultdict(default_factory: Value = None, *pairs: Value) -> DefaultDict:
        if pairs and not isinstance(pairs[0], dict):
            raise RefusalError(f"a defaultdict of {describe(pairs[0])} is not read")
        budget.take_cells(3 + 3 * length(pairs[0] if pairs else ()))
        found = DefaultDict(pairs[0] if pairs else {})
        found.factory = default_factory
        return found

    def counter(items: Value = ()) -> Counter:
        found = Counter()
        count_into(found, items, budget)
        return found

    def namedtuple(typename: Value, field_names: Value, **_: Value) -> ScriptClass:
        given = field_names.replace(",", " ").split() if isinstance(field_names, str) else elements(field_names, budget)
        names = [text(name, "the name of a field") for name in given]
        if len(names) > 100 or not all(name.isidentifier() and not name.startswith("_") for name in names):
            raise RefusalError(f"namedtuple of {describe(field_names)} is not read")
        body = ClassFrame(Frame(None, {}))
        body.annotated = names
        return ScriptClass(text(typename, "the name"), BaseMarker("NamedTuple"), body, budget, call)

    table: dict[str, Callable[..., Value]] = {
        "defaultdict": defaultdict,
        "Counter": counter,
        "deque": lambda items=(): Deque(elements(items, budget)),
        "namedtuple": namedtuple,
        "OrderedDict": lambda pairs=(): dict(elements(pairs, budget)),
    }
    return {name: Builtin(name, function) for name, function in table.items()}
