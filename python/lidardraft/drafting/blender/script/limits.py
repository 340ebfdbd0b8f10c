"""What reading a script may cost: each limit, the errors that end it, and the count of what is used up."""

from __future__ import annotations

import ast
from collections.abc import Container
from dataclasses import dataclass
from typing import Any

_COMPARED_IN_A_STEP = 10_000  # characters
_MOST_NOTES = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """The most that one script may ask for; what goes beyond is refused, whatever it is for.

    The defaults keep a script within a tenth of a second and tens of megabytes on a laptop.
    """

    file: int = 4_000_000  # characters of the script
    tokens: int = 25_000  # names, numbers and signs of it, outside comments and strings
    steps: int = 175_000  # nodes of the syntax tree that are evaluated, one for each time; a token takes six more
    levels: int = 150  # of nesting: of the script's text, and of calls within calls
    length: int = 250_000  # elements of one value, or eighths of the characters of a text
    cells: int = 1_000_000  # elements of all values that are made or walked through, together
    objects: int = 5_000
    vertices: int = 500_000  # of all meshes together

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if type(value) is not int or value < 1:
                raise ValueError(f"{name} is {value!r}; a limit is a whole number of 1 or more")


class RefusalError(Exception):
    """Why a script is not read on; `line` is the innermost line that it is about, once known."""

    def __init__(self, message: str, line: int | None = None) -> None:
        super().__init__(message)
        self.line = line

    def at(self, line: int) -> RefusalError:
        """It, with a line where it has none yet."""
        self.line = self.line or line
        return self


class RaisedError(RefusalError):
    """An error that Python too would raise, by the `name` of its class: one that the script may catch, and of which
    `str` is `said`: the message, where it is None."""

    def __init__(self, name: str, message: str, said: str | None = None) -> None:
        super().__init__(message)
        self.name = name
        self.said = message if said is None else said


class Script:
    """A script that is being carried out: where it is, what was passed over, and what is left of its limits.

    `notes` are lines about what was passed over, each with the line of the script where that was met first.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.steps = limits.steps
        self.cells = limits.cells
        self.levels = 0  # of nodes within nodes, in all functions and iterators that are being carried out
        self.line = 1
        self.notes: dict[str, int] = {}
        self.modules: dict[str, Any] = {}  # that it may import
        self.generators: Container[ast.AST] = ()  # its functions with a `yield`
        self.handled: RaisedError | None = None  # what a bare `raise` raises again

    def note(self, message: str, line: int | None = None) -> None:
        """Keep a line about what is passed over."""
        if len(self.notes) < _MOST_NOTES:
            self.notes.setdefault(message, line or self.line)

    def take_steps(self, count: int) -> None:
        """Count so many evaluated nodes, or what takes as long; a number below 0 is 0."""
        self.steps -= max(count, 0)
        if self.steps < 0:
            raise RefusalError(f"the script takes more than {self.limits.steps} steps; `limits` allows more")

    def go_deeper(self, line: int) -> None:
        """Count a step, and one level more of nodes within nodes; whoever goes back takes 1 from `levels`."""
        if self.levels >= self.limits.levels:
            raise RefusalError(f"nested more than {self.limits.levels} levels deep, with calls within calls", line)
        self.steps -= 1
        if self.steps < 0:
            self.take_steps(0)
        self.levels += 1

    def take_cells(self, count: int) -> None:
        """Count so many elements of a value, before it is made; a number below 0 is 0."""
        if count > self.limits.length:
            raise RefusalError(f"a value of {count} elements; {self.limits.length} are the most")
        self.cells -= max(count, 0)
        if self.cells < 0:
            raise RefusalError(f"all values together have more than {self.limits.cells} elements")

    def take_compared(self, *values: object) -> None:
        """Count the characters of the texts among some values that are compared; short ones count for nothing."""
        self.take_steps(sum([len(value) for value in values if isinstance(value, str)]) // _COMPARED_IN_A_STEP)

    def take_text(self, characters: int) -> None:
        """Count the characters of a text, eight to a cell, before it is made."""
        if characters > 8 * self.limits.length:
            raise RefusalError(f"a text of {characters} characters; {8 * self.limits.length} are the most")
        self.take_cells(characters // 8 + 1)
