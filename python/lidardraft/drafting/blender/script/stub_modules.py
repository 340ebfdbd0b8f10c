"""What a script imports to talk to its surroundings: `os`, `sys`, `pathlib`, `time`, `datetime`, `argparse`, `logging`
and the like. No file is read, what is logged goes nowhere, the clock stands still, arguments have their defaults."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Callable
from datetime import datetime
from pathlib import PurePosixPath
from typing import ClassVar

from lidardraft.drafting.blender.script.definitions import BaseMarker
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Methods,
    Namespace,
    Record,
    Value,
    builtins,
    call,
    describe,
    nothing,
    text,
)

SCRIPT_FILE = "/script.py"  # the name that a script sees of its own file
_LONGEST_PATH = 4096  # characters
_DEFAULTS = {"store_true": False, "store_false": True, "store": None, "append": None, "count": None}
_FIRST = datetime(1970, 1, 1)  # the time that all clocks show
_FORMAT = re.compile("(?:[^%]|%[YymdHMSBbAajp%])*")
_LONGEST_FORMAT = 100  # characters
_MESSAGES = ("debug", "info", "warning", "warn", "error", "critical", "exception", "log")
_OF_LOGGERS = (*_MESSAGES, "setLevel", "addHandler", "removeHandler", "setFormatter", "flush", "close")


def stub_modules(script: Script) -> dict[str, Value]:
    """The modules by their names."""

    def at_first(value: Value) -> Callable[..., Value]:
        def call_(*_: Value, **__: Value) -> Value:
            script.note("the time is taken as 0")
            return value

        return call_

    def getenv(_key: Value, default: Value = None) -> Value:
        script.note("no variable of the environment is read")
        return default

    def logging_to(**named: Value) -> None:
        if named.get("filename") is not None:
            raise RefusalError("a log that is written to a file")

    def path_of(*parts: Value) -> FilePath:
        return FilePath(script, *parts)

    def strftime(form: Value, *_: Value) -> str:
        script.note("the time is taken as 0")
        return _written(form)

    environ = Namespace("os.environ", builtins("os.environ.", {"get": getenv}))
    path = Namespace("os.path", {"sep": "/", **builtins("os.path.", _os_path(script))})
    now = Namespace("datetime", builtins("datetime.", dict.fromkeys(("now", "today", "utcnow"), at_first(Moment()))))
    time = dict.fromkeys(("time", "perf_counter", "monotonic", "process_time"), at_first(0.0))
    time |= dict.fromkeys(("ctime", "asctime"), at_first(_FIRST.ctime()))
    logger = Namespace("a logger", {"propagate": True, **builtins("", dict.fromkeys(_OF_LOGGERS, nothing))})
    loggers = dict.fromkeys(("getLogger", "StreamHandler", "Formatter"), lambda *_, **__: logger)
    silence = dict.fromkeys((*_MESSAGES, "disable", "captureWarnings"), nothing)
    written = dict.fromkeys(("write", "writelines", "flush"), nothing)
    levels = {"DEBUG": 10, "INFO": 20, "WARNING": 30, "ERROR": 40, "CRITICAL": 50}
    file_path = Builtin("Path", path_of, own=dict.fromkeys(("cwd", "home"), lambda: path_of("/")))
    modules: dict[str, dict[str, Value]] = {
        "os": {"path": path, "environ": environ, "name": "posix", "sep": "/", "linesep": "\n"}
        | builtins("os.", {"getenv": getenv, "getcwd": lambda: "/"}),
        "sys": {"argv": ["blender"], "path": [], "platform": "linux", "maxsize": 2**63 - 1, "executable": "python"}
        | {"version": "3.11.0", "version_info": (3, 11, 0), "exit": Builtin("sys.exit", _leave)}
        | {name: Namespace(f"sys.{name}", builtins("", written)) for name in ("stdout", "stderr")},
        "pathlib": {"Path": file_path, "PurePath": file_path},
        "time": builtins("time.", {**time, "sleep": nothing, "strftime": strftime}),
        "datetime": {"datetime": now, "date": now},
        "argparse": {"ArgumentParser": Builtin("argparse.ArgumentParser", lambda *_, **__: Parser(script))},
        "logging": levels | builtins("logging.", {**silence, **loggers, "basicConfig": logging_to}),
        "warnings": builtins("warnings.", dict.fromkeys(("warn", "simplefilter", "filterwarnings"), nothing)),
        "traceback": builtins("traceback.", {"print_exc": nothing}),
        "gc": builtins("gc.", {"collect": nothing}),
    }
    known: dict[str, Value] = {name: Namespace(name, values) for name, values in modules.items()}
    return known | {"typing": Annotations(), "__future__": Annotations()}


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


class Moment(Record):
    """A time, of which there is one: the beginning of 1970."""

    kind = "a moment"
    fields: ClassVar[Methods] = {
        name: lambda _, name=name: getattr(_FIRST, name)
        for name in ("year", "month", "day", "hour", "minute", "second", "microsecond")
    }
    methods: ClassVar[Methods] = {
        "isoformat": lambda _, *__, **___: _FIRST.isoformat(),
        "strftime": lambda _, form: _written(form),
        "timestamp": lambda _: 0.0,
        "date": lambda self: self,
    }

    def __sub__(self, other: Value) -> Value:
        none = {"seconds": 0, "days": 0, "microseconds": 0, "total_seconds": Builtin("total_seconds", lambda: 0.0)}
        return Namespace("a duration", none) if isinstance(other, Moment) else NotImplemented

    def text(self, _as_repr: bool) -> str:
        return str(_FIRST)


def _written(form: Value) -> str:
    if len(text(form, "the format")) > _LONGEST_FORMAT or not _FORMAT.fullmatch(form):
        raise RefusalError(f"the format {form[:40]!r} of a time is not supported")
    return _FIRST.strftime(form)


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
