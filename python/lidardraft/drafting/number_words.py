"""How many and how far: the meaning of numbers, of words for them, and of lengths."""

from __future__ import annotations

import re

from lark import Token

_COUNT_OF = {"FEW": "few", "SOME": "some", "MANY": "many"}
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
