"""`os`, `sys` and `pathlib` as a script sees them: names of files, and none of the files themselves."""

from __future__ import annotations

import ast
import posixpath
from collections.abc import Callable
from pathlib import PurePosixPath

from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.silent_modules import output_stream
from lidardraft.drafting.script.values import Builtin, Namespace, Record, Value, describe, text

SCRIPT = "/script.py"  # the name that a script sees of its own file
_PURE = ("basename", "dirname", "splitext", "split", "normpath")
_ASKED = ("exists", "isfile", "isdir")
_MOST_PARENTS = 16
Note = Callable[[str], None]


def os_modules(budget: Budget, note: Note) -> dict[str, dict[str, Value]]:
    """The contents of the modules by their names."""

    def getenv(_key: Value, default: Value = None) -> Value:
        note("no variable of the environment is read")
        return default

    def leave(code: Value = None) -> None:
        raise RaisedError(
            "SystemExit",
            "the script ends itself here",
            "" if code is None else f"{code:.200}" if isinstance(code, str) else describe(code),
        )

    environ = Namespace("os.environ", {"get": Builtin("os.environ.get", getenv)})
    os = {"path": Namespace("os.path", _os_path(budget, note)), "environ": environ, "name": "posix", "sep": "/"}
    os |= {"linesep": "\n", "getenv": Builtin("os.getenv", getenv), "getcwd": Builtin("os.getcwd", lambda: "/")}
    sys = {"argv": ["blender"], "path": [], "platform": "linux", "version_info": (3, 11, 0), "maxsize": 2**63 - 1}
    sys |= {"exit": Builtin("sys.exit", leave), "executable": "python", "version": "3.11.0"}
    sys |= {name: output_stream(f"sys.{name}") for name in ("stdout", "stderr")}
    paths = FilePaths(budget, note)
    return {"os": os, "sys": sys, "pathlib": {"Path": paths, "PurePath": paths}}


def _os_path(budget: Budget, note: Note) -> dict[str, Value]:
    def pure(name: str) -> Callable[[Value], Value]:
        def call(path: Value) -> Value:
            budget.take_text(2 * len(_name_of(path)))
            return getattr(posixpath, name)(_name_of(path))

        return call

    def join(*parts: Value) -> str:
        names = [_name_of(part) for part in parts]
        budget.take_text(sum(map(len, names)) + len(names))
        return posixpath.join(*names)

    def abspath(path: Value) -> str:
        return posixpath.normpath(join("/", path))

    def asked(name: str) -> Callable[[Value], Value]:
        return lambda _: _no_file(f"os.path.{name}", note)

    table: dict[str, Callable[..., Value]] = {name: pure(name) for name in _PURE}
    table |= {name: asked(name) for name in _ASKED}
    table |= {"join": join, "abspath": abspath, "realpath": abspath, "expanduser": lambda path: _name_of(path)}
    return {"sep": "/", **{name: Builtin(f"os.path.{name}", function) for name, function in table.items()}}


def _no_file(asked: str, note: Note) -> bool:
    note(f"no file is looked at: {asked} says False")
    return False


def _name_of(value: Value) -> str:
    return str(value.pure) if isinstance(value, FilePath) else text(value, "the name of a file")


class FilePaths(Record):
    """`pathlib.Path`."""

    kind = "pathlib.Path"

    def __init__(self, budget: Budget, note: Note) -> None:
        self._budget = budget
        self._note = note

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        if keywords:
            raise RefusalError("Path takes no named arguments")
        return self.made(PurePosixPath(*self.names(arguments)))

    def names(self, parts: list[Value]) -> list[str]:
        """The parts of a path as texts."""
        names = [_name_of(part) for part in parts]
        self._budget.take_steps(sum(map(len, names)) // 8 + 8)  # a path is split at its slashes
        return names

    def made(self, pure: PurePosixPath) -> FilePath:
        """The path of that name."""
        self._budget.take_text(8 * len(str(pure)))
        return FilePath(pure, self, self._note)

    def attribute(self, name: str) -> Value:
        if name not in ("cwd", "home"):
            return super().attribute(name)
        return Builtin(f"Path.{name}", lambda: self.made(PurePosixPath("/")))


class FilePath(Record):
    """The name of a file."""

    kind = "a path"
    weight = 4

    def __init__(self, pure: PurePosixPath, paths: FilePaths, note: Note) -> None:
        self.pure = pure
        self._paths = paths
        self._note = note

    def attribute(self, name: str) -> Value:
        pure, made = self.pure, self._paths.made
        if name in ("name", "stem", "suffix"):
            return getattr(pure, name)
        if name == "parent":
            return made(pure.parent)
        if name == "parents":
            return [made(parent) for parent, _ in zip(pure.parents, range(_MOST_PARENTS), strict=False)]
        methods: dict[str, Callable[..., Value]] = {
            "joinpath": lambda *parts: made(pure.joinpath(*self._paths.names(list(parts)))),
            "with_suffix": lambda suffix: made(pure.with_suffix(text(suffix, "the suffix"))),
            "with_name": lambda other: made(pure.with_name(text(other, "the name"))),
            "resolve": lambda: made(PurePosixPath("/") / pure),
            "absolute": lambda: made(PurePosixPath("/") / pure),
            "expanduser": lambda: self,
            "as_posix": lambda: str(pure),
        }
        if name in ("exists", "is_file", "is_dir"):
            return Builtin(f"Path.{name}", lambda: _no_file(f"Path.{name}", self._note))
        return Builtin(f"Path.{name}", methods[name]) if name in methods else super().attribute(name)

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        if operator is not ast.Div or reflected or not isinstance(other, str | FilePath):
            return super().binary(operator, other, reflected=reflected)
        return self._paths.made(self.pure.joinpath(*self._paths.names([other])))

    def equals(self, other: Value) -> bool:
        if not isinstance(other, FilePath):
            return False
        name, other_name = self._paths.names([self, other])
        return name == other_name

    def text(self, as_repr: bool) -> str:
        return f"PosixPath({str(self.pure)!r})" if as_repr else str(self.pure)
