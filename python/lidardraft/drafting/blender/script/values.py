"""What a value of a script can be: None, numbers, text, lists, tuples, dicts, ranges, and records.

Nothing of Python itself is a value: an attribute is looked up in a table of the record, never with `getattr`. What
operators, brackets, loops and calls do, records say as Python's own values do.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, ClassVar, TypeVar

from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script

Value = Any  # one of the types above; mypy has no way to say it that helps here
LARGEST = 2**63  # of whole numbers
_SURROGATE = re.compile("[\ud800-\udfff]")
_NUMBER = (int, float)  # asked for so often that a union, which is slower, shows
_SEQUENCES = (str, list, tuple, dict, range)
Methods = dict[str, Callable[..., Value]]


class Record:
    """A value with attributes, items or operators of its own; here it has none.

    `fields` give the attributes that can be read, `setters` set some, and `methods` get the record first.
    """

    kind = "a value"
    is_key = False  # whether it can be a key of a dict: what is the same only as itself
    only_alike = False  # whether operators take it with its like alone
    fields: ClassVar[Methods] = {}
    setters: ClassVar[Methods] = {}
    methods: ClassVar[Methods] = {}

    def has_private(self, _name: str) -> bool:
        """Whether a name that begins with an underscore may be read and set in it."""
        return False

    def attribute(self, name: str) -> Value:
        """The value of an attribute."""
        if name in self.fields:
            return self.fields[name](self)
        if name in self.methods:
            return Builtin(name, partial(self.methods[name], self))
        raise RefusalError(f"{self.kind} has no {name!r} that is supported")

    def set_attribute(self, name: str, value: Value) -> None:
        """Give an attribute another value."""
        if name not in self.setters:
            raise RefusalError(f"{name!r} of {self.kind} cannot be set to {describe(value)}")
        self.setters[name](self, value)

    def text(self, _as_repr: bool) -> str:
        """What `str`, or `repr`, makes of it."""
        return f"<{self.kind}>"

    def compared_as(self) -> Value:
        """The value of Python's that it is compared as: itself, where == decides."""
        return self

    def __getitem__(self, key: Value) -> Value:
        raise RefusalError(f"{self.kind} has no item {describe(key)}")

    def __setitem__(self, key: Value, value: Value) -> None:
        raise RefusalError(f"{self.kind} has no item {describe(key)} that can be set to {describe(value)}")

    def __iter__(self) -> Iterator[Value]:
        raise RefusalError(f"{self.kind} cannot be looped over")

    def __bool__(self) -> bool:
        return True

    def __call__(self, /, *arguments: Value, **keywords: Value) -> Value:
        raise RefusalError(f"{self.kind} cannot be called with {len(arguments) + len(keywords)} arguments")


AnyRecord = TypeVar("AnyRecord", bound=Record)


class Builtin(Record):
    """A function of the reader's; it gets what the script passes, and may raise what Python's functions raise. `own`
    are functions that stand behind a dot of it."""

    kind = "a function"

    def __init__(self, name: str, call: Callable[..., Value], own: Methods | None = None) -> None:
        self.name = name
        self._call = call
        self._own = own or {}

    def attribute(self, name: str) -> Value:
        return Builtin(name, self._own[name]) if name in self._own else super().attribute(name)

    def __call__(self, /, *arguments: Value, **keywords: Value) -> Value:
        """Its result. Raises `RefusalError` for wrong arguments, which cannot be caught: Python might take them."""
        try:
            return self._call(*arguments, **keywords)
        except TypeError:
            given = [*map(describe, arguments[:4]), *(f"{name:.40}=..." for name in list(keywords)[:4])]
            raise RefusalError(f"{self.name}() does not take the arguments ({', '.join(given):.200})") from None
        except (ValueError, ArithmeticError, LookupError) as error:
            raise RaisedError(type(error).__name__, f"{self.name}: {error!s:.200}") from None


def builtins(module: str, functions: Methods) -> dict[str, Value]:
    """Functions by their names, as those of a module ("math.") or, for "", of none."""
    return {name: Builtin(module + name, function) for name, function in functions.items()}


class Type(Record):
    """What `isinstance` asks for; | joins it with others, and with None."""

    is_key = True

    def __init__(self, kind: str, holds: Callable[[Value], bool]) -> None:
        self.kind = kind
        self.holds = holds

    def __or__(self, other: Value) -> Type:
        if not (other is None or isinstance(other, Type)):
            return NotImplemented
        return Type("a union of types", lambda value: is_of(value, (self, other)))

    __ror__ = __or__


def is_of(value: Value, kinds: Value) -> bool:
    """What `isinstance` says."""
    asked = kinds if isinstance(kinds, tuple) else (kinds,)
    return any(value is None if kind is None else isinstance(kind, Type) and kind.holds(value) for kind in asked)


def type_of(records: type[Record]) -> Type:
    """A class of Blender's that a script may only ask about, with `isinstance`."""
    return Type("a class of Blender", lambda value: isinstance(value, records))


class TypeFunction(Type, Builtin):
    """A function that is also a type: `list`, `float`. What is said of types in brackets is passed over."""

    def __init__(self, name: str, call: Callable[..., Value], types: tuple[type, ...]) -> None:
        Builtin.__init__(self, name, call)
        self.holds = lambda value: isinstance(value, types)

    def __getitem__(self, _key: Value) -> Value:
        return self


