"""The modules that a script may import: those of Python's library that compute, and those that access its surroundings.
Of these nothing is known but the names: no file is read, logs are dropped, and the clock stands still."""

from __future__ import annotations

import itertools
import math
import random
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import ClassVar

from lidardraft.drafting.blender.script.containers import Lazy, iterate, to_dict
from lidardraft.drafting.blender.script.definitions import (
    BaseMarker,
    Decorator,
    FieldDefault,
    dataclass,
)
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Methods,
    Namespace,
    Outside,
    Record,
    Value,
    builtins,
    call,
    checked,
    describe,
    elements,
    nothing,
    reals,
    whole,
)

_MATH = (
    *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cos", "cosh", "sin", "sinh", "tan", "tanh"),
    *("ceil", "floor", "trunc", "fabs", "fmod", "copysign", "gcd", "hypot", "degrees", "radians"),
    *("exp", "log", "log10", "log2", "pow", "sqrt", "isqrt", "modf", "isclose", "isfinite", "isinf", "isnan"),
)
_LARGEST_FACTORIAL = 20  # the largest below 2^63
_DRAWS = (
    *("random", "uniform", "gauss", "normalvariate", "lognormvariate", "expovariate", "triangular"),
    *("randint", "randrange"),
)
_CELLS_OF_GENERATOR = 300
_WIDEST = 16
SCRIPT_FILE = "/script.py"  # the script's file name, as the script sees it
_CLOCKS = ("time", "perf_counter", "monotonic", "process_time")
# Modules that no shape depends on, and parts of `os` likewise.
_SILENT = ("argparse", "datetime", "gc", "logging", "pathlib", "traceback", "warnings")
_OF_FILES = ("path", "environ", "getenv", "getcwd", "makedirs", "mkdir")


def modules(script: Script) -> dict[str, Value]:
    """The modules by name."""

    def now() -> float:
        script.note("the time is taken as 0")
        return 0.0

    tables: dict[str, dict[str, Value]] = {
        "math": _math(script),
        "itertools": {**builtins("", _itertools(script)), "chain": _chain(script)},
        "functools": _functools(script),
        "collections": builtins("", _collections(script)),
        "dataclasses": {"dataclass": Decorator(dataclass), "field": Builtin("field", FieldDefault)},
        "abc": {"ABC": BaseMarker("object"), "abstractmethod": Decorator(lambda function: function)},
        "time": builtins("time.", dict.fromkeys(_CLOCKS, now) | {"sleep": nothing}),
        "sys": {"argv": ["blender"], "path": [], "version_info": (3, 11, 0), "exit": Builtin("sys.exit", _leave)}
        | {name: Outside(f"sys.{name}", silent=True) for name in ("stdout", "stderr")},
        "os": {name: Outside(f"os.{name}", silent=True) for name in _OF_FILES},
    }
    known: dict[str, Value] = {name: Namespace(name, values) for name, values in tables.items()}
    known |= {name: Outside(name, silent=True) for name in _SILENT}
    return known | {"random": RandomNumbers(script), "typing": Annotations(), "__future__": Annotations()}


def _math(script: Script) -> dict[str, Value]:
    def bounded(function: Callable[..., Value]) -> Callable[..., Value]:
        return lambda *arguments, **keywords: checked(function(*arguments, **keywords))

    functions = {name: bounded(getattr(math, name)) for name in _MATH}
    functions |= {
        "factorial": lambda n: math.factorial(whole(n, "the number", most=_LARGEST_FACTORIAL)),
        "dist": lambda a, b: math.dist(elements(a, script), elements(b, script)),
        "fsum": lambda items: math.fsum(elements(items, script)),
    }
    return builtins("math.", functions) | {name: getattr(math, name) for name in ("pi", "tau", "e", "inf", "nan")}


