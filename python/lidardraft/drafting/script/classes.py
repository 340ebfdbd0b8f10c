"""Classes that a script defines, and their instances: names and values of ours, looked up in tables."""

from __future__ import annotations

from collections.abc import Callable

from lidardraft.drafting.script.arithmetic import equal
from lidardraft.drafting.script.class_parts import (
    AutoValue,
    BaseMarker,
    Decorator,
    ErrorClass,
    FieldDefault,
    Method,
    Setter,
)
from lidardraft.drafting.script.frame import Frame, Function
from lidardraft.drafting.script.limits import Budget, RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Type, Value, describe, text

SPECIAL = ("__init__", "__post_init__", "__repr__", "__str__")  # methods that a class may have
_DEEPEST, _MOST_NAMES = 16, 200  # classes of which one is derived from the other; names of a class
_STEPS = 5  # that an instance costs
_ERRORS = (
    *("BaseException", "Exception", "ArithmeticError", "AssertionError", "AttributeError", "ImportError", "IndexError"),
    *("KeyError", "LookupError", "NameError", "NotImplementedError", "OSError", "OverflowError", "RuntimeError"),
    *("StopIteration", "SystemExit", "TypeError", "ValueError", "ZeroDivisionError"),
)
Call = Callable[[Value, list[Value], dict[str, Value]], Value]
_MISSING = object()


class ClassFrame(Frame):
    """The names of a class, as its body sets them; `annotated` are those with a type, in order."""

    __slots__ = ("annotated",)

    def __init__(self, outer: Frame) -> None:
        super().__init__(outer, {})
        self.annotated: list[str] = []

    def set(self, name: str, value: Value) -> None:
        if name in SPECIAL:
            self.variables[name] = value
        else:
            super().set(name, value)


class ScriptClass(Type):
    """A class: its members by their names, and the fields that its instances are made from, if it says them.

    Raises `RefusalError` where it is derived from too many others.
    """

    def __init__(self, name: str, base: Value, body: ClassFrame, budget: Budget, call: Call) -> None:
        self.name = name
        self.kind = f"the class {name:.40}"
        self.base = base if isinstance(base, ScriptClass) else None
        self.marker: str = self.base.marker if self.base else base.name if isinstance(base, BaseMarker) else "object"
        self.is_enumeration = self.marker.endswith("Enum")
        self.depth: int = 1 + (self.base.depth if self.base else 0)
        if self.depth > _DEEPEST:
            raise RefusalError(f"a class derived from more than {_DEEPEST} others")
        self.members = members = body.variables
        if len(members) + len(body.annotated) > 2 * _MOST_NAMES:
            raise RefusalError(f"a class of more than {_MOST_NAMES} names")
        self.annotated = body.annotated
        self.fields: list[str] | None = self.base.fields if self.base else None
        self.is_dataclass: bool = self.base is not None and self.base.is_dataclass
        self.run = call
        self._budget = budget
        for member in members.values():
            function = member.function if isinstance(member, Method) else member
            if isinstance(function, Function) and function.owner is None:
                function.owner = self
        if self.is_enumeration:
            self._enumerate()
        elif self.marker == "NamedTuple":
            self.take_fields()

    def take_fields(self) -> None:
        """Let instances be made from the annotated names, after those of the class that it is derived from."""
        self._budget.take_steps(len(self.annotated) + len(self.fields or ()))
        self.fields = list(dict.fromkeys([*(self.fields or ()), *self.annotated]))

    def _enumerate(self) -> None:
        last: Value = 0
        for name, value in self.members.items():
            if not isinstance(value, Function | Method):
                member = Instance(self)
                if isinstance(value, AutoValue) and not isinstance(last, int):
                    raise RefusalError(f"auto() behind {describe(last)} is not read")
                last = last + 1 if isinstance(value, AutoValue) else value
                member.values |= {"name": name, "value": last}
                self.members[name] = member

    def find(self, name: str) -> Value:
        """The member of that name, of the class or of those that it is derived from, or `_MISSING`."""
        owner: ScriptClass | None = self
        while owner is not None:
            if name in owner.members:
                return owner.members[name]
            owner = owner.base
        return _MISSING

    def derived_from(self, other: Value) -> bool:
        """Whether it is the other class, or derived from it."""
        return self is other or (self.base is not None and self.base.derived_from(other))

    def has_private(self, name: str) -> bool:
        return name in (*SPECIAL, "__name__") or not name.startswith("__")

    def bound(self, found: Value, instance: Instance | None) -> Value:
        """A member as an attribute of an instance, or of the class itself."""
        if isinstance(found, Method):
            if found.bound_to == "property" and instance is not None:
                return self.run(found.function, [instance], {})
            first = self if found.bound_to == "class" else None
            return found.function if first is None else BoundMethod(found.function, first, self.run)
        return BoundMethod(found, instance, self.run) if isinstance(found, Function) and instance else found

    def attribute(self, name: str) -> Value:
        if name == "__name__":
            return self.name
        found = self.find(name)
        return super().attribute(name) if found is _MISSING else self.bound(found, None)

    def set_attribute(self, name: str, value: Value) -> None:
        self._budget.take_cells(3 if name in self.members else 3000)  # every later step goes through a name more
        self.members[name] = value

    def _members_of_enumeration(self) -> list[Instance]:
        self._budget.take_steps(len(self.members))
        return [member for member in self.members.values() if isinstance(member, Instance)]

    def elements(self) -> list[Value]:
        return list(self._members_of_enumeration()) if self.is_enumeration else super().elements()

    def item(self, key: Value) -> Value:
        if not self.is_enumeration or not isinstance(key, str) or key not in self.members:
            return super().item(key)
        return self.members[key]

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        self._budget.take_steps(_STEPS + len(self.fields or ()))
        self._budget.take_cells(3 + 3 * len(self.fields or ()))
        if self.is_enumeration:
            for member in self._members_of_enumeration() if len(arguments) == 1 else []:
                if equal(member.values["value"], arguments[0], self._budget):
                    return member
            raise RefusalError(f"{self.kind} has no such member")
        instance = Instance(self)
        start = self.find("__init__")
        if start is not _MISSING:
            self.run(start, [instance, *arguments], keywords)
        elif self.fields is not None:
            self._fill(instance, self.fields, arguments, keywords)
        elif arguments or keywords:
            raise RefusalError(f"{self.kind} takes no arguments")
        return instance

    def _fill(self, instance: Instance, fields: list[str], arguments: list[Value], keywords: dict[str, Value]) -> None:
        if len(arguments) > len(fields) or not set(keywords) <= set(fields[len(arguments) :]):
            raise RefusalError(f"{self.kind} is given other arguments than {', '.join(fields):.100}")
        given = dict(zip(fields, arguments, strict=False)) | keywords
        for name in fields:
            default = self.find(name)
            if name not in given and default is _MISSING:
                raise RefusalError(f"{self.kind} is not given {name!r:.60}")
            if name not in given and isinstance(default, FieldDefault):
                default = default.default if default.factory is None else self.run(default.factory, [], {})
            instance.values[name] = given.get(name, default)
        after = self.find("__post_init__")
        if after is not _MISSING:
            self.run(after, [instance], {})


