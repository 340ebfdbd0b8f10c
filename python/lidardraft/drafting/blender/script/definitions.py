"""Names and their values, and the functions and classes that a script defines."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Sequence

from lidardraft.drafting.blender.script.limits import RefusalError, Script
from lidardraft.drafting.blender.script.operators import equal
from lidardraft.drafting.blender.script.values import Builtin, Record, Type, Value, call, describe, nothing, place, text

SPECIAL = ("__init__", "__post_init__", "__repr__", "__str__")  # methods that a class may have
_MISSING = object()
_ERRORS = (
    *("BaseException", "Exception", "ArithmeticError", "AssertionError", "AttributeError", "ImportError", "IndexError"),
    *("KeyError", "LookupError", "NameError", "NotImplementedError", "OSError", "OverflowError", "RuntimeError"),
    *("StopIteration", "SystemExit", "TypeError", "ValueError", "ZeroDivisionError"),
)


class Frame:
    """The names of a module, a class, a function or a comprehension; missing names are looked up in `outer`."""

    __slots__ = ("elsewhere", "home", "outer", "script", "variables")

    def __init__(self, outer: Frame | None, variables: dict[str, Value], script: Script) -> None:
        self.outer = outer
        self.variables = variables
        self.script = script
        self.home = self  # the frame in which := sets a name; for a comprehension, that around it
        self.elsewhere: dict[str, Frame] = {}  # names declared `global` or `nonlocal`, with their frames

    def within(self) -> Frame:
        """The frame of a comprehension inside it."""
        frame = Frame(self, {}, self.script)
        frame.home = self.home
        return frame

    def get(self, name: str) -> Value:
        """The value of a name."""
        scope: Frame | None = self
        while scope is not None:
            if name in scope.variables:
                return scope.variables[name]
            scope = scope.outer
        raise RefusalError(f"the name {name!r:.60} is not known")

    def set(self, name: str, value: Value) -> None:
        """Set the value of a name."""
        if name.startswith("__"):
            raise RefusalError(f"the name {name!r:.60} cannot be set")
        self.elsewhere.get(name, self).variables[name] = value

    def delete(self, name: str) -> None:
        """Delete a name."""
        if self.elsewhere.get(name, self).variables.pop(name, self) is self:
            raise RefusalError(f"the name {name!r:.60} is not known")

    def declare(self, name: str, nonlocal_: bool) -> None:
        """Direct assignments to a name to the module, or to the function around this one."""
        if self.is_module() and not nonlocal_:
            return
        frame = self.outer
        while frame is not None and not (name in frame.variables if nonlocal_ else frame.is_module()):
            frame = frame.outer
        if frame is None or (nonlocal_ and frame.is_module()):
            raise RefusalError(f"no function around this one has the name {name!r:.60}")
        self.elsewhere[name] = frame

    def is_module(self) -> bool:
        """Whether it is the frame of the whole script, with only the built-in names outside."""
        return self.outer is not None and self.outer.outer is None


class ClassFrame(Frame):
    """The names that a class body sets; `annotated` are those with a type, in order."""

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
    """A function or lambda of the script: its arguments, the values of their defaults (those of keyword-only ones last,
    None without one), the frame of its definition, and `run`, which executes its body."""

    kind = "a function of the script"

    def __init__(
        self, name: str, given: ast.arguments, defaults: list[Value], frame: Frame, run: Callable[[Frame], Value]
    ) -> None:
        self.name = name
        self.owner: Record | None = None  # the class of a method
        # A method does not see the names beside it.
        self._frame = frame.outer or frame if isinstance(frame, ClassFrame) else frame
        self._given = given
        self._run = run
        self._names = [each.arg for each in (*given.posonlyargs, *given.args)]
        self._only = [each.arg for each in given.kwonlyargs]
        count = len(given.defaults)
        self._defaults = dict(zip(self._names[len(self._names) - count :], defaults[:count], strict=True))
        pairs = zip(self._only, given.kw_defaults, defaults[count:], strict=True)
        self._defaults |= {name: value for name, default, value in pairs if default is not None}

    def __call__(self, /, *arguments: Value, **keywords: Value) -> Value:
        script, line = self._frame.script, self._frame.script.line
        result = self._run(Frame(self._frame, self._bound(arguments, keywords), script))
        script.line = line
        return result

    def _bound(self, arguments: tuple[Value, ...], keywords: dict[str, Value]) -> dict[str, Value]:
        given, names, only = self._given, self._names, self._only
        found = dict(zip(names, arguments, strict=False))
        more: dict[str, Value] = {}
        for name, value in keywords.items():
            if name in found:
                raise RefusalError(f"{self.name}() is given {name!r:.60} twice")
            (found if name in names or name in only else more)[name] = value
        if given.vararg:
            found[given.vararg.arg] = arguments[len(names) :]
        elif len(arguments) > len(names):
            raise RefusalError(f"{self.name}() takes {len(names)} arguments; it is given {len(arguments)}")
        if given.kwarg:
            found[given.kwarg.arg] = more
        elif more:
            raise RefusalError(f"{self.name}() has no argument {next(iter(more))!r:.60}")
        found = self._defaults | found
        self._frame.script.take_made(found)
        for name in (*names, *only):
            if name not in found:
                raise RefusalError(f"{self.name}() is not given {name!r:.60}")
        if self.owner is not None and names:  # for `super()`
            found |= {"__class__": self.owner, "__self__": found[names[0]]}
        return found


class Decorator(Record):
    """A decorator."""

    kind = "a decorator"

    def __init__(self, around: Callable[[Value], Value]) -> None:
        self.around = around

    def __call__(self, /, *arguments: Value, **keywords: Value) -> Value:
        """Itself, as in `@dataclass(frozen=True)`; the arguments change no shape."""
        return self if keywords or not arguments else self.around(arguments[0])


class Method(Record):
    """A property, class method or static method of a class."""

    kind = "a method"

    def __init__(self, function: Value, bound_to: str, setter: Value = None) -> None:
        self.function = function
        self.bound_to = bound_to  # "property", "class" or "nothing"
        self.setter = setter

    def attribute(self, name: str) -> Value:
        if name != "setter" or self.bound_to != "property":
            return super().attribute(name)
        return Decorator(lambda setter: Method(self.function, "property", setter))


class FieldDefault(Record):
    """`field(...)` of a dataclass."""

    kind = "a field of a dataclass"

    def __init__(self, default: Value = None, default_factory: Value = None, **_: Value) -> None:
        self.default = default
        self.factory = default_factory


class AutoValue(Record):
    """`auto()`: the number of a member of an enumeration."""

    kind = "auto()"


class BaseMarker(Record):
    """A built-in class to derive from: "object", "Enum" or "NamedTuple"; `error` is the name of a class of errors."""

    is_key = True

    def __init__(self, name: str, error: str | None = None) -> None:
        self.kind = f"the class {error or name}"
        self.name = name
        self.error = error


class ScriptClass(Type):
    """A class: its members by name, and the fields of its instances, if declared."""

    def __init__(self, name: str, base: Value, body: ClassFrame) -> None:
        super().__init__(f"the class {name:.40}", self._holds)
        self.name = name
        self.base = base if isinstance(base, ScriptClass) else None
        self.marker: str = self.base.marker if self.base else base.name if isinstance(base, BaseMarker) else "object"
        self.is_enumeration = self.marker == "Enum"
        self.members, self.annotated, self.script = body.variables, body.annotated, body.script
        self.made_from: list[str] | None = self.base.made_from if self.base else None
        self.is_dataclass: bool = self.base is not None and self.base.is_dataclass
        for member in self.members.values():
            function = member.function if isinstance(member, Method) else member
            if isinstance(function, Function) and function.owner is None:
                function.owner = self
        if self.is_enumeration:
            self._enumerate()
        elif self.marker == "NamedTuple":
            self.take_fields()

    def take_fields(self) -> None:
        """Make the annotated names the fields of instances, after those of the base class."""
        self.made_from = list(dict.fromkeys([*(self.made_from or ()), *self.annotated]))

    def _enumerate(self) -> None:
        last: Value = 0
        for name, value in self.members.items():
            if not isinstance(value, Function | Method):
                member = Instance(self)
                if isinstance(value, AutoValue) and not isinstance(last, int):
                    raise RefusalError(f"auto() behind {describe(last)} is not supported")
                last = last + 1 if isinstance(value, AutoValue) else value
                member.values |= {"name": name, "value": last}
                self.members[name] = member

    def find(self, name: str) -> Value:
        """The member of that name in the class or its base classes, or `_MISSING`."""
        scope: ScriptClass | None = self
        while scope is not None:
            if name in scope.members:
                return scope.members[name]
            scope = scope.base
        return _MISSING

    def _holds(self, value: Value) -> bool:
        scope: ScriptClass | None = value.of if isinstance(value, Instance) else None
        while scope is not None and scope is not self:
            scope = scope.base
        return scope is self

    def has_private(self, name: str) -> bool:
        return name in (*SPECIAL, "__name__") or not name.startswith("__")

    def bound(self, found: Value, instance: Instance | None) -> Value:
        """A member as an attribute of an instance, or of the class itself."""
        if isinstance(found, Method):
            if found.bound_to == "property" and instance is not None:
                return self.run(found.function, instance)
            return BoundMethod(found.function, self) if found.bound_to == "class" else found.function
        return BoundMethod(found, instance) if isinstance(found, Function) and instance else found

    def run(self, function: Value, *arguments: Value) -> Value:
        """The result of one of its functions."""
        return call(function, list(arguments), {}, self.script)

    def attribute(self, name: str) -> Value:
        if name == "__name__":
            return self.name
        found = self.find(name)
        return super().attribute(name) if found is _MISSING else self.bound(found, None)

    def set_attribute(self, name: str, value: Value) -> None:
        self.members[name] = value

    def __iter__(self) -> Iterator[Value]:
        if not self.is_enumeration:
            return super().__iter__()
        return iter([member for member in self.members.values() if isinstance(member, Instance)])

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __getitem__(self, key: Value) -> Value:
        if not self.is_enumeration or not isinstance(key, str) or key not in self.members:
            return super().__getitem__(key)
        return self.members[key]

    def __call__(self, /, *arguments: Value, **keywords: Value) -> Value:
        if self.is_enumeration:
            for member in self if len(arguments) == 1 else ():
                if equal(member.values["value"], arguments[0], self.script):
                    return member
            raise RefusalError(f"{self.kind} has no such member")
        instance = Instance(self)
        start = self.find("__init__")
        if start is not _MISSING:
            call(start, [instance, *arguments], keywords, self.script)
        elif self.made_from is not None:
            self._fill(instance, arguments, keywords)
        elif arguments or keywords:
            raise RefusalError(f"{self.kind} takes no arguments")
        return instance

    def _fill(self, instance: Instance, arguments: Sequence[Value], keywords: dict[str, Value]) -> None:
        fields = self.made_from or []
        if len(arguments) > len(fields) or not set(keywords) <= set(fields[len(arguments) :]):
            raise RefusalError(f"{self.kind} is given other arguments than {', '.join(fields):.100}")
        given = dict(zip(fields, arguments, strict=False)) | keywords
        for name in fields:
            default = self.find(name)
            if name not in given and default is _MISSING:
                raise RefusalError(f"{self.kind} is not given {name!r:.60}")
            if name not in given and isinstance(default, FieldDefault):
                default = default.default if default.factory is None else self.run(default.factory)
            instance.values[name] = given.get(name, default)
        self.script.take_made(instance.values)
        if (after := self.find("__post_init__")) is not _MISSING:
            self.run(after, instance)


class Instance(Record):
    """An instance of a class of the script; as in Python, a dict key by its values if these are plain."""

    is_key = True

    def __init__(self, of: ScriptClass) -> None:
        self.of = of
        self.kind = f"an instance of {of.kind}"
        self.values: dict[str, Value] = {}
        self._key: Value = None  # its value as a key, made on demand

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, Instance | tuple) and self._as_key() == _as_key(other))

    def __hash__(self) -> int:
        return hash(self._as_key())

    def _as_key(self) -> Value:
        if self._key is None:
            found = self.compared_as()
            plain = isinstance(found, tuple) and not any(isinstance(e, list | tuple | dict | Instance) for e in found)
            self._key = found if plain else id(self)
        return self._key

    def compared_as(self) -> Value:
        if self.of.marker == "NamedTuple":
            return tuple(self.values.values())
        return (self.of, *self.values.values()) if self.of.is_dataclass else self

    def text(self, as_repr: bool) -> str:
        for name in ("__repr__",) if as_repr else ("__str__", "__repr__"):
            if (found := self.of.find(name)) is not _MISSING:
                return text(self.of.run(found, self), f"what {name} gives")
        if self.of.is_enumeration and not as_repr:
            return f"{self.of.name}.{self.values['name']}"
        return super().text(as_repr)

    def has_private(self, name: str) -> bool:
        return name == "__class__" or not (name.startswith("__") and name.endswith("__"))

    def has(self, name: str) -> bool:
        """Whether the instance or its class has an attribute of that name."""
        return name in self.values or name == "__class__" or self.of.find(name) is not _MISSING

    def attribute(self, name: str) -> Value:
        if name in self.values:
            return self.values[name]
        if name == "__class__":
            return self.of
        found = self.of.find(name)
        return super().attribute(name) if found is _MISSING else self.of.bound(found, self)

    def set_attribute(self, name: str, value: Value) -> None:
        found = self.of.find(name)
        if isinstance(found, Method) and found.setter is not None:
            self.of.run(found.setter, self, value)
        elif isinstance(found, Method) or name == "__class__" or self.of.marker != "object":
            super().set_attribute(name, value)
        else:
            self.values[name] = value
            self._key = None

    def __iter__(self) -> Iterator[Value]:
        return iter(self.values.values()) if self.of.marker == "NamedTuple" else super().__iter__()

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __getitem__(self, key: Value) -> Value:
        return super().__getitem__(key) if self.of.marker != "NamedTuple" else [*self][place(key, len(self), self.kind)]


def _as_key(value: Value) -> Value:
    return value._as_key() if isinstance(value, Instance) else value


class BoundMethod(Record):
    """A function with the value of its first argument."""

    kind = "a method"

    def __init__(self, function: Function, first: Value) -> None:
        self._function = function
        self._first = first

    def __call__(self, /, *arguments: Value, **keywords: Value) -> Value:
        return self._function(self._first, *arguments, **keywords)


class Super(Record):
    """`super()` in a method of the class `of`: the members of its base classes."""

    kind = "super()"

    def __init__(self, of: Value, instance: Value) -> None:
        self._of = of
        self._instance = instance

    def has_private(self, name: str) -> bool:
        return name in SPECIAL or not name.startswith("__")

    def attribute(self, name: str) -> Value:
        base = self._of.base
        found = _MISSING if base is None else base.find(name)
        if found is _MISSING:
            return Builtin("super", nothing) if name in SPECIAL else super().attribute(name)
        return base.bound(found, self._instance if isinstance(self._instance, Instance) else None)


def dataclass(of: Value) -> Value:
    """The class with its annotated names as fields of its instances."""
    if not isinstance(of, ScriptClass):
        raise RefusalError(f"{describe(of)} is no class")
    of.take_fields()
    of.is_dataclass = True
    return of


CLASS_NAMES: dict[str, Value] = {  # Python's built-in ones
    "property": Decorator(lambda function: Method(function, "property")),
    "staticmethod": Decorator(lambda function: Method(function, "nothing")),
    "classmethod": Decorator(lambda function: Method(function, "class")),
    "object": BaseMarker("object"),
    **{name: BaseMarker("object", name) for name in _ERRORS},
}
