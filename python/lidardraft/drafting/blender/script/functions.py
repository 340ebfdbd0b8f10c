"""Names and what they stand for, and the functions that a script defines."""

from __future__ import annotations

import ast
from collections.abc import Callable

from lidardraft.drafting.blender.script.limits import RefusalError, Script
from lidardraft.drafting.blender.script.values import Record, Value

_STEPS = 10  # that making a function costs
_MOST_ARGUMENTS = 100
SPECIAL = ("__init__", "__post_init__", "__repr__", "__str__")  # methods that a class may have


class Frame:
    """The names of a module, a class, a function or a comprehension; what is not in it is looked for in `outer`."""

    __slots__ = ("elsewhere", "home", "outer", "script", "variables")

    def __init__(self, outer: Frame | None, variables: dict[str, Value], script: Script) -> None:
        self.outer = outer
        self.variables = variables
        self.script = script
        self.home = self  # where := sets a name; of a comprehension, that around it
        self.elsewhere: dict[str, Frame] = {}  # names declared `global` or `nonlocal`, with the frame that has them

    def within(self) -> Frame:
        """The frame of a comprehension in it."""
        frame = Frame(self, {}, self.script)
        frame.home = self.home
        return frame

    def get(self, name: str) -> Value:
        """What a name stands for."""
        scope: Frame | None = self
        while scope is not None:
            if name in scope.variables:
                return scope.variables[name]
            scope = scope.outer
        raise RefusalError(f"the name {name!r:.60} is not known")

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
        if self.is_module() and not nonlocal_:
            return
        frame = self.outer
        while frame is not None and not (name in frame.variables if nonlocal_ else frame.is_module()):
            frame = frame.outer
        if frame is None or (nonlocal_ and frame.is_module()):
            raise RefusalError(f"no function around this one has the name {name!r:.60}")
        self.elsewhere[name] = frame

    def is_module(self) -> bool:
        """Whether it holds the names of the whole script: only the built-in ones are outside."""
        return self.outer is not None and self.outer.outer is None


class ClassFrame(Frame):
    """The names of a class, as its body sets them; `annotated` are those with a type, in order."""

    __slots__ = ("annotated",)

    def __init__(self, outer: Frame | None, script: Script) -> None:
        super().__init__(outer, {}, script)
        self.annotated: list[str] = []

    def set(self, name: str, value: Value) -> None:
        if name in SPECIAL:
            self.variables[name] = value
        else:
            super().set(name, value)


class Function(Record):
    """A function or lambda of the script: its arguments with the values of their defaults (those of keyword-only ones
    last, None where there is none), the frame that it is defined in, and what carries its body out."""

    kind = "a function of the script"
    weight = 1

    def __init__(
        self, name: str, given: ast.arguments, defaults: list[Value], frame: Frame, run: Callable[[Frame], Value]
    ) -> None:
        frame.script.take_steps(_STEPS)
        self.name = name
        self.owner: Record | None = None  # the class that it is a method of
        # A method does not see the names beside it.
        self._frame = frame.outer or frame if isinstance(frame, ClassFrame) else frame
        self._given = given
        self._run = run
        self._names = [each.arg for each in (*given.posonlyargs, *given.args)]
        self._only = [each.arg for each in given.kwonlyargs]
        if len(self._names) + len(self._only) > _MOST_ARGUMENTS:
            raise RefusalError(f"a function of more than {_MOST_ARGUMENTS} arguments")
        count = len(given.defaults)
        self._defaults = dict(zip(self._names[len(self._names) - count :], defaults[:count], strict=True))
        pairs = zip(self._only, given.kw_defaults, defaults[count:], strict=True)
        self._defaults |= {name: value for name, default, value in pairs if default is not None}

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        script, line = self._frame.script, self._frame.script.line
        result = self._run(Frame(self._frame, self._bound(arguments, keywords), script))
        script.line = line
        return result

    def _bound(self, arguments: list[Value], keywords: dict[str, Value]) -> dict[str, Value]:
        given, names, only = self._given, self._names, self._only
        found = dict(zip(names, arguments, strict=False))
        more: dict[str, Value] = {}
        for name, value in keywords.items():
            if name in found:
                raise RefusalError(f"{self.name}() is given {name!r:.60} twice")
            (found if name in names or name in only else more)[name] = value
        if given.vararg:
            found[given.vararg.arg] = tuple(arguments[len(names) :])
        elif len(arguments) > len(names):
            raise RefusalError(f"{self.name}() takes {len(names)} arguments; it is given {len(arguments)}")
        if given.kwarg:
            found[given.kwarg.arg] = more
        elif more:
            raise RefusalError(f"{self.name}() has no argument {next(iter(more))!r:.60}")
        found = self._defaults | found
        for name in (*names, *only):
            if name not in found:
                raise RefusalError(f"{self.name}() is not given {name!r:.60}")
        if self.owner is not None and names:  # what `super()` needs
            found |= {"__class__": self.owner, "__self__": found[names[0]]}
        return found
