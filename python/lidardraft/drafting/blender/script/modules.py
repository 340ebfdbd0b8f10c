"""The modules that a script may import: those of Python's own library that compute, and stubs of those that talk to its
surroundings. No file is read, what is logged goes nowhere, the clock stands still, arguments have their defaults."""

from __future__ import annotations

import ast
import copy
import itertools
import json
import math
import posixpath
import random
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from datetime import datetime
from functools import partial, reduce
from pathlib import PurePosixPath
from typing import ClassVar

from lidardraft.drafting.blender.script.builtin_functions import has
from lidardraft.drafting.blender.script.containers import Deque, Lazy, count_into, iterate, to_dict
from lidardraft.drafting.blender.script.definitions import (
    AutoValue,
    BaseMarker,
    ClassFrame,
    Decorator,
    FieldDefault,
    Instance,
    ScriptClass,
    dataclass,
)
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.operators import binary, to_text
from lidardraft.drafting.blender.script.statements import Surroundings
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
    is_key,
    lone_surrogate,
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
_WIDEST, _DEEPEST_COPY = 16, 30
_LONGEST_NUMBER = 40  # of JSON
_SIGN, _HALF_CHARACTER = re.compile(r"[,:\[{]"), re.compile(r"\\u[dD][89a-fA-F]")
SCRIPT_FILE = "/script.py"  # the name that a script sees of its own file
_LONGEST_PATH = 4096  # characters
_DEFAULTS = {"store_true": False, "store_false": True, "store": None, "append": None, "count": None}
_FIRST = datetime(1970, 1, 1)  # the time that all clocks show
_FORMAT, _LONGEST_FORMAT = re.compile("(?:[^%]|%[YymdHMSBbAajp%])*"), 100  # characters
_MESSAGES = ("debug", "info", "warning", "warn", "error", "critical", "exception", "log")
_OF_LOGGERS = (*_MESSAGES, "setLevel", "addHandler", "removeHandler", "setFormatter", "flush", "close")


def modules(script: Script) -> dict[str, Value]:
    """The modules by their names."""
    enum = {name: BaseMarker(name) for name in ("Enum", "IntEnum", "StrEnum")}
    tables: dict[str, dict[str, Value]] = {
        "math": _math(script),
        "itertools": {**builtins("", _itertools(script)), "chain": _chain(script)},
        "functools": _functools(script),
        "collections": builtins("", _collections(script)),
        "dataclasses": {"dataclass": Decorator(dataclass), "field": Builtin("field", FieldDefault)},
        "enum": {**enum, "auto": Builtin("auto", AutoValue)},
        "abc": {"ABC": BaseMarker("object"), "abstractmethod": Decorator(lambda function: function)},
        "contextlib": {"suppress": Builtin("suppress", _suppress)},
        "copy": builtins("copy.", _copy(script)),
        "json": builtins("json.", _json(script)),
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
    first = {"year": 1970, "month": 1, "day": 1, "hour": 0, "minute": 0, "second": 0, "microsecond": 0}
    written: Methods = {"strftime": _written, "isoformat": _FIRST.isoformat, "timestamp": lambda: 0.0}
    moment = Namespace("a moment", first | builtins("", written))
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
        "time": builtins("time.", dict.fromkeys(clocks, at_first(0.0)) | {"sleep": nothing, "strftime": _written}),
        "datetime": {"datetime": now, "date": now},
        "argparse": {"ArgumentParser": Builtin("argparse.ArgumentParser", lambda *_, **__: Parser(script))},
        "logging": levels
        | silent(*_MESSAGES, "disable", "captureWarnings")
        | builtins("logging.", {**loggers, "basicConfig": logging_to}),
        "warnings": silent("warn", "simplefilter", "filterwarnings"),
        "traceback": silent("print_exc"),
        "gc": silent("collect"),
    }