class Namespace(Record):
    """A module, or what has fixed attributes like one."""

    def __init__(self, name: str, values: dict[str, Value]) -> None:
        self.kind = name
        self.values = values

    def attribute(self, name: str) -> Value:
        if name not in self.values:
            raise RefusalError(f"{self.kind}.{name} is not supported")
        return self.values[name]

    def set_attribute(self, name: str, value: Value) -> None:
        if name not in self.values:
            super().set_attribute(name, value)
        self.values[name] = value


def nothing(*_: Value, **__: Value) -> None:
    """What a function does that changes nothing."""


class Outside(Record):
    """A module that is not known, or a part of one: it may be imported, and all that is known of it is its name."""

    def __init__(self, name: str) -> None:
        self.kind = name[:60]

    def attribute(self, name: str) -> Value:
        return Outside(f"{self.kind}.{name[:60]}")

    def __call__(self, /, *_arguments: Value, **_keywords: Value) -> Value:
        raise RefusalError(f"a call of {self.kind}: a script is read, not run, and this module is not known")

    def __bool__(self) -> bool:
        raise RefusalError(f"the value of {self.kind}: a script is read, not run, and this module is not known")

    def __eq__(self, _other: object) -> bool:
        return bool(self)

    def text(self, _as_repr: bool) -> str:
        return str(bool(self))


def call(function: Value, arguments: list[Value], keywords: dict[str, Value], script: Script) -> Value:
    """What a function returns."""
    if not isinstance(function, Record):
        raise RefusalError(f"{describe(function)} cannot be called")
    script.take_step()
    return function(*arguments, **keywords)


def is_number(value: Value) -> bool:
    """Whether it is an int, a float or a bool."""
    return isinstance(value, _NUMBER)


def checked(value: Value) -> Value:
    """The value, which is no number or one that is not too large."""
    if isinstance(value, int) and not -LARGEST <= value <= LARGEST:
        raise RefusalError("a whole number of more than 63 bits")
    if isinstance(value, complex):
        raise RefusalError("a complex number")
    return value


def whole(value: Value, what: str, least: int = -LARGEST, most: int = LARGEST) -> int:
    """The value, which is a whole number from `least` to `most`."""
    if not isinstance(value, int):
        raise RefusalError(f"{what} is {describe(value)}; it must be a whole number")
    if not least <= value <= most:
        span = (
            f"{most} or less" if least == -LARGEST else f"{least} or more" if most == LARGEST else f"{least} to {most}"
        )
        raise RefusalError(f"{what} is {value}; it must be {span}")
    return int(value)


def place(value: Value, count: int, what: str) -> int:
    """The value, which is a place among so many, counted from the end where it is below 0."""
    if not -count <= whole(value, "a place") < count:
        raise RaisedError("IndexError", f"{what} of {count} has no place {value}")
    return int(value)


def of_kind(value: Value, kind: type[AnyRecord], what: str) -> AnyRecord:
    """The value, which is a record of that kind."""
    if not isinstance(value, kind):
        raise RefusalError(f"{what} is {describe(value)}; it must be {kind.kind}")
    return value


def real(value: Value, what: str) -> float:
    """The value as a float, which is a finite number."""
    if not is_number(value) or not -1e300 < value < 1e300:
        raise RefusalError(f"{what} is {describe(value)}; it must be a finite number")
    return float(value)


def text(value: Value, what: str) -> str:
    """The value, which is a text."""
    if not isinstance(value, str):
        raise RefusalError(f"{what} is {describe(value)}; it must be a text")
    return value


def lone_surrogate(text: str) -> int | None:
    """The place of the first half of a character that stands alone, which no file in UTF-8 can hold."""
    match = None if text.isascii() else _SURROGATE.search(text)
    return match.start() if match else None


def reals(value: Value, count: int, what: str) -> tuple[float, ...]:
    """The value as so many finite floats."""
    numbers = list(value) if isinstance(value, Record) else value
    if not isinstance(numbers, list | tuple) or len(numbers) != count:
        raise RefusalError(f"{what} is {describe(value)}; it must be {count} numbers")
    return tuple([real(number, what) for number in numbers])


def elements(value: Value, script: Script) -> list[Value]:
    """What a loop over the value goes through, as a list of its own; raises `RefusalError` where it is none."""
    if isinstance(value, Record):
        found = []
        for each in value:
            script.take_cells(1)
            found.append(each)
        return found
    if not isinstance(value, _SEQUENCES):
        raise RefusalError(f"{describe(value)} cannot be looped over")
    script.take_cells(length(value))
    return list(value)


def length(value: Value) -> int:
    """The number of its elements or characters."""
    if not hasattr(type(value), "__len__"):
        raise RefusalError(f"{describe(value)} has no length")
    try:
        return len(value)
    except OverflowError:  # a range of more than 2^63
        raise RefusalError("a range without end") from None


def is_key(value: Value) -> bool:
    """Whether a value can be a key of a dict: a number, a text, None, a record that is one, or a tuple of those."""
    if isinstance(value, tuple):
        return len(value) <= 16 and all(not isinstance(item, tuple) and is_key(item) for item in value)
    return value.is_key if isinstance(value, Record) else value is None or isinstance(value, int | float | str)


def dict_key(key: Value) -> Value:
    """The value, which can be a key of a dict."""
    if not is_key(key):
        raise RefusalError(f"{describe(key)} cannot be a key")
    return key


def describe(value: Value) -> str:
    """The value, for a message: short, whatever it is."""
    if isinstance(value, Record):
        return value.kind
    if isinstance(value, str):
        return repr(value[:40])
    if isinstance(value, list | tuple | dict | range):
        return f"a {type(value).__name__}"
    return repr(value)
