"""Tables of pandas in `.pkl.gz` files, read as data.

A pickle is a program that may call anything. Here it calls nothing: each call is recorded as a name, arguments and a
state. The columns are taken from the records that pandas 0.24 to 1.2 leave.
"""

from __future__ import annotations

import gzip
import io
import os
import pickletools
from dataclasses import dataclass
from typing import Any

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import expecting, named, read_bytes

_LARGEST = 2**26  # bytes of an unpacked table; a sweep's has 8 million
_MOST_STEPS = 2**17  # of a program; a sweep's takes 300, a hundred boxes' 2,000
_CONSTANTS = {"NONE": None, "NEWTRUE": True, "NEWFALSE": False, "EMPTY_TUPLE": ()}


@dataclass(slots=True, eq=False)
class _Record:
    """A recorded call of a pickle: the name, the arguments, and the state for the result."""

    name: str
    arguments: Any = None
    state: Any = None


def read_pickled_table(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """The columns [N] of a table by name: numbers, or objects that are texts, numbers or None.

    Raises `FormatError` if the file is broken, holds anything but such a table, or unpacks to more than any sweep.
    """
    data = read_bytes(path)
    with named(path), expecting("a table of pandas 0.24 to 1.2 in a whole .pkl.gz file"):
        with gzip.open(io.BytesIO(data)) as file:
            program = file.read(_LARGEST + 1)
        if len(program) > _LARGEST:
            raise FormatError(f"it unpacks to more than {_LARGEST} bytes")
        return _columns(_result(program))


def _result(program: bytes) -> Any:
    """The result of a pickle, with records in place of all its calls."""
    stack, marked, memo = list[Any](), list[list[Any]](), dict[Any, Any]()
    for number, (step, argument, _) in enumerate(pickletools.genops(program)):
        if number == _MOST_STEPS:
            raise FormatError(f"its program has more than {_MOST_STEPS} steps")
        items = list[Any]()
        if step.name in ("TUPLE", "APPENDS", "SETITEMS"):
            items, stack = stack, marked.pop()
        elif step.name in ("TUPLE1", "TUPLE2", "TUPLE3", "APPEND", "SETITEM", "REDUCE", "NEWOBJ", "BUILD"):
            size = {"TUPLE2": 2, "TUPLE3": 3, "SETITEM": 2}.get(step.name, 1)
            items = [stack.pop() for _ in range(size)][::-1]
        match step.name.rstrip("123"):
            case "PROTO" | "STOP":
                pass
            case "MARK":
                marked.append(stack)
                stack = []
            case "BINPUT" | "LONG_BINPUT":
                memo[argument] = stack[-1]
            case "BINGET" | "LONG_BINGET":
                stack.append(memo[argument])
            case "GLOBAL":
                stack.append(_Record(str(argument)))
            case "REDUCE" | "NEWOBJ":
                stack.append(_Record(stack.pop().name, *items))
            case "BUILD":
                (stack[-1].state,) = items
            case "TUPLE":
                stack.append(tuple(items))
            case "EMPTY_LIST":
                stack.append([])
            case "APPEND" | "APPENDS":
                stack[-1].extend(items)
            case "EMPTY_DICT":
                stack.append({})
            case "SETITEM" | "SETITEMS":
                stack[-1].update({_text(key): value for key, value in zip(items[::2], items[1::2], strict=True)})
            case name if name in _CONSTANTS or argument is not None:
                stack.append(_CONSTANTS.get(name, argument))
            case name:
                raise FormatError(f"its program has a step {name}")
    (result,) = stack
    return result


def _columns(table: _Record) -> dict[str, np.ndarray]:
    manager = table.state.get("_data") or table.state["_mgr"]
    _, blocks, names, *_ = manager.state  # values [columns, N] of a type, and the index of their names
    columns = {
        _text(name): column
        for block, index in zip(blocks, names, strict=True)
        for name, column in zip(_array(index.arguments[1]["data"]), _array(block), strict=True)
    }
    if len({column.shape for column in columns.values()}) != 1 or any(column.ndim != 1 for column in columns.values()):
        raise FormatError("its columns are not of one length")
    return columns


def _array(record: _Record) -> np.ndarray:
    """An array from numbers in bytes, or from objects in a list."""
    _, shape, kind, by_columns, content = record.state
    dtype = np.dtype(kind.state[1] + kind.arguments[0])
    if dtype.kind == "O":
        if not all(isinstance(value, str | int | float | None) for value in content):
            raise FormatError("its objects are not texts and numbers")
        flat = np.array(content, dtype=object)
    elif dtype.kind in "fiub":
        flat = np.frombuffer(content, dtype)
    else:
        raise FormatError(f"it holds {dtype}; it must hold texts and numbers")
    return flat.reshape(shape, order="F" if by_columns else "C")


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise FormatError("a name in it is not text")
    return value
