"""The words of `words.txt`, `kinds.txt` and `shapeless.txt`, and their meanings."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from lidardraft.arranging.district import STREET_DISTRICTS
from lidardraft.drafting.text.positions import Position, place_named
from lidardraft.drafting.text.tokens import NUMBER_WORDS

_FILES = ("words.txt", "kinds.txt", "shapeless.txt")
_NOUNS = ("kind", "road", "foreign", "accessory", "scenery")


class Word(NamedTuple):
    """A role in phrases of a word, or of several words that go together."""

    category: str
    features: Mapping[str, Any]


@cache
def lexicon() -> dict[str, tuple[tuple[tuple[str, ...], Word], ...]]:
    """The words that go together, by their first word, and their roles."""
    found: dict[str, list[tuple[tuple[str, ...], Word]]] = {}
    for line in itertools.chain.from_iterable(map(rows, _FILES)):
        head, _, words = line.partition(": ")
        category, *said = head.split()
        features = features_of(said)
        for entry in words.split(", "):
            noun = {"noun": entry.removeprefix("=").partition("|")[0]} if category == "kind" else {}
            for form, plural in _forms(category, entry):
                parts = tuple(form.split())
                found.setdefault(parts[0], []).append((parts, Word(category, plural | features | noun)))
    return {first: tuple(entries) for first, entries in found.items()}


@cache
def vocabulary() -> frozenset[str]:
    """All words of the lexicon, and those of numbers."""
    return frozenset(NUMBER_WORDS).union(*(parts for entries in lexicon().values() for parts, _ in entries))


def district_of(word: str) -> str | None:
    """The street district of that name, or of a word in sentences, as in "downtown"; None if there is none."""
    parts = tuple(word.split())
    said = (row.features.get("district") for entry, row in lexicon().get("".join(parts[:1]), ()) if entry == parts)
    return word if word in STREET_DISTRICTS else next((str(name) for name in said if name), None)


def rows(name: str) -> Iterator[str]:
    """The lines of a file beside this one, without comments."""
    lines = Path(__file__).with_name(name).read_text(encoding="utf-8").splitlines()
    return (line for line in lines if line and not line.startswith("#"))


def features_of(said: list[str]) -> dict[str, Any]:
    """The features written as "name=value", a name alone, or "at.field=value"; `at` is a `Position`."""
    features: dict[str, Any] = {}
    fields: dict[str, Any] = {}
    for one in said:
        name, _, text = one.partition("=")
        if name == "at" or name.startswith("at."):
            features["at"] = None
            fields |= {name[3:]: _value(text, name)} if name != "at" and text != "none" else {}
        else:
            features[name] = _value(text, name)
    if fields or (features.get("at", 0) is None and "at=none" not in said):
        features["at"] = Position(**fields)
    return features


def _value(text: str, name: str) -> Any:
    if text in ("", "no", "none"):
        return {"": True, "no": False, "none": None}[text]
    values = tuple(_one_value(part) for part in text.split(","))
    if name == "at.places":
        return tuple(place_named(part) for part in text.split(","))
    return values if len(values) > 1 else values[0]


def _one_value(text: str) -> int | float | str:
    if not re.fullmatch(r"-?\d+(\.\d+)?", text):
        return text
    return float(text) if "." in text else int(text)


def _forms(category: str, entry: str) -> list[tuple[str, dict[str, bool | str]]]:
    """The forms of an entry, with their grammatical number if it is a noun."""
    one, _, many = entry.removeprefix("=").partition("|")
    if category not in _NOUNS or entry.startswith("="):
        return [(one, {})]
    if one == many:  # as sheep
        return [(one, {"plural": "any"})]
    return [(one, {"plural": False}), (many or _plural(one), {"plural": True})]


def _plural(noun: str) -> str:
    if noun.endswith(("s", "ch", "sh", "x")):
        return noun + "es"
    return noun[:-1] + "ies" if noun[-1] == "y" and noun[-2] not in "aeiou" else noun + "s"
