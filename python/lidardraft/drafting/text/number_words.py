"""How many and how far: the meaning of numbers, of words for them, and of lengths.

A number is read whole or not at all: what is no single whole number counts nothing, and is reported.
"""

from __future__ import annotations

import re

from lark import Token

_BELOW_TWENTY = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"),
    *("thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen"),
)
SMALL_NUMBERS = _BELOW_TWENTY[1:]
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_SCALES = {"thousand": 1e3, "million": 1e6, "billion": 1e9}
_VALUE_OF = {word: value for value, word in enumerate(_BELOW_TWENTY)} | {
    word: 20 + 10 * index for index, word in enumerate(_TENS)
}
_METRES_OF = {
    "m": 1.0,
    "c": 0.01,
    "i": 0.0254,
    "f": 0.3048,
    "y": 0.9144,
    "k": 1000.0,
}  # by the first letter of the unit

# Patterns for the grammar and for `metres`. Floats hold fifteen digits exactly; longer figures are no numbers here.
_digit = rf"(?:{'|'.join(_BELOW_TWENTY[1:10])})\b"
_below_hundred = rf"(?:(?:{'|'.join(_TENS)})\b(?: {_digit})?|(?:{'|'.join(_BELOW_TWENTY[1:])})\b)"
_figures = r"(?:\d{1,3}(?:,\d{3}){1,4}|\d{1,15})(?:\.\d{1,15})?"
# "a hundred and one" is not cut
_no_more = rf"(?! (?:and )?{_below_hundred}(?! (?:hundred|thousand|million|billion)\b))"
_below_thousand = (
    rf"(?:(?:(?:a|\d{{1,3}}|{_below_hundred}) )?hundred\b(?: (?:and )?{_below_hundred}|{_no_more})|{_below_hundred})"
)
_scale = rf"(?:{'|'.join(_SCALES)})\b"
_in_words = (
    rf"(?:(?:(?:a|\d{{1,3}}|{_below_thousand}) )?{_scale}(?: (?:and )?{_below_thousand}(?: {_scale})?)*"
    rf"|{_below_thousand})"
    rf"(?: point(?: (?:zero|{_digit}))+)?"
)
NUMBER = rf"(?:{_in_words}|{_figures})"
LONE_NUMBER = (
    rf"{NUMBER}(?! ?(?:km\/h|m\/s))(?=[,.;:!?()\/\"]*(?:\s|$))"  # with nothing glued to it, as in "4x4", "2nd" or "20+"
)
UNIT = r"(?:(?:kilo|centi)?met(?:re|er)s?|km|cm|m|feet|foot|ft|yards?|yd|inch(?:es)?)\b(?!\/)"
_word = rf"(?:{'|'.join((*_VALUE_OF, 'hundred', *_SCALES))})"
_goes_on = rf"(?:(?:{_word}|dozen|and|to|or|point|lanes?|ways?|wheelers?)\b|{UNIT})"
# A word such as "ten-ton" or "sixty-five-seat", whose number counts no objects; "ten-metre" and "two-lane" are read.
NUMBERED_COMPOUND = re.compile(rf"(?<![a-z0-9])(?:{_word}|[\d.,]*\d)-(?!{_goes_on})[a-z]")
_LENGTHS = re.compile(rf"([a-z ]*?)({NUMBER})(?:(?: (?:to|and|or) |-| - )({NUMBER}))? ?([kmfyci])[a-z]*(?: .*)?")
_COUNTS = re.compile(rf"([a-z ]*?)({NUMBER})(?:(?: (?:to|and|or) |-| - )({NUMBER}))?( or (?:more|fewer|so))?")
_AT_MOST = (
    *("within", "less than", "closer than", "nearer than", "under"),
    *("up to", "at most", "no more than", "fewer than"),
)
_AT_LEAST = ("at least", "more than", "over", "beyond", "further than", "farther than", "no fewer than")
_FURTHER = 40.0  # m, what "at least 20 m" reaches beyond; estimate of ours
_FEW_OF = {"a few": (3, 5), "several": (3, 6), "a couple of": (2, 2)}  # dozen, hundred, thousand; estimate of ours
_EACH = {"dozen": 12, "hundred": 100, "thousand": 1000}
_AT_LEAST_TWO = {"dozens of": (24, 36), "scores of": (40, 60), "hundreds of": (200, 300)}  # estimate of ours

_EXACT = ("NUMBER", "PAIR", "DOZEN")
_VAGUE = {"FEW": "few", "SOME": "some", "MANY": "many", "DOZENS": "many"}
_GROUPS: dict[str, Count] = {"couple": 2, "family": (3, 4), "crowd": "many", "crowds": "many"}
COUNT_TYPES = ("NO", "COUNT_RANGE", *_EXACT, *_VAGUE)
Count = int | str | tuple[int, int]  # a number, a word for one, or a range
_PLURALS = (
    "folk",
    "ladies",
    "people",
    "men",
    "women",
    "children",
    "shrubbery",
    "greenery",
    "vegetation",
    "apartments",
    "passers by",
)


