"""The values of a script: None, numbers, text, lists, tuples, dicts, ranges, and records.

No value gives access to Python itself: attributes are looked up in tables of records, never with `getattr`. Records
define their operators, items, loops and calls with Python's special methods.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, ClassVar, TypeVar

from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script

Value = Any  # one of the types above; mypy has no useful type for it
LARGEST = 2**63  # the largest whole number
_SURROGATE = re.compile("[\ud800-\udfff]")
_NUMBER = (int, float)  # checked so often that a slower union would show
_SEQUENCES = (str, list, tuple, dict, range)
Methods = dict[str, Callable[..., Value]]


class Record:
    """A value that may have attributes, items or operators; the base class has none.

    `fields` read attributes, `setters` set some of them, and `methods` get the record first.
    """

    kind = "a value"
    is_key = False  # whether it can be a key of a dict, equal to itself only
    only_alike = False  # whether operators combine it only with its own type
    fields: ClassVar[Methods] = {}
    setters: ClassVar[Methods] = {}
    methods: ClassVar[Methods] = {}

    def has_private(self, _name: str) -> bool:
        """Whether an attribute that begins with an underscore may be read and set."""
        return False

    def attribute(self, name: str) -> Value:
        """The value of an attribute."""
        if name in self.fields:
            return self.fields[name](self)
        if name in self.methods:
            return Builtin(name, partial(self.methods[name], self))
        raise RefusalError(f"{self.kind} has no {name!r} that is supported")

    def set_attribute(self, name: str, value: Value) -> None:
        """Set an attribute."""
        if name not in self.setters:
            raise RefusalError(f"{name!r} of {self.kind} cannot be set to {describe(value)}")
        self.setters[name](self, value)

    def text(self, _as_repr: bool) -> str:
        """Its `str`, or its `repr`."""
        return f"<{self.kind}>"

    def compared_as(self) -> Value:
        """The Python value that represents it in comparisons; itself if == decides."""
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
    """A function of the reader. It gets the script's arguments, and may raise the errors of Python's functions. `own`
    are functions that are its attributes."""

    kind = "a function"

    def __init__(self, name: str, call: Callable[..., Value], own: Methods | None = None) -> None:
        self.name = name
        self._call = call
        self._own = own or {}

    def attribute(self, name: str) -> Value:
        return Builtin(name, self._own[name]) if name in self._own else super().attribute(name)

    def __call__(self, /, *arguments: Value, **keywords: Value) -> Value:
        """Its result. Wrong arguments raise `RefusalError`, which no script can catch: Python might accept them."""
        try:
            return self._call(*arguments, **keywords)
        except TypeError:
            given = [*map(describe, arguments[:4]), *(f"{name:.40}=..." for name in list(keywords)[:4])]
            raise RefusalError(f"{self.name}() does not take the arguments ({', '.join(given):.200})") from None
        except (ValueError, ArithmeticError, LookupError) as error:
            raise RaisedError(type(error).__name__, f"{self.name}: {error!s:.200}") from None


def builtins(module: str, functions: Methods) -> dict[str, Value]:
    """Functions by name, as those of a module ("math.") or, for "", of none."""
    return {name: Builtin(module + name, function) for name, function in functions.items()}


class Type(Record):
    """A type for `isinstance`; | joins it with others, and with None."""

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
    """The result of `isinstance`."""
    asked = kinds if isinstance(kinds, tuple) else (kinds,)
    return any(value is None if kind is None else isinstance(kind, Type) and kind.holds(value) for kind in asked)


def type_of(records: type[Record]) -> Type:
    """A class of Blender that a script may use with `isinstance` only."""
    return Type("a class of Blender", lambda value: isinstance(value, records))


class TypeFunction(Type, Builtin):
    """A function that is also a type: `list`, `float`. Types in brackets are ignored."""

    def __init__(self, name: str, call: Callable[..., Value], types: tuple[type, ...]) -> None:
        Builtin.__init__(self, name, call)
        self.holds = lambda value: isinstance(value, types)

    def __getitem__(self, _key: Value) -> Value:
        return self


class Namespace(Record):
    """A module, or another value with fixed attributes."""

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
    """A function without effect."""


class Outside(Record):
    """An unknown module, or a part of one: it may be imported, but only its name is known."""

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
    """The result of a function."""
    if not isinstance(function, Record):
        raise RefusalError(f"{describe(function)} cannot be called")
    script.take_step()
    return function(*arguments, **keywords)


def is_number(value: Value) -> bool:
    """Whether a value is an int, a float or a bool."""
    return isinstance(value, _NUMBER)


def checked(value: Value) -> Value:
    """The value; raises `RefusalError` for a complex number or a whole number of more than 63 bits."""
    if isinstance(value, int) and not -LARGEST <= value <= LARGEST:
        raise RefusalError("a whole number of more than 63 bits")
    if isinstance(value, complex):
        raise RefusalError("a complex number")
    return value


def whole(value: Value, what: str, least: int = -LARGEST, most: int = LARGEST) -> int:
    """The value as a whole number from `least` to `most`; raises `RefusalError` otherwise."""
    if not isinstance(value, int):
        raise RefusalError(f"{what} is {describe(value)}; it must be a whole number")
    if not least <= value <= most:
        span = (
            f"{most} or less" if least == -LARGEST else f"{least} or more" if most == LARGEST else f"{least} to {most}"
        )
        raise RefusalError(f"{what} is {value}; it must be {span}")
    return int(value)


def place(value: Value, count: int, what: str) -> int:
    """The value as an index below `count`, from the end if negative; raises `RaisedError` out of range."""
    if not -count <= whole(value, "a place") < count:
        raise RaisedError("IndexError", f"{what} of {count} has no place {value}")
    return int(value)


def of_kind(value: Value, kind: type[AnyRecord], what: str) -> AnyRecord:
    """The value; raises `RefusalError` unless it is a record of that kind."""
    if not isinstance(value, kind):
        raise RefusalError(f"{what} is {describe(value)}; it must be {kind.kind}")
    return value


def real(value: Value, what: str) -> float:
    """The value as a float; raises `RefusalError` unless it is a finite number."""
    if not is_number(value) or not -1e300 < value < 1e300:
        raise RefusalError(f"{what} is {describe(value)}; it must be a finite number")
    return float(value)


def text(value: Value, what: str) -> str:
    """The value; raises `RefusalError` unless it is a text."""
    if not isinstance(value, str):
        raise RefusalError(f"{what} is {describe(value)}; it must be a text")
    return value


def lone_surrogate(text: str) -> int | None:
    """The index of the first lone surrogate, which UTF-8 cannot encode, or None."""
    match = None if text.isascii() else _SURROGATE.search(text)
    return match.start() if match else None


def reals(value: Value, count: int, what: str) -> tuple[float, ...]:
    """The value as `count` finite floats; raises `RefusalError` otherwise."""
    numbers = list(value) if isinstance(value, Record) else value
    if not isinstance(numbers, list | tuple) or len(numbers) != count:
        raise RefusalError(f"{what} is {describe(value)}; it must be {count} numbers")
    return tuple([real(number, what) for number in numbers])


def elements(value: Value, script: Script) -> list[Value]:
    """The elements of the value as a new list; raises `RefusalError` if it is not iterable."""
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
    """The number of a value's elements or characters."""
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
    """The value; raises `RefusalError` unless it can be a key of a dict."""
    if not is_key(key):
        raise RefusalError(f"{describe(key)} cannot be a key")
    return key


def describe(value: Value) -> str:
    """A short description of any value, for messages."""
    if isinstance(value, Record):
        return value.kind
    if isinstance(value, str):
        return repr(value[:40])
    if isinstance(value, list | tuple | dict | range):
        return f"a {type(value).__name__}"
    return repr(value)