def _written(form: Value, *_: Value) -> str:
    if len(text(form, "the format")) > _LONGEST_FORMAT or not _FORMAT.fullmatch(form):
        raise RefusalError(f"the format {form[:40]!r} of a time is not supported")
    return _FIRST.strftime(form)


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
    """`random`, or a `random.Random`: the numbers that Python's generator gives for a seed, which is 0 until it is set;
    a number that is drawn before that is noted."""

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
    def lazily(make: Callable[..., Iterator[Value]]) -> Callable[..., Lazy]:
        return lambda items, *more, **named: Lazy(make(iterate(items, script), *more, **named), script)

    def product(*columns: Value, repeat: Value = 1) -> Value:
        lists = [elements(column, script) for column in columns] * whole(repeat, "repeat", 0, _WIDEST)
        return Lazy(itertools.product(*lists), script)

    def chosen(choose: Callable[..., Iterator[Value]]) -> Callable[..., Value]:
        def some(items: Value, r: Value = None) -> Value:
            found = elements(items, script)
            width = whole(len(found) if r is None else r, "the number of elements at a time", 0, _WIDEST)
            return Lazy(choose(found, width), script)

        return some

    def accumulate(items: Iterator[Value], function: Value = None, *, initial: Value = None) -> Iterator[Value]:
        add = partial(binary, ast.Add, script=script) if function is None else partial(_called, function, script)
        return itertools.accumulate(items, add, initial=initial)

    def islice(items: Iterator[Value], *bounds: Value) -> Iterator[Value]:
        limits = [None if bound is None else whole(bound, "a bound of islice", 0) for bound in bounds]
        return itertools.islice(items, *limits)

    return {
        "product": product,
        "combinations": chosen(itertools.combinations),
        "permutations": chosen(itertools.permutations),
        "count": lambda start=0, step=1: Lazy(itertools.count(checked(start) + 0, checked(step) + 0), script),
        "repeat": lambda value, *times: Lazy(itertools.repeat(value, *times), script),
        "cycle": lazily(itertools.cycle),
        "islice": lazily(islice),
        "accumulate": lazily(accumulate),
        "pairwise": lazily(itertools.pairwise),
    }


def _functools(script: Script) -> dict[str, Value]:
    def reduced(function: Value, items: Value, *start: Value) -> Value:
        return reduce(partial(_called, function, script), elements(items, script), *start)

    def bound(function: Value, /, *first: Value, **named: Value) -> Builtin:
        return Builtin("partial", partial(_called, function, script, *first, **named))

    def cached(function: Value) -> Builtin:
        results: dict[Value, Value] = {}

        def result(*arguments: Value, **keywords: Value) -> Value:
            key = (*arguments, *keywords.items())
            if not all(is_key(each) for each in (*arguments, *keywords.values())):
                raise RefusalError("a cached function of what cannot be a key")
            if key not in results:
                results[key] = call(function, list(arguments), keywords, script)
            return results[key]

        return Builtin("a cached function", result)

    cache = Decorator(cached)
    return builtins("", {"partial": bound, "reduce": reduced}) | {"cache": cache, "lru_cache": cache}


def _called(function: Value, script: Script, /, *arguments: Value, **keywords: Value) -> Value:
    return call(function, list(arguments), keywords, script)


def _collections(script: Script) -> Methods:
    def default_dict(default_factory: Value = None, pairs: Value = (), **keywords: Value) -> dict[Value, Value]:
        factory = None if default_factory is None else partial(_called, default_factory, script)
        return defaultdict(factory, to_dict(pairs, keywords, script))

    def counter(items: Value = ()) -> Counter[Value]:
        found: Counter[Value] = Counter()
        count_into(found, items, script)
        return found

    def namedtuple(typename: Value, field_names: Value, **_: Value) -> ScriptClass:
        given = field_names.replace(",", " ").split() if isinstance(field_names, str) else elements(field_names, script)
        names = [text(name, "the name of a field") for name in given]
        if not all(name.isidentifier() and not name.startswith("_") for name in names):
            raise RefusalError(f"namedtuple of {describe(field_names)} is not supported")
        body = ClassFrame(None, script)
        body.annotated = names
        return ScriptClass(text(typename, "the name"), BaseMarker("NamedTuple"), body)

    return {
        "defaultdict": default_dict,
        "Counter": counter,
        "deque": lambda items=(): Deque(elements(items, script)),
        "namedtuple": namedtuple,
        "OrderedDict": lambda pairs=(), **keywords: to_dict(pairs, keywords, script),
    }


