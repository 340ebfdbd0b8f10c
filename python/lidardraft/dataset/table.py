"""Tables of a recipe in TOML: each key is checked, and messages name its place."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NoReturn

import numpy as np

from lidardraft.errors import FormatError, did_you_mean, one_of
from lidardraft.json_fields import is_number

# The values of a key: one value, a list of equally likely ones, or {from, to}: any number between, whole if both ends
# are.
Values = Any


def drawn(values: Values, rng: np.random.Generator) -> Any:
    """One of the values, drawn at random."""
    if isinstance(values, list):
        return drawn(values[int(rng.integers(len(values)))], rng)
    if not isinstance(values, dict):
        return values
    low, high = values["from"], values["to"]
    if isinstance(low, int) and isinstance(high, int):
        return int(rng.integers(low, high, endpoint=True))
    return float(rng.uniform(low, high))


def all_drawn(values: dict[str, Values], rng: np.random.Generator) -> dict[str, Any]:
    """One of the values of each name, drawn at random."""
    return {name: drawn(each, rng) for name, each in values.items()}


def every(values: Values) -> list[Any]:
    """All values that can be drawn; of a range, its ends."""
    if isinstance(values, list):
        return [each for value in values for each in every(value)]
    return [values["from"], values["to"]] if isinstance(values, dict) else [values]


@dataclass
class Table:
    """A table and its place, as in "scene 2, "; `known` are the keys that were read."""

    fields: dict[str, Any]
    place: str = ""
    known: list[str] = field(default_factory=list)

    def __contains__(self, key: str) -> bool:
        self.known.append(key)
        return key in self.fields

    def get(self, key: str, default: Any = None) -> Any:
        """The value of a key, unchecked."""
        return self.fields[key] if key in self else default

    def refuse(self, key: str, must: str) -> NoReturn:
        """Raise `FormatError` on the value of a key, or on its absence."""
        said = f"{self.fields[key]!r:.80}" if key in self.fields else "missing"
        raise FormatError(f"{self.place}{key} is {said}; it must be {must}")

    def whole(self, key: str, default: int, least: int, most: int = 2**53) -> int:
        """A whole number."""
        value = self.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            self.refuse(key, f"a whole number from {least} to {most}")
        return value

    def share(self) -> float:
        """The share of a choice, relative to the others; 1 by default."""
        value = self.get("share", 1.0)
        if not is_number(value) or value < 0:
            self.refuse("share", "a number of 0 or more")
        return float(value)

    def name(self, key: str, names: list[str], default: str) -> str:
        """One of the names."""
        value = self.get(key, default)
        if value not in names:
            self.refuse(key, one_of(names, value))
        return str(value)

    def names(self, key: str, names: list[str]) -> Values:
        """One of the names, or a list of them."""
        values = self.texts(key)
        for value in every(values):
            if value not in names:
                self.refuse(key, one_of(names, value))
        return values

    def text(self, key: str) -> str:
        """One text."""
        value = self.get(key)
        if not isinstance(value, str) or not value.strip():
            self.refuse(key, "a text")
        return value

    def texts(self, key: str) -> Values:
        """A text, or a list of texts."""
        values = self.get(key)
        texts = values if isinstance(values, list) else [values]
        if not texts or not all(isinstance(text, str) and text.strip() for text in texts):
            self.refuse(key, "a text, or a list of texts")
        return values

    def numbers(self, key: str, default: float, least: float = -math.inf, most: float = math.inf) -> Values:
        """Numbers from `least` to `most`."""
        values = self.get(key, default)
        if key in self.fields and not _are_numbers(values, least, most):
            limits = f" from {least:g} to {most:g}" if math.isfinite(least) else ""
            self.refuse(key, f"a number{limits}, a list of such, or {{from = ..., to = ...}} with the smaller first")
        return values

    def words(self, key: str) -> dict[str, Values]:
        """A table of texts and numbers by name."""
        given = self.table(key)
        for name, values in given.fields.items():
            if not all(isinstance(each, str) or _are_numbers(each) for each in _list(values)) or values == []:
                given.refuse(name, "texts or numbers: one, a list, or {from = ..., to = ...}")
        return given.fields

    def table(self, key: str) -> Table:
        """A nested table; an empty one if there is none."""
        value = self.get(key, {})
        if not isinstance(value, dict):
            self.refuse(key, "a table")
        return Table(value, f"{self.place}{key}, ")

    def tables(self, key: str) -> Iterator[Table]:
        """The tables [[key]], numbered from 1; each is ended when the next one is requested."""
        value = self.get(key, [])
        if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
            self.refuse(key, f"tables, each begun by [[{key}]]")
        for number, each in enumerate(value, 1):
            table = Table(each, f"{self.place}{key} {number}, ")
            yield table
            table.end()

    def end(self) -> None:
        """Raise `FormatError` on a key that was never read."""
        for key in sorted(self.fields.keys() - set(self.known)):
            near = did_you_mean(self.known, key) or f"; known are {', '.join(sorted(set(self.known)))}"
            raise FormatError(f"{self.place}{key} is not a key here{near}")


def _list(values: Values) -> list[Any]:
    return values if isinstance(values, list) else [values]


def _are_numbers(values: Values, least: float = -math.inf, most: float = math.inf) -> bool:
    """Whether all values that can be drawn are numbers within the limits."""
    if isinstance(values, list):
        return bool(values) and all(_are_numbers(value, least, most) for value in values)
    if isinstance(values, dict):
        if {*values} != {"from", "to"} or not all(map(is_number, values.values())):
            return False
        return bool(least <= values["from"] <= values["to"] <= most)
    return is_number(values) and least <= values <= most
