"""What stands in and around the body of a class: decorators, methods, fields, and the classes of Python's own."""

from __future__ import annotations

from collections.abc import Callable

from lidardraft.drafting.script.values import Record, Value


class Decorator(Record):
    """What may stand behind an @."""

    kind = "a decorator"

    def __init__(self, around: Callable[[Value], Value]) -> None:
        self.around = around

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        """Itself, as in `@dataclass(frozen=True)`; what stands in the brackets changes no shape."""
        return self if keywords or not arguments else self.around(arguments[0])


class Method(Record):
    """A function of a class: one that is called with the instance or the class first, or with neither."""

    kind = "a method"

    def __init__(self, function: Value, bound_to: str) -> None:
        self.function = function
        self.bound_to = bound_to  # "property", "class" or "nothing"

    def attribute(self, name: str) -> Value:
        if name != "setter" or self.bound_to != "property":
            return super().attribute(name)
        return Decorator(lambda setter: Setter(self.function, setter))


class Setter(Method):
    """A property that can be set too."""

    def __init__(self, function: Value, setter: Value) -> None:
        super().__init__(function, "property")
        self.setter = setter


class FieldDefault(Record):
    """What `field(...)` of a dataclass says."""

    kind = "a field of a dataclass"

    def __init__(self, default: Value = None, default_factory: Value = None, **_: Value) -> None:
        self.default = default
        self.factory = default_factory


class BaseMarker(Record):
    """A class of Python's own that others may be derived from: "object", "Enum" or "NamedTuple"."""

    is_key = True

    def __init__(self, name: str) -> None:
        self.kind = f"the class {name}"
        self.name = name


class ErrorClass(BaseMarker):
    """A class of errors of Python's own, of which the script may derive others."""

    def __init__(self, error: str) -> None:
        super().__init__("object")
        self.kind = f"the class {error}"
        self.error = error


class AutoValue(Record):
    """`auto()`: the number of a member of an enumeration."""

    kind = "auto()"
