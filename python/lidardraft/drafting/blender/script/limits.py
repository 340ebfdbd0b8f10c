"""The limits of reading a script, the errors that end it, and the rest of its budget.

A node of the syntax tree is a step, and works on values of bounded length. Elements that are made together are counted,
and a clock bounds long steps. So every script ends, in bounded time and memory.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, fields
from typing import Any

_STEPS_OF_CLOCK = 7  # a power of 2, less 1: the clock is checked if the steps left are a multiple of that power
_COMPARED_IN_A_STEP = 10_000  # characters
_MOST_NOTES = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptLimits:
    """The limits of one script; anything beyond is refused.

    The defaults keep a script within a second and tens of megabytes on a laptop.
    """

    file: int = 4_000_000  # characters of the script
    code: int = 125_000  # characters outside of comments and strings
    steps: int = 175_000  # evaluations of nodes of the syntax tree
    seconds: int | float = 3  # of processor time
    levels: int = 150  # of nesting: of the script's text, and of calls within calls
    length: int = 250_000  # elements of one value, or eighths of the characters of a text
    cells: int = 1_000_000  # elements of all values made or copied as a whole
    objects: int = 5_000
    vertices: int = 500_000  # of all meshes together

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not value > 0 or (field.name != "seconds" and type(value) is not int):
                raise ValueError(f"{field.name} is {value!r}; a limit is a whole number of 1 or more")


class RefusalError(Exception):
    """The reason why a script is refused; `line` is the innermost line that it is about, once known."""

    def __init__(self, message: str, line: int | None = None) -> None:
        super().__init__(message)
        self.line = line

    def at(self, line: int) -> RefusalError:
        """This error, with a line if it had none."""
        self.line = self.line or line
        return self


class RaisedError(RefusalError):
    """An error that Python would raise too, by the `name` of its class: the script may catch it. `said` is its `str`,
    by default the message."""

    def __init__(self, name: str, message: str, said: str | None = None) -> None:
        super().__init__(message)
        self.name = name
        self.said = message if said is None else said


class Script:
    """A script in execution: its line, notes on ignored parts, and the rest of its limits.

    `notes` are messages about ignored parts, each with the line of its first occurrence.
    """

    def __init__(self, limits: ScriptLimits) -> None:
        self.limits = limits
        self.steps = limits.steps
        self.end = time.thread_time() + limits.seconds
        self.cells = limits.cells
        self.levels = 0  # of nested nodes, in all running functions and iterators
        self.line = 1
        self.notes: dict[str, int] = {}
        self.modules: dict[str, Any] = {}  # the modules that it may import
        self.handled: RaisedError | None = None  # the error that a bare `raise` raises again

    def note(self, message: str, line: int | None = None) -> None:
        """Note an ignored part."""
        if len(self.notes) < _MOST_NOTES:
            self.notes.setdefault(message, line or self.line)

    def take_step(self) -> None:
        """Count the evaluation of a node, or work that takes as long."""
        self.steps -= 1
        if self.steps < 0:
            raise RefusalError(f"the script takes more than {self.limits.steps} steps; `limits` allows more")
        if not self.steps & _STEPS_OF_CLOCK:
            self.check_time()

    def check_time(self) -> None:
        """Raises `RefusalError` if the script has used up its processor time."""
        if time.thread_time() > self.end:
            raise RefusalError(f"the script takes more than {self.limits.seconds} s; `limits` allows more")

    def go_deeper(self, line: int) -> None:
        """Count a step and a level of nested nodes; the caller takes 1 from `levels` on return."""
        if self.levels >= self.limits.levels:
            raise RefusalError(f"nested more than {self.limits.levels} levels deep, with calls within calls", line)
        self.take_step()
        self.levels += 1

    def take_cells(self, count: int) -> None:
        """Count the elements of a value that is made as a whole."""
        if count > self.limits.length:
            raise RefusalError(f"a value of {count} elements; the limit is {self.limits.length}")
        self.cells -= max(count, 0)
        if self.cells < 0:
            raise RefusalError(f"all values together have more than {self.limits.cells} elements")

    def take_text(self, characters: int) -> None:
        """Count the characters of a text, eight to a cell, before it is made."""
        if characters > 8 * self.limits.length:
            raise RefusalError(f"a text of {characters} characters; the limit is {8 * self.limits.length}")
        self.take_cells(characters // 8 + 1)

    def take_made(self, value: object) -> None:
        """Count the elements of the result of a function or an operator."""
        if isinstance(value, str):
            self.take_text(len(value))
        elif isinstance(value, list | tuple):
            self.take_cells(len(value))
        elif isinstance(value, dict):
            self.take_cells(3 * len(value))

    def take_compared(self, values: list[Any]) -> None:
        """Count the characters of texts in one step with many comparisons."""
        long = sum([len(value) for value in values if isinstance(value, str)])
        self.steps -= long // _COMPARED_IN_A_STEP
        self.take_step()