class Instance(Record):
    """An instance of a class of the script; a key of a dict by its values, where Python's is and they are plain."""

    is_key = True

    def __init__(self, of: ScriptClass) -> None:
        self.of = of
        self.kind = f"a value of {of.kind}"
        self.values: dict[str, Value] = {}
        self._key: Value = None  # what it is a key as, once that is asked for

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
        if self.of.marker in ("IntEnum", "StrEnum"):
            return self.values["value"]
        if self.of.marker == "NamedTuple":
            return tuple(self.values.values())
        return (self.of, *self.values.values()) if self.of.is_dataclass else self

    def text(self, as_repr: bool) -> str:
        for name in ("__repr__",) if as_repr else ("__str__", "__repr__"):
            if (found := self.of.find(name)) is not _MISSING:
                return text(self.of.run(found, [self], {}), f"what {name} gives")
        if self.of.is_enumeration and not as_repr:
            plain = self.of.marker != "Enum"
            return str(self.values["value"]) if plain else f"{self.of.name}.{self.values['name']}"
        return super().text(as_repr)

    def has_private(self, name: str) -> bool:
        return name == "__class__" or not (name.startswith("__") and name.endswith("__"))

    def has(self, name: str) -> bool:
        """Whether it, or its class, has an attribute of that name."""
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
        if isinstance(found, Setter):
            self.of.run(found.setter, [self, value], {})
        elif isinstance(found, Method) or name == "__class__" or self.of.marker != "object":
            super().set_attribute(name, value)
        else:
            self.of._budget.take_cells(1)
            self.values[name] = value
            self._key = None

    def elements(self) -> list[Value]:
        return list(self.values.values()) if self.of.marker == "NamedTuple" else super().elements()

    def item(self, key: Value) -> Value:
        numbers = self.elements() if self.of.marker == "NamedTuple" else []
        if not isinstance(key, int) or not -len(numbers) <= key < len(numbers):
            return super().item(key)
        return numbers[key]


def _as_key(value: Value) -> Value:
    return value._as_key() if isinstance(value, Instance) else value


class BoundMethod(Record):
    """A function together with the value that it gets first."""

    kind = "a method"

    def __init__(self, function: Value, first: Value, call: Call) -> None:
        self._function = function
        self._first = first
        self._call = call

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        return self._call(self._function, [self._first, *arguments], keywords)


class Super(Record):
    """`super()` in a method of the class `of`: what those have that it is derived from."""

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
            return Builtin("super", lambda *_, **__: None) if name in SPECIAL else super().attribute(name)
        return base.bound(found, self._instance if isinstance(self._instance, Instance) else None)


def dataclass(of: Value) -> Value:
    """The class, of which the instances are made from its annotated names."""
    if not isinstance(of, ScriptClass):
        raise RefusalError(f"{describe(of)} is no class")
    of.take_fields()
    of.is_dataclass = True
    return of


def builtin_decorators() -> dict[str, Value]:
    """What Python has without an import: decorators of methods, and the class of all."""
    return {
        "property": Decorator(lambda function: Method(function, "property")),
        "staticmethod": Decorator(lambda function: Method(function, "nothing")),
        "classmethod": Decorator(lambda function: Method(function, "class")),
        "object": BaseMarker("object"),
        **{name: ErrorClass(name) for name in _ERRORS},
    }