def _suppress(*errors: Value) -> Surroundings:
    names = [each.error for each in errors if isinstance(each, BaseMarker) and each.error is not None]
    if len(names) != len(errors):
        raise RefusalError("suppress of what is no class of errors of Python's own")
    return Surroundings(names)


def _copy(script: Script) -> Methods:
    def shallow(x: Value) -> Value:
        if isinstance(x, list | dict):
            script.take_made(x)
            return copy.copy(x)
        if isinstance(x, Instance) and not x.of.is_enumeration:
            script.take_made(x.values)
            other = Instance(x.of)
            other.values = dict(x.values)
            return other
        if not isinstance(x, Record) or not has(x, "copy"):
            return x  # a number, a text, a tuple, a function or a class, which nothing changes
        return x.attribute("copy")()

    def deep(x: Value, known: dict[int, Value], level: int) -> Value:
        script.take_step()
        if level > _DEEPEST_COPY:
            raise RefusalError(f"deepcopy of {describe(x)}, more than {_DEEPEST_COPY} levels deep")
        if not isinstance(x, list | tuple | dict | Record):
            return x
        if isinstance(x, tuple):
            return tuple(deep(item, known, level + 1) for item in x)
        if id(x) not in known:
            known[id(x)] = other = shallow(x)
            values = other.values if isinstance(other, Instance) else other
            if other is not x and isinstance(values, list):
                values[:] = [deep(item, known, level + 1) for item in values]
            elif other is not x and isinstance(values, dict):
                values.update({key: deep(item, known, level + 1) for key, item in values.items()})
        return known[id(x)]

    return {"copy": shallow, "deepcopy": lambda x: deep(x, {}, 0)}


def _json(script: Script) -> Methods:
    def loads(s: Value) -> Value:
        written = text(s, "what json.loads is given")
        script.take_text(len(written))
        script.take_cells(3 * len(_SIGN.findall(written)))
        try:
            found = json.loads(written, parse_int=lambda digits: int(checked(int(digits[:_LONGEST_NUMBER]))))
        except json.JSONDecodeError as error:
            raise RaisedError("JSONDecodeError", f"json.loads: {error}") from None
        if _HALF_CHARACTER.search(written) and lone_surrogate(json.dumps(found, ensure_ascii=False)) is not None:
            raise RefusalError("the text holds half a character")
        return found

    def dumps(obj: Value, *, indent: Value = None, sort_keys: Value = False, ensure_ascii: Value = True) -> str:
        width = None if indent is None else whole(indent, "the indent", 0, 8)
        to_text(obj, script)  # counts what is written, and refuses what is too deep
        written = json.dumps(obj, indent=width, sort_keys=bool(sort_keys), ensure_ascii=bool(ensure_ascii))
        script.take_text(len(written))
        return written

    return {"loads": loads, "dumps": dumps}


class Annotations(Record):
    """`typing` and `__future__`, and all that is in them: what is said of types is passed over."""

    kind = "an annotation"

    def attribute(self, name: str) -> Value:
        return BaseMarker(name) if name == "NamedTuple" else self

    def __getitem__(self, _key: Value) -> Value:
        return self


def _leave(code: Value = None) -> None:
    said = "" if code is None else f"{code:.200}" if isinstance(code, str) else describe(code)
    raise RaisedError("SystemExit", "the script ends itself here", said)


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
        raise RefusalError(f"a path of {len(name)} characters; {_LONGEST_PATH} are the most")
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
        "joinpath": lambda self, *parts: self._other(self, *parts),
        "with_suffix": lambda self, suffix: self._other(str(self.pure.with_suffix(text(suffix, "the suffix")))),
        "with_name": lambda self, name: self._other(str(self.pure.with_name(text(name, "the name")))),
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
        type: Value = None,  # the name that Python has for it
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
        elif isinstance(default, str) and type is not None:  # as it would stand in the command
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