def count_of(tokens: list[Token]) -> Count:
    """How many a noun phrase means: a number, a range of them, "few", "some" or "many"; 0 where it denies them.

    What `unclear_counts` finds says nothing here.
    """
    unclear = unclear_counts(tokens)
    count = None if unclear else exact_count(tokens)
    if count is not None:
        return count
    ranges = [token for token in tokens if token.type == "COUNT_RANGE"]
    if ranges and not unclear:
        return count_range(ranges[0])
    plural = [_AT_LEAST_TWO[token] for token in tokens if token in _AT_LEAST_TWO]
    if plural and not unclear:
        return plural[0]
    vague = [_VAGUE[token.type] for token in tokens if token.type in _VAGUE]
    if vague and not unclear:
        return "many" if "many" in vague else vague[0]
    noun = str(tokens[-1])
    several = 2 if any(token.startswith("both") for token in tokens) else "some"
    return _GROUPS.get(noun) or (several if is_plural(noun) else 1)


def is_plural(noun: str) -> bool:
    """Whether a noun of the grammar speaks of several objects."""
    return noun in _PLURALS or (noun.endswith("s") and not noun.endswith("bus"))


def exact_count(tokens: list[Token]) -> int | None:
    """The one whole number that a noun phrase says, 0 for none; None if it says no number or several."""
    exact = [token for token in tokens if token.type == "NO" or token.type in _EXACT]
    if len(exact) != 1 or unclear_counts(tokens):
        return None
    (token,) = exact
    if token.type == "NUMBER":
        return int(number(token))
    if token.type == "DOZEN":
        times = token.removesuffix(" of").removesuffix("dozen").strip()
        return {"half a": 6, "a": 12, "": 12}.get(times) or int(12 * number(times))
    return {"NO": 0, "PAIR": 2}[token.type]


def count_range(text: str) -> tuple[int, int]:
    """The fewest and the most that a text such as "20 to 30", "up to 5" or "a few hundred" means."""
    few = next((few for few in _FEW_OF if text.startswith(few)), None)
    if few is not None:
        (each,) = (times for unit, times in _EACH.items() if unit in text)
        return _FEW_OF[few][0] * each, _FEW_OF[few][1] * each
    found = _COUNTS.fullmatch(text)
    assert found is not None
    before, first, second, behind = found.groups()
    values = [int(number(value)) for value in (first, second) if value]
    low, high = min(values), max(values)
    if before.startswith(_AT_MOST) or behind == " or fewer":
        return 1, max(1, high - before.startswith(("fewer", "less", "under")))
    if before.startswith(_AT_LEAST) or behind == " or more":
        return low + before.startswith(("more", "over")), low + max(2, low // 2)
    return low, high


def count_times(count: Count, each: Count) -> Count:
    """So many of each of so many; a word for one of the numbers is one for all of them."""
    if isinstance(count, int) and isinstance(each, int):
        return count * each
    return each if count == 1 else count


def unclear_counts(tokens: list[Token]) -> list[Token]:
    """The words of a noun phrase for its number, if they are no single whole number or range, as "two three"."""
    counts = [token for token in tokens if token.type in COUNT_TYPES]
    # "a row of ten trees": a row counts nothing beside the ten, but two rows would
    collective = [token for token in counts if token.type in ("SOME", "MANY") and token.endswith(" of")]
    if len(counts) == len(collective) + 1 and counts[-1] not in collective:
        counts = counts[-1:]
    vague = bool(counts) and all(token.type in _VAGUE for token in counts)  # "a dense row of"
    clear = vague or (len(counts) == 1 and not _is_fraction(counts[0]))
    return [] if clear else counts


def number(text: str) -> float:
    """The value of a `NUMBER`, in figures or words."""
    whole, _, digits = text.partition(" point ")
    total, part = 0.0, 0.0
    for word in whole.replace(",", "").split():
        if word == "hundred":
            part = (part or 1.0) * 100.0
        elif word in _SCALES:
            total, part = total + (part or 1.0) * _SCALES[word], 0.0
        elif word[0].isdigit():
            part += float(word)
        elif word not in ("a", "and"):
            part += _VALUE_OF[word]
    tenths = "".join(str(_VALUE_OF[word]) for word in digits.split())
    return total + part + (float(f"0.{tenths}") if tenths else 0.0)


def metres(text: str) -> tuple[float, float]:
    """The range [m] in a text such as "20 m", "ten to 30 feet", "within 5 m" or "every 8 metres"."""
    found = _LENGTHS.fullmatch(text)
    assert found is not None
    before, first, second, unit = found.groups()
    values = [number(value) for value in (first, second) if value]
    low, high = min(values) * _METRES_OF[unit], max(values) * _METRES_OF[unit]
    if before.startswith(_AT_MOST):
        return 0.0, high
    if before.startswith(_AT_LEAST):
        return low, low + _FURTHER
    return low, high


def _is_fraction(token: Token) -> bool:
    """Whether it counts in parts of a thing, or from none."""
    if token.type in ("NUMBER", "COUNT_RANGE"):
        return "." in token or " point " in token or (token.type == "COUNT_RANGE" and count_range(token)[0] < 1)
    return False
