"""What a value of a script can be: None, numbers, text, lists, tuples, dicts, ranges, and records of ours.

Nothing of Python itself is a value: an attribute is looked up in a table of the record, never with `getattr`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError

Value = Any  # one of the types above; mypy has no way to say it that helps here
LARGEST = 2**63  # of whole numbers
_MOVED_IN_A_STEP, _TAKEN_IN_A_STEP = 2000, 50  # elements of a list
MOST_TYPES = 50  # that isinstance is asked for
_NUMBER = (int, float)  # asked for so often that a union, which is slower, shows


class Record:
    """A value with attributes, items or operators of its own; here it has none."""

    kind = "a value"
    is_key = False  # whether it can be a key of a dict: what is the same only as itself
    weight = 0  # steps that a use of it costs beyond its node: an attribute, an item, an operator, a call

    def has_private(self, _name: str) -> bool:
        """Whether a name that begins with an underscore may be read and set in it."""
        return False

    def attribute(self, name: str) -> Value:
        """The value of an attribute."""
        raise RefusalError(f"{self.kind} has no {name!r} that is read")

    def set_attribute(self, name: str, value: Value) -> None:
        """Give an attribute another value."""
        raise RefusalError(f"{name!r} of {self.kind} cannot be set to {describe(value)}")

    def item(self, key: Value) -> Value:
        """What square brackets give."""
        raise RefusalError(f"{self.kind} has no item {describe(key)}")

    def set_item(self, key: Value, value: Value) -> None:
        """What an assignment to square brackets does."""
        raise RefusalError(f"{self.kind} has no item {describe(key)} that can be set to {describe(value)}")

    def elements(self) -> list[Value]:
        """What a loop goes through."""
        raise RefusalError(f"{self.kind} cannot be looped over")

    def length(self) -> int:
        """The number of its elements."""
        return len(self.elements())

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        """The result of an operator with another value, which stands on the left of it where `reflected`."""
        pair = (describe(other), self.kind) if reflected else (self.kind, describe(other))
        raise RefusalError(f"{operator.__name__} of {pair[0]} and {pair[1]} is not read")

    def negative(self) -> Value:
        """The result of a minus sign."""
        raise RefusalError(f"{self.kind} cannot be calculated with")

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        """What it returns when it is called."""
        raise RefusalError(f"{self.kind} cannot be called with {len(arguments) + len(keywords)} arguments")

    def contains(self, value: Value) -> bool:
        """Whether `in` finds the value in it."""
        return value in self.elements()

    def truth(self) -> bool:
        """What it counts as in a condition."""
        return True

    def equals(self, other: Value) -> bool:
        """Whether it is equal to another value."""
        return self is other

    def compared_as(self) -> Value:
        """The value of Python's that it is compared as: itself, where `equals` decides."""
        return self

    def text(self, _as_repr: bool) -> str:
        """What `str`, or `repr`, makes of it."""
        return f"<{self.kind}>"


class DefaultDict(dict[Value, Value]):
    """A dict that gets what `factory()` gives for a key that it lacks."""

    factory: Value = None


class Counter(dict[Value, Value]):
    """A dict of numbers, in which what it lacks has the number 0."""


class Deque(list[Value]):
    """A list that a script also takes from, and adds to, on the left."""


class Builtin(Record):
    """A function of ours; it gets what the script passes, and may raise what Python's functions raise."""

    kind = "a function"

    def __init__(self, name: str, call: Callable[..., Value], weight: int = 2) -> None:
        self.name = name
        self.weight = weight
        self._call = call

    def call(self, arguments: list[Value], keywords: dict[str, Value]) -> Value:
        """Its result. Raises `RefusalError` with what the function says of wrong arguments, which a script cannot
        catch: the function of Python's might take them."""
        try:
            return self._call(*arguments, **keywords)
        except TypeError as error:
            said = str(error).replace("<lambda>()", self.name)
            raise RefusalError(f"{self.name}: {said:.200}") from None
        except (ValueError, ArithmeticError, LookupError) as error:
            raise RaisedError(type(error).__name__, f"{self.name}: {error!s:.200}") from None


