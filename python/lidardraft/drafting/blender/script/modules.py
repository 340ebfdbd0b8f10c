"""The modules that a script may import: modules of Python's library that compute, and stubs of those that access its
surroundings. No file is read, logs are dropped, the clock stands still, and arguments have their defaults."""

from __future__ import annotations

import itertools
import math
import posixpath
import random
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import PurePosixPath
from typing import ClassVar

from lidardraft.drafting.blender.script.containers import Lazy, iterate, to_dict
from lidardraft.drafting.blender.script.definitions import (
    AutoValue,
    BaseMarker,
    ClassFrame,
    Decorator,
    FieldDefault,
    ScriptClass,
    dataclass,
)
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.statements import Suppress
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Methods,
    Namespace,
    Record,
    Value,
    builtins,
    call,
    checked,
    describe,
    elements,
    nothing,
    reals,
    text,
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
_LONGEST_PATH = 4096  # characters
_DEFAULTS = {"store_true": False, "store_false": True, "store": None, "append": None, "count": None}
_MESSAGES = ("debug", "info", "warning", "warn", "error", "critical", "exception", "log")
_OF_LOGGERS = (*_MESSAGES, "setLevel", "addHandler", "removeHandler", "setFormatter", "flush", "close")


def modules(script: Script) -> dict[str, Value]:
    """The modules by name."""
    tables: dict[str, dict[str, Value]] = {
        "math": _math(script),
        "itertools": {**builtins("", _itertools(script)), "chain": _chain(script)},
        "functools": _functools(script),
        "collections": builtins("", _collections(script)),
        "dataclasses": {"dataclass": Decorator(dataclass), "field": Builtin("field", FieldDefault)},
        "enum": {"Enum": BaseMarker("Enum"), "auto": Builtin("auto", AutoValue)},
        "abc": {"ABC": BaseMarker("object"), "abstractmethod": Decorator(lambda function: function)},
        "contextlib": {"suppress": Builtin("suppress", _suppress)},
        **_surroundings(script),
    }
    known: dict[str, Value] = {name: Namespace(name, values) for name, values in tables.items()}
    return known | {"random": RandomNumbers(script), "typing": Annotations(), "__future__": Annotations()}


def _surroundings(script: Script) -> dict[str, dict[str, Value]]:
    def at_first(value: Value) -> Callable[..., Value]:
        def now(*_: Value, **__: Value) -> Value:
            script.note("the time is taken as 0")
            return value

        return now

    def getenv(_key: Value, default: Value = None) -> Value:
        script.note("no variable of the environment is read")
        return default

    def logging_to(**named: Value) -> None:
        if named.get("filename") is not None:
            raise RefusalError("a log that is written to a file")

    def path_of(*parts: Value) -> FilePath:
        return FilePath(script, *parts)

    def silent(*names: str) -> dict[str, Value]:
        return builtins("", dict.fromkeys(names, nothing))

    environ = Namespace("os.environ", builtins("os.environ.", {"get": getenv}))
    path = Namespace("os.path", {"sep": "/", **builtins("os.path.", _os_path(script))})
    written: Methods = dict.fromkeys(("strftime", "isoformat"), lambda *_: "")
    moment = Namespace("a moment", builtins("", written | {"timestamp": lambda: 0.0}))
    now = Namespace("datetime", builtins("", dict.fromkeys(("now", "today", "utcnow"), at_first(moment))))
    clocks = ("time", "perf_counter", "monotonic", "process_time")
    logger = Namespace("a logger", {"propagate": True, **silent(*_OF_LOGGERS)})
    loggers = dict.fromkeys(("getLogger", "StreamHandler", "Formatter"), lambda *_, **__: logger)
    levels = {"DEBUG": 10, "INFO": 20, "WARNING": 30, "ERROR": 40, "CRITICAL": 50}
    file_path = Builtin("Path", path_of, own=dict.fromkeys(("cwd", "home"), lambda: path_of("/")))
    return {
        "os": {"path": path, "environ": environ, "name": "posix", "sep": "/", "linesep": "\n"}
        | builtins("os.", {"getenv": getenv, "getcwd": lambda: "/"}),
        "sys": {"argv": ["blender"], "path": [], "platform": "linux", "maxsize": 2**63 - 1, "executable": "python"}
        | {"version": "3.11.0", "version_info": (3, 11, 0), "exit": Builtin("sys.exit", _leave)}
        | {name: Namespace(f"sys.{name}", silent("write", "writelines", "flush")) for name in ("stdout", "stderr")},
        "pathlib": {"Path": file_path, "PurePath": file_path},
        "time": builtins("time.", dict.fromkeys(clocks, at_first(0.0)) | {"sleep": nothing, "strftime": lambda *_: ""}),
        "datetime": {"datetime": now, "date": now},
        "argparse": {"ArgumentParser": Builtin("argparse.ArgumentParser", lambda *_, **__: Parser(script))},
        "logging": levels
        | silent(*_MESSAGES, "disable", "captureWarnings")
        | builtins("logging.", {**loggers, "basicConfig": logging_to}),
        "warnings": silent("warn", "simplefilter", "filterwarnings"),
        "traceback": silent("print_exc"),
        "gc": silent("collect"),
    }


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

    def namedtuple(typename: Value, field_names: Value, **_: Value) -> ScriptClass:
        given = field_names.replace(",", " ").split() if isinstance(field_names, str) else elements(field_names, script)
        names = [text(name, "the name of a field") for name in given]
        if not all(name.isidentifier() and not name.startswith("_") for name in names):
            raise RefusalError(f"namedtuple of {describe(field_names)} is not supported")
        body = ClassFrame(None, script)
        body.annotated = names
        return ScriptClass(text(typename, "the name"), BaseMarker("NamedTuple"), body)

    return {"defaultdict": default_dict, "namedtuple": namedtuple}