class RandomNumbers(Record):
    """`random`, or a `random.Random`: the numbers of Python's generator for a seed, by default 0; drawing without a set
    seed gives a note."""

    kind = "random"

    def __init__(self, script: Script, seed: Value = None) -> None:
        self.script = script
        self._generator = random.Random()
        self._seed(seed)
        self._is_seeded = seed is not None

    def _seed(self, a: Value = None) -> None:
        if not isinstance(a, int | float | str | None):
            raise RefusalError(f"the seed is {describe(a)}; it must be a number or a text")
        self._is_seeded = True
        self._generator.seed(0 if a is None else a)

    def _drawn(self, name: str, *arguments: Value, **keywords: Value) -> Value:
        if not self._is_seeded:
            self.script.note("random numbers without a seed: the seed 0 is taken")
        return checked(getattr(self._generator, name)(*arguments, **keywords))

    def _items(self, population: Value, k: Value = 0) -> Value:
        self.script.take_cells(whole(k, "k"))
        return population if isinstance(population, range) else elements(population, self.script)

    def _choices(self, population: Value, weights: Value = None, *, cum_weights: Value = None, k: Value = 1) -> Value:
        items = self._items(population, k)
        shares = [each and reals(each, len(items), "the weights") for each in (weights, cum_weights)]
        return self._drawn("choices", items, shares[0], cum_weights=shares[1], k=k)

    def _shuffle(self, x: Value) -> None:
        if not isinstance(x, list):
            raise RefusalError(f"{describe(x)} cannot be shuffled")
        self._drawn("shuffle", x)

    def _another(self, x: Value = None) -> RandomNumbers:
        self.script.take_cells(_CELLS_OF_GENERATOR)
        return RandomNumbers(self.script, x)

    methods: ClassVar[Methods] = {
        **{name: lambda self, *a, name=name, **k: self._drawn(name, *a, **k) for name in _DRAWS},
        "choice": lambda self, seq: self._drawn("choice", self._items(seq)),
        "sample": lambda self, population, k: self._drawn("sample", self._items(population, k), k),
        "choices": _choices,
        "shuffle": _shuffle,
        "seed": _seed,
        "Random": _another,
    }


def _chain(script: Script) -> Builtin:
    def chain(*lists: Value) -> Value:
        return Lazy((item for items in lists for item in iterate(items, script)), script)

    return Builtin("chain", chain, own={"from_iterable": lambda lists: chain(*elements(lists, script))})


def _itertools(script: Script) -> Methods:
    def product(*columns: Value, repeat: Value = 1) -> Value:
        lists = [elements(column, script) for column in columns] * whole(repeat, "repeat", 0, _WIDEST)
        return Lazy(itertools.product(*lists), script)

    def chosen(choose: Callable[..., Iterator[Value]]) -> Callable[..., Value]:
        def some(items: Value, r: Value = None) -> Value:
            found = elements(items, script)
            width = whole(len(found) if r is None else r, "the number of elements at a time", 0, _WIDEST)
            return Lazy(choose(found, width), script)

        return some

    return {
        "product": product,
        "combinations": chosen(itertools.combinations),
        "permutations": chosen(itertools.permutations),
        "count": lambda start=0, step=1: Lazy(itertools.count(checked(start) + 0, checked(step) + 0), script),
        "repeat": lambda value, *times: Lazy(itertools.repeat(value, *times), script),
        "cycle": lambda items: Lazy(itertools.cycle(iterate(items, script)), script),
        "pairwise": lambda items: Lazy(itertools.pairwise(iterate(items, script)), script),
    }


def _functools(script: Script) -> dict[str, Value]:
    def bound(function: Value, /, *first: Value, **named: Value) -> Builtin:
        def result(*more: Value, **others: Value) -> Value:
            return call(function, [*first, *more], named | others, script)

        return Builtin("partial", result)

    return builtins("", {"partial": bound})


def _collections(script: Script) -> Methods:
    def default_dict(default_factory: Value = None, pairs: Value = (), **keywords: Value) -> dict[Value, Value]:
        factory = None if default_factory is None else lambda: call(default_factory, [], {}, script)
        return defaultdict(factory, to_dict(pairs, keywords, script))

    return {"defaultdict": default_dict}


class Annotations(Record):
    """`typing` and `__future__` with all their contents: annotations are ignored."""

    kind = "an annotation"

    def attribute(self, _name: str) -> Value:
        return self

    def __getitem__(self, _key: Value) -> Value:
        return self


def _leave(code: Value = None) -> None:
    said = "" if code is None else f"{code:.200}" if isinstance(code, str) else describe(code)
    raise RaisedError("SystemExit", "the script ends here", said)