class Type(Record):
    """What `isinstance` asks for; | joins it with others, and with None."""

    is_key = True

    def types(self) -> tuple[Value, ...]:
        """It, or all that are joined in it."""
        return (self,)

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        if operator is not ast.BitOr or not (other is None or isinstance(other, Type)):
            return super().binary(operator, other, reflected=reflected)
        others = (None,) if other is None else other.types()
        return UnionOfTypes(others + self.types() if reflected else self.types() + others)


class UnionOfTypes(Type):
    """`int | float | None`. Raises `RefusalError` where it is of too many."""

    kind = "a union of types"

    def __init__(self, types: tuple[Value, ...]) -> None:
        if len(types) > MOST_TYPES:
            raise RefusalError(f"a union of {len(types)} types; {MOST_TYPES} are the most")
        self._types = types

    def types(self) -> tuple[Value, ...]:
        return self._types


class TypeFunction(Type, Builtin):
    """A function that is also a type: `list`, `float`. What is said of types in brackets is passed over."""

    def item(self, _key: Value) -> Value:
        return self


class KindOfRecord(Type):
    """A class of Blender's that a script may only ask about, with `isinstance`."""

    kind = "a class of Blender"

    def __init__(self, of: type[Record]) -> None:
        self.of = of


class Namespace(Record):
    """A module, or what has fixed attributes like one."""

    def __init__(self, name: str, values: dict[str, Value]) -> None:
        self.kind = name
        self.values = values

    def attribute(self, name: str) -> Value:
        if name not in self.values:
            raise RefusalError(f"{self.kind}.{name} is not read")
        return self.values[name]


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


def whole(value: Value, what: str) -> int:
    """The value, which is a whole number."""
    if not isinstance(value, int):
        raise RefusalError(f"{what} is {describe(value)}; it must be a whole number")
    return int(value)


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


def reals(value: Value, count: int, what: str) -> tuple[float, ...]:
    """The value as so many finite floats."""
    numbers = value.elements() if isinstance(value, Record) else value
    if not isinstance(numbers, list | tuple) or len(numbers) != count:
        raise RefusalError(f"{what} is {describe(value)}; it must be {count} numbers")
    return tuple([real(number, what) for number in numbers])


def elements(value: Value, budget: Budget) -> list[Value]:
    """What a loop over the value goes through, as a list of its own; raises `RefusalError` where it is none."""
    if isinstance(value, Record):
        found = value.elements()
        budget.take_cells(len(found))
        return found
    if not isinstance(value, str | list | tuple | dict | range):
        raise RefusalError(f"{describe(value)} cannot be looped over")
    budget.take_cells(_length(value))
    return list(value)


def _length(value: Value) -> int:
    try:
        return len(value)
    except OverflowError:  # a range of more than 2^63
        raise RefusalError("a range without end") from None


def length(value: Value) -> int:
    """The number of its elements or characters."""
    if isinstance(value, Record):
        return value.length()
    if isinstance(value, str | list | tuple | dict | range):
        return _length(value)
    raise RefusalError(f"{describe(value)} has no length")


def take_moved(items: list[Value], places: Value, budget: Budget) -> None:
    """Count the elements that move or go where those at a place, or within a slice, are taken out or put in."""
    if isinstance(places, slice):
        budget.take_steps(len(items) // _TAKEN_IN_A_STEP)
    else:
        behind = -places if places < 0 else len(items) - places
        budget.take_steps(min(max(behind, 0), len(items)) // _MOVED_IN_A_STEP)


def truth(value: Value) -> bool:
    """What the value counts as in a condition."""
    return value.truth() if isinstance(value, Record) else bool(value)


def describe(value: Value) -> str:
    """The value, for a message: short, whatever it is."""
    if isinstance(value, Record):
        return value.kind
    if isinstance(value, str):
        return repr(value[:40])
    if isinstance(value, list | tuple | dict | range):
        return f"a {type(value).__name__}"
    return repr(value)
