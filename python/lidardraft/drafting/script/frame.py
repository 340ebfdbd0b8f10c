"""Names and what they stand for, and the functions that a script defines."""

from __future__ import annotations

import ast
from collections.abc import Callable

from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Record, Value

STEPS_OF_FUNCTION = 10  # that making one costs
_MOST_ARGUMENTS = 100  # of a function


class Frame:
    """The names of a module, a function or a comprehension; what is not in it is looked for in `outer`."""

    __slots__ = ("elsewhere", "outer", "variables")

    def __init__(self, outer: Frame | None, variables: dict[str, Value]) -> None:
        self.outer = outer
        self.variables = variables
        self.elsewhere: dict[str, Frame] = {}  # names declared `global` or `nonlocal`, with the frame that has them

    def set(self, name: str, value: Value) -> None:
        """Let a name stand for a value."""
        if name.startswith("__"):
            raise RefusalError(f"the name {name!r:.60} cannot be set")
        self.elsewhere.get(name, self).variables[name] = value

    def delete(self, name: str) -> None:
        """Forget a name."""
        if self.elsewhere.get(name, self).variables.pop(name, self) is self:
            raise RefusalError(f"the name {name!r:.60} is not known")

    def declare(self, name: str, nonlocal_: bool) -> None:
        """Let assignments to a name go to the module, or to the function around this one."""
        frame = self.outer
        while frame is not None and not (name in frame.variables if nonlocal_ else frame.is_module()):
            frame = frame.outer
        if frame is None or (nonlocal_ and frame.is_module()):
            raise RefusalError(f"no function around this one has the name {name!r:.60}")
        self.elsewhere[name] = frame

    def is_module(self) -> bool:
        """Whether it holds the names of the whole script: only the built-in ones are outside."""
        return self.outer is not None and self.outer.outer is None


class Function(Record):
    """A function or lambda of the script: its body as a function of ours, the frame that it is defined in, the values
    of its defaults (those of keyword-only arguments last), and what a call of it counts for."""

    kind = "a function of the script"

    def __init__(
        self,
        name: str,
        arguments: ast.arguments,
        body: Callable[[Frame], Value],
        frame: Frame,
        levels: int,
        weight: int,
        defaults: list[Value],
    ) -> None:
        count = len(arguments.posonlyargs) + len(arguments.args) + len(arguments.kwonlyargs)
        if count > _MOST_ARGUMENTS:
            raise RefusalError(f"a function of {count} arguments; {_MOST_ARGUMENTS} are the most")
        self.name = name
        self.body = body
        self.levels = levels
        self.weight = weight
        self.owner: Record | None = None  # the class that it is a method of
        self._frame = frame
        self._arguments = arguments
        self._names = [each.arg for each in (*arguments.posonlyargs, *arguments.args)]
        self._only = [each.arg for each in arguments.kwonlyargs]
        self._is_plain = not (self._only or arguments.vararg or arguments.kwarg)
        first = len(self._names) - len(arguments.defaults)
        self._defaults = dict(zip(self._names[first:], defaults, strict=False))
        pairs = zip(self._only, arguments.kw_defaults, defaults[len(arguments.defaults) :], strict=True)
        self._defaults |= {name: value for name, default, value in pairs if default is not None}

    def bind(self, arguments: list[Value], keywords: dict[str, Value]) -> Frame:
        """The frame in which the body runs. Raises `RefusalError` where the arguments are not those of the function."""
        names = self._names
        if self._is_plain and not keywords and len(arguments) == len(names):
            found = dict(zip(names, arguments, strict=True))
        else:
            found = self._bound(arguments, keywords)
        if self.owner is not None and names:  # what `super()` needs
            found |= {"__class__": self.owner, "__self__": found[names[0]]}
        return Frame(self._frame, found)

    def _bound(self, arguments: list[Value], keywords: dict[str, Value]) -> dict[str, Value]:
        given, names, only = self._arguments, self._names, self._only
        passed = dict(zip(names, arguments, strict=False))
        more: dict[str, Value] = {}
        for name, value in keywords.items():
            if name in passed:
                raise RefusalError(f"{self.name}() is given {name!r:.60} twice")
            (passed if name in names or name in only else more)[name] = value
        if given.vararg:
            passed[given.vararg.arg] = tuple(arguments[len(names) :])
        elif len(arguments) > len(names):
            raise RefusalError(f"{self.name}() takes {len(names)} arguments; it is given {len(arguments)}")
        if given.kwarg:
            passed[given.kwarg.arg] = more
        elif more:
            raise RefusalError(f"{self.name}() has no argument {next(iter(more))!r:.60}")
        found = self._defaults | passed
        missing = [name for name in (*names, *only) if name not in found]
        if missing:
            raise RefusalError(f"{self.name}() is not given {missing[0]!r:.60}")
        return found
