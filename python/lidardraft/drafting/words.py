"""What single words say: numbers, counts, positions."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass

from lark import Token

Place = tuple[str, str]  # before or behind, and the side; "" where nothing is said

_PLACES_OF: dict[str, tuple[Place, ...]] = {
    "FRONT": (("front", ""),),
    "BEHIND": (("behind", ""),),
    "BESIDE": (("beside", ""),),
    "LEFT": (("", "left"),),
    "RIGHT": (("", "right"),),
    "SIDES": (("", "left"), ("", "right")),
}
_COUNT_OF = {"FEW": "few", "SOME": "some", "MANY": "many"}
_RANGE_OF = {"NEAR": (8.0, 18.0), "FAR": (35.0, 60.0)}  # m
_METRES_OF = {"m": 1.0, "f": 0.3048, "y": 0.9144}  # by the first letter of the unit
_PLURALS = ("people", "men", "women", "children", "shrubbery", "greenery", "vegetation", "apartments", "passers by")
_ONES = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
_TEENS = ("eleven", "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen")
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety", "hundred")
_VALUE_OF = {word: float(n) for n, word in enumerate(_ONES + _TEENS)} | {
    word: 20.0 + 10.0 * n for n, word in enumerate(_TENS)
}
_NUMBER = re.compile(
    rf"\d+(?:\.\d+)?|\b(?:{'|'.join(_TENS)})(?: (?:{'|'.join(_ONES[1:10])})\b)?|\b(?:{'|'.join(_ONES + _TEENS)})\b"
)


@dataclass(frozen=True, slots=True)
class Position:
    """Where something is; the default says nothing. `beside_road` is on any side of it."""

    places: tuple[Place, ...] = (("", ""),)
    distance: tuple[float, float] | None = None
    spacing: float | None = None
    sidewalk: bool = False
    beside_road: bool = False
    both_sides: bool = False

    def narrowed(self, other: Position) -> Position:
        """Both at once: "ahead" and "on the left" are ahead on the left. Contradictions are alternatives."""
        pairs = [(_both(a, c), _both(b, d)) for a, b in self.places for c, d in other.places]
        places = tuple((fore, side) for fore, side in pairs if fore is not None and side is not None)
        return Position(
            places=places or self.places + other.places,
            distance=other.distance or self.distance,
            spacing=other.spacing or self.spacing,
            sidewalk=self.sidewalk or other.sidewalk,
            beside_road=self.beside_road or other.beside_road,
            both_sides=self.both_sides or other.both_sides,
        )

    def or_at(self, other: Position) -> Position:
        """One and the other: "in front" and "behind"."""
        return dataclasses.replace(self, places=self.places + other.places)

    def without(self, other: Position) -> Position:
        """Only where the other is not."""
        places = tuple(place for place in self.places if place not in other.places)
        return dataclasses.replace(self, places=places or self.places)


def read_position(tokens: list[Token], *, beside_road: bool = False) -> Position:
    """The position that a run of words describes; `beside_road` if a road follows them, as in "next to the road"."""
    position = Position()
    for token in tokens:
        if token.type == "BESIDE" and beside_road:
            word = Position(beside_road=True)
        elif token.type == "DISTANCE":
            word = Position(distance=metres(token))
        elif token.type == "SPACING":
            word = Position(spacing=metres(token)[0])
        else:
            word = Position(
                places=_PLACES_OF.get(token.type, (("", ""),)),
                distance=_RANGE_OF.get(token.type),
                sidewalk=token.type == "SIDEWALK",
                beside_road=token.type == "ALONG",
                both_sides=token.type == "SIDES",
            )
        position = position.narrowed(word)
    return position


def count_of(tokens: list[Token]) -> int | str:
    """How many a noun phrase means: a number, "few", "some" or "many"; 0 where it denies them."""
    for token in tokens:
        if token.type == "NO":
            return 0
        if token.type == "NUMBER" and number(token).is_integer():
            return int(number(token))
        if token.type in _COUNT_OF:
            return _COUNT_OF[token.type]
        if token.type in ("PAIR", "DOZEN"):
            return {"P": 2, "D": 6 if token.startswith("half") else 12}[token.type[0]]
    if any(token.type == "A" for token in tokens):
        return 1
    noun = tokens[-1]
    plural = noun in _PLURALS or (noun.endswith("s") and noun != "bus")
    return "some" if plural else 1


def number(text: str) -> float:
    """The value of a number in digits or words up to a hundred."""
    found = _NUMBER.search(text)
    assert found is not None
    words = found.group()
    return float(words) if words[0].isdigit() else sum(_VALUE_OF[word] for word in words.split())


def metres(text: str) -> tuple[float, float]:
    """The range [m] in a text such as "20 m", "ten to 30 feet" or "every 8 metres"."""
    values = [number(found) for found in _NUMBER.findall(text)]
    unit = re.search(r"(m|f|y)[a-z]*(?: apart)?$", text)
    assert unit is not None
    scale = _METRES_OF[unit.group(1)]
    return min(values) * scale, max(values) * scale


def _both(a: str, b: str) -> str | None:
    """Both where they agree or one says nothing; None where they contradict each other."""
    return a or b if not (a and b) or a == b else None
