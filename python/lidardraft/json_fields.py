"""Foreign JSON: the object or list in a text, its fields, and checks of numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from lidardraft.errors import FormatError

_LONGEST = 2**26  # bytes or letters of a text
_MOST_BRACKETS = 3_000_000  # lists and objects of a text; each takes a hundred bytes of memory
_MOST_FIELDS = 1_500_000  # of all objects; each takes twice as much memory and time


def parse_json(text: str | bytes) -> Any:
    """The content of a JSON text; raises `FormatError` if it is not JSON, or exceeds the limits."""
    check_brackets(text)
    try:
        return json.loads(text)
    except RecursionError:
        raise FormatError("not JSON that can be read: it is nested too deeply") from None
    except json.JSONDecodeError as error:
        begins = f"; it begins with {text[:20]!r}" if error.pos == 0 and text else ""
        raise FormatError(f"not JSON: {error}{begins}") from None
    except ValueError as error:  # a number of too many digits raises it too
        raise FormatError(f"not JSON: {error}") from None


def parse_object(text: str | bytes) -> dict[str, Any]:
    """The object in a JSON text; raises `FormatError` if the text holds something else or nothing."""
    return check_object(parse_json(text))


def parse_document(text: str, schema: str, required: Iterable[str], optional: Iterable[str]) -> dict[str, Any]:
    """The object in a JSON text of this schema; raises `FormatError` on another schema or other fields."""
    document = parse_object(text)
    check_schema(document.get("schema"), schema)
    check_fields(document, ("schema", *required), optional)
    return document


def check_schema(found: Any, schema: str) -> None:
    """Raises `FormatError` unless the schema of a file is this one."""
    if found != schema:
        name, _, version = str(found).rpartition("/")
        is_later = (
            schema.startswith(f"{name}/") and version.isdecimal() and int(version) > int(schema.rpartition("/")[2])
        )
        later = "; a later version of lidardraft wrote it: update lidardraft" if is_later else ""
        raise FormatError(f"schema is {found!r}; this version reads {schema!r}{later}")


def parse_list(text: str | bytes) -> list[Any]:
    """The list in a JSON text; raises `FormatError` if the text holds something else or nothing."""
    document = parse_json(text)
    if not isinstance(document, list):
        raise FormatError(f"{document!r:.50} is not a JSON list")
    return document


def check_object(value: Any) -> dict[str, Any]:
    """The value, if it is a JSON object; else raises `FormatError`."""
    if not isinstance(value, dict):
        raise FormatError(f"{value!r:.50} is not a JSON object")
    return value


def check_fields(fields: Iterable[str], required: Iterable[str], optional: Iterable[str] = ()) -> None:
    """Raises `FormatError` naming a missing or unknown field."""
    given = set(fields)
    missing = set(required) - given
    if missing:
        raise FormatError(f"{min(missing)!r} is missing")
    unknown = given - set(required) - set(optional)
    if unknown:
        raise FormatError(f"unknown field {min(unknown)!r}")


def check_brackets(text: str | bytes) -> None:
    """Raises `FormatError` if a text is too long, or has too many lists, objects or fields."""
    if len(text) > _LONGEST:
        raise FormatError(f"{len(text)} bytes of JSON; up to {_LONGEST} are read")
    opened, begun, fields = map(text.count, "[{:") if isinstance(text, str) else map(text.count, (b"[", b"{", b":"))
    check_lists(opened + begun)
    if fields > _MOST_FIELDS:
        raise FormatError(f"{fields} fields; JSON of up to {_MOST_FIELDS} is read")


def check_lists(number: int) -> None:
    """Raises `FormatError` if a text has too many lists and objects."""
    if number > _MOST_BRACKETS:
        raise FormatError(f"{number} lists and objects; JSON of up to {_MOST_BRACKETS} is read")


def is_number(value: Any) -> bool:
    """Whether the value is a finite real number that fits in a float; False for True and False."""
    if type(value) is float:  # most are
        return math.isfinite(value)
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # too many digits for a float
        return False


def are_numbers(values: Any, count: int) -> bool:
    """Whether the value is a list, tuple or array of `count` finite numbers."""
    return isinstance(values, list | tuple | np.ndarray) and len(values) == count and all(map(is_number, values))


def read_as(kind: Any, value: Any, name: str = "") -> Any:
    """A JSON value in the type of an annotation: a dataclass from an object, a tuple from a list, else the value
    itself. A dataclass with a JSON form of its own has `read` and `written`.

    Raises `FormatError` naming the place, the value and the expected type; a dataclass raises its own errors.
    """
    origin, kinds = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        (kind,) = (one for one in kinds if one is not NoneType)
        return None if value is None else read_as(kind, value, name)
    if is_dataclass(kind) and isinstance(kind, type):
        return kind.read(value, name) if hasattr(kind, "read") else _read_dataclass(kind, value, name)
    if origin is tuple:
        length = None if kinds[-1] is Ellipsis else len(kinds)
        if not isinstance(value, list | tuple) or (length or len(value)) != len(value):
            raise FormatError(f"{name} is {value!r:.50}; it must be a list{f' of {length}' if length else ''}")
        each = kinds if length else (kinds[0],) * len(value)
        rows = zip(each, value, strict=True)
        return tuple(read_as(one, row, f"{name}[{number}]") for number, (one, row) in enumerate(rows))
    if not (is_number(value) if kind is float else type(value) is kind):
        raise FormatError(f"{name} is {value!r:.50}; it must be {_NAMES[kind]}")
    return value


_NAMES = {float: "a finite number", int: "a whole number", str: "text", bool: "true or false"}
_annotations = cache(get_type_hints)


def _read_dataclass(kind: Any, value: Any, name: str) -> Any:
    rows, given = fields(kind), check_object(value)
    in_it = f"{name}." if name else ""
    for row in rows:
        if row.default is MISSING and row.name not in given:
            raise FormatError(f"{in_it}{row.name} is missing")
    for field in given:
        if field not in {row.name for row in rows}:
            raise FormatError(f"unknown field {in_it}{field}")
    hints = _annotations(kind)
    return kind(**{field: read_as(hints[field], one, in_it + field) for field, one in given.items()})


def write_as(value: Any) -> Any:
    """The value as JSON types, the inverse of `read_as`. Fields of dataclasses with default values are left out."""
    if is_dataclass(value) and not isinstance(value, type):
        if hasattr(value, "written"):
            return value.written()
        rows = ((row, getattr(value, row.name)) for row in fields(value))
        return {row.name: write_as(one) for row, one in rows if one != _default(row)}
    if isinstance(value, Mapping):
        return {name: write_as(one) for name, one in value.items()}
    return list(map(write_as, value)) if isinstance(value, tuple) else value


def _default(row: Field[Any]) -> Any:
    return row.default if row.default_factory is MISSING else row.default_factory()