def _suppress(*errors: Value) -> Suppress:
    names = [each.error for each in errors if isinstance(each, BaseMarker) and each.error is not None]
    if len(names) != len(errors):
        raise RefusalError("suppress takes Python's own classes of errors")
    return Suppress(names)


class Annotations(Record):
    """`typing` and `__future__` with all their contents: annotations are ignored."""

    kind = "an annotation"

    def attribute(self, name: str) -> Value:
        return BaseMarker(name) if name == "NamedTuple" else self

    def __getitem__(self, _key: Value) -> Value:
        return self


def _leave(code: Value = None) -> None:
    said = "" if code is None else f"{code:.200}" if isinstance(code, str) else describe(code)
    raise RaisedError("SystemExit", "the script ends here", said)


def _os_path(script: Script) -> Methods:
    def of_names(function: Callable[..., Value]) -> Callable[..., Value]:
        return lambda *parts: function(*map(_name_of, parts))

    names = ("basename", "dirname", "splitext", "split", "normpath", "join")
    absolute = dict.fromkeys(("abspath", "realpath"), lambda path: posixpath.normpath(posixpath.join("/", path)))
    functions = {name: getattr(posixpath, name) for name in names} | absolute | {"expanduser": str}
    asked = {name: lambda _, name=name: _no_file(f"os.path.{name}", script) for name in ("exists", "isfile", "isdir")}
    return {name: of_names(function) for name, function in functions.items()} | asked


def _no_file(asked: str, script: Script) -> bool:
    script.note(f"no file is looked at: {asked} says False")
    return False


def _name_of(value: Value) -> str:
    name = str(value.pure) if isinstance(value, FilePath) else text(value, "the name of a file")
    if len(name) > _LONGEST_PATH:
        raise RefusalError(f"a path of {len(name)} characters; the limit is {_LONGEST_PATH}")
    return name


class FilePath(Record):
    """The name of a file."""

    kind = "a path"

    def __init__(self, script: Script, *parts: Value) -> None:
        self.pure = PurePosixPath(*map(_name_of, parts))
        self._script = script

    def _other(self, *parts: Value) -> FilePath:
        return FilePath(self._script, *parts)

    fields: ClassVar[Methods] = {
        **{name: lambda self, name=name: getattr(self.pure, name) for name in ("name", "stem", "suffix")},
        "parent": lambda self: self._other(str(self.pure.parent)),
        "parents": lambda self: [self._other(str(parent)) for parent in self.pure.parents],
    }
    methods: ClassVar[Methods] = {
        **{
            name: lambda self, *parts, name=name: self._other(str(getattr(self.pure, name)(*map(_name_of, parts))))
            for name in ("joinpath", "with_suffix", "with_name")
        },
        **dict.fromkeys(("resolve", "absolute"), lambda self: self._other("/", self)),
        "expanduser": lambda self: self,
        "as_posix": lambda self: str(self.pure),
        **{
            name: lambda self, name=name: _no_file(f"Path.{name}", self._script)
            for name in ("exists", "is_file", "is_dir")
        },
    }

    def __truediv__(self, other: Value) -> Value:
        return self._other(self, other) if isinstance(other, str | FilePath) else NotImplemented

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FilePath) and self.pure == other.pure

    def text(self, as_repr: bool) -> str:
        return f"PosixPath({str(self.pure)!r})" if as_repr else str(self.pure)


class Parser(Record):
    """An `ArgumentParser`, or a group of its arguments."""

    kind = "an ArgumentParser"

    def __init__(self, script: Script) -> None:
        self._script = script
        self._defaults: dict[str, Value] = {}

    def _add(
        self,
        *flags: Value,
        default: Value = None,
        action: Value = "store",
        dest: Value = None,
        required: Value = False,
        nargs: Value = None,
        type: Value = None,  # Python's name for it
        **_: Value,
    ) -> None:
        names = [text(flag, "the name of an argument") for flag in flags]
        if not names:
            raise RefusalError("an argument without a name")
        is_option = names[0].startswith("-")
        if required or not (is_option or nargs in ("?", "*")):
            raise RefusalError(f"the argument {names[0]!r:.60} has no default; there is nobody to give it")
        if action not in _DEFAULTS:
            raise RefusalError(f"the action {describe(action)} of an argument is not supported")
        longest = next((name for name in names if name.startswith("--")), names[0])
        key = text(longest.lstrip("-").replace("-", "_") if dest is None else dest, "the name of an argument")
        if default is None:
            default = [] if nargs == "*" and not is_option else _DEFAULTS[action]
        elif isinstance(default, str) and type is not None:  # as in a command line
            default = call(type, [default], {}, self._script)
        self._defaults[key] = default

    def _parsed(self, args: Value = None) -> Namespace:
        if args:
            raise RefusalError("arguments that a script gives itself are not supported")
        return Namespace("the arguments", dict(self._defaults))

    methods: ClassVar[Methods] = {
        "add_argument": _add,
        "add_argument_group": lambda self, *_, **__: self,
        "set_defaults": lambda self, **named: self._defaults.update(named),
        "parse_args": _parsed,
        "parse_known_args": lambda self, args=None: (self._parsed(args), []),
    }
