"""A text becomes tokens, and words and figures become numbers.

A number is read whole or not at all: figures that do not form a single number are one token without meaning.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import NamedTuple

_BELOW_TWENTY = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"),
    *("thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen"),
)
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_SCALES = {"thousand": 1e3, "million": 1e6, "billion": 1e9}
_VALUE_OF = {word: value for value, word in enumerate(_BELOW_TWENTY)} | {
    word: 20 + 10 * index for index, word in enumerate(_TENS)
}
_ORDINALS = ("last", "first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")  # by number

# Floats hold fifteen digits exactly; longer figures are not numbers here.
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
NUMBER = re.compile(rf"(?:{_in_words}|{_figures}|zero)(?= |$)")
_UNIT = r"(?:(?:kilo|centi)?met(?:re|er)s?|km|cm|m|feet|foot|ft|yards?|yd|inch(?:es)?)\b(?!\/)"
NUMBER_WORDS = (*_VALUE_OF, "hundred", *_SCALES)
_word = rf"(?:{'|'.join((*_VALUE_OF, 'hundred', *_SCALES))})"
_goes_on = rf"(?:(?:{_word}|dozen|and|to|or|point|lanes?|ways?|wheelers?|store?y|storeys|doors?)\b|{_UNIT})"

_SYMBOLS = {
    **{"\u2019": "'", "\u2018": "'", "\u201c": '"', "\u201d": '"', "\u2013": "-", "\u2014": " ; ", "\u2026": " . "},
    **{"\u00d7": "x", "\u2265": ">=", "\u2264": "<="},
}
_SPELLED = {"@": " at ", "~": " about ", ">=": " at least ", "<=": " at most ", ">": " more than ", "<": " less than "}
_SAID = {"&": "and", "+": "and", "w/o": "without", "w/": "with", "and/or": "or", "=": ":"}
_TOKEN = re.compile(
    rf"""(?P<word>w/o\b|w/(?=\s)|and/or\b)
    |(?P<pace>{_figures}(?=\ ?(?:km/h|m/s|mph|kph)\b)|\b(?:km/h|m/s))
    |(?P<compound>(?<![a-z0-9])(?:{_word}-)*(?:{_word}|[\d.,]*\d)-(?!{_goes_on})[a-z][a-z-]*)
    |(?P<nth>\b\d(?=(?:st|nd|rd|th)\b)(?:st|nd|rd|th))
    |(?P<figure>(?<!\d:)(?!\d{{1,2}}:\d)(?:(?<![\w.,'/+-])|(?<=\d-)|(?<=\ x)|(?<=\(x)){_figures}
        (?=(?:\ ?x)?(?:\s|[;:!?)("\]]|[.,](?!\d)|$)|-(?=[a-z0-9])|\ ?{_UNIT}|/[a-z]))
    |(?P<times>(?<=\d)\ ?x(?=\s)|x(?=\d+(?:\s|$|[,.;)])))
    |(?P<hyphen>(?<=[a-z0-9])-(?=[a-z0-9]))
    |(?P<strange>(?=[^\s,;:!?()"]*\d)(?:[^\s,;:!?()"]|,(?=\d))*[^\s,.;:!?()"])
    |(?P<hyphened>[^\W\d_]+(?:-[^\W\d_]+)+)
    |(?P<quote>["\u201c\u201d])
    |(?P<letters>[^\W\d_]+(?:'[^\W\d_]+)?)
    |(?P<dash>(?<=\s)-(?=\s))
    |(?P<symbol>[&+=])
    |(?P<stop>[.;!?]+(?!\d))
    |(?P<other>\S)""",
    re.VERBOSE,
)  # fmt: skip
_OF_LANES = re.compile(r" (?:dir|way|side|lane)|-")  # "two lanes per direction"
_LETTERS = "abcdefghijklmnopqrstuvwxyz"
_SHORTEST_SLIP, _LONG_SLIP = 5, 8  # letters
_SUBJECTS = ("there", "it", "that", "here", "who", "i", "we", "you", "they", "he", "she")
_NAME = re.compile(r"(?<=[a-z] )([A-HJKM-QSU-Z])(?=[,.;:!?)]|$|'s\b| (?![A-Z]))")  # "car A"; L and R are sides


class Token(NamedTuple):
    """A word in lower case, or a sign; `start` and `end` are its place in the text."""

    text: str
    start: int
    end: int
    is_strange: bool = False  # figures that are not a number


def clean(text: str) -> str:
    """The text in lower case except for names, with blanks for unprintable characters."""
    for symbol, plain in _SYMBOLS.items():
        text = text.replace(symbol, plain)
    for symbol, plain in _SPELLED.items():
        text = re.sub(rf"{symbol} ?(?=\d)", plain, text)
    names = {found.start() for found in _NAME.finditer(text)}
    kept = (c if c.isprintable() or c == "\n" else " " for c in text)
    lower = "".join(c if index in names else c.lower() for index, c in enumerate(kept))
    lines = [" ".join(line.split()) for line in lower.split("\n")]
    lines = [re.sub(r"^(?:[-*\u2022]|\d{1,2}[.)]) (?=\S)", "; ", line) for line in lines]
    apart = max(map(len, lines), default=0) <= _LONGEST_ITEM
    return (" ; " if apart else " ").join(lines).strip(" ;")


_LONGEST_ITEM = 40  # characters of a line, in a text with a line for each object


def tokens_of(text: str, vocabulary: Collection[str]) -> list[Token]:
    """The tokens of a text that is `clean`; words with hyphens are split if the vocabulary has all their parts."""
    found: list[Token] = []
    for match in _TOKEN.finditer(text):
        start, end, said = match.start(), match.end(), match[0]
        match match.lastgroup:
            case "hyphen":
                if said == "-" and text[start - 1].isdigit() and text[end].isdigit():
                    found.append(Token("to", start, end))
            case "dash":
                between = found and found[-1].text[-1:].isdigit() and text[end:].lstrip()[:1].isdigit()
                found.append(Token("to" if between else ",", start, end))
            case "compound" | "strange":
                found.append(Token(said, start, end, is_strange=True))
            case "symbol" | "word":
                found += [Token(word, start, end) for word in _SAID[said].split()]
            case "nth":
                found.append(Token(_ORDINALS[int(said[0])], start, end))
            case "times" | "quote":
                continue
            case "stop":
                found.append(Token(".", start, end))
            case "hyphened":
                parts = [(one.start(), one[0]) for one in re.finditer(r"[^-]+", said)]
                if all(part in vocabulary for _, part in parts):
                    found += [Token(part, start + at, start + at + len(part)) for at, part in parts]
                else:
                    found.append(Token(said, start, end))
            case "letters" if said == "per" and not _OF_LANES.match(text, match.end()):
                found += [Token("for", start, end), Token("each", start, end)]
            case "letters":
                found += _letters(slip_of(said, vocabulary) or said, start, start + len(said))
            case "other" if said == "/":
                found.append(Token("per" if text[end:].startswith(("dir", "way", "side", "lane")) else ",", start, end))
            case _:
                found.append(Token(said, start, end))
    return found


def slip_of(word: str, vocabulary: Collection[str]) -> str | None:
    """The only word of the vocabulary with two letters transposed or, for long words, one letter missing or too many.

    No letter replaces another: "horse" and "house" are both words.
    """
    if word in vocabulary or len(word) < _SHORTEST_SLIP or not word.isalpha():
        return None
    cuts = range(len(word))
    near = {word[:n] + word[n + 1 : n + 2] + word[n] + word[n + 2 :] for n in cuts}
    if len(word) >= _LONG_SLIP:
        near |= {word[:n] + word[n + 1 :] for n in cuts}
        near |= {word[:n] + letter + word[n:] for n in range(len(word) + 1) for letter in _LETTERS}
    known = [one for one in near if one in vocabulary]
    return known[0] if len(known) == 1 else None


def _letters(said: str, start: int, end: int) -> list[Token]:
    """A word, or the two words of a contraction."""
    word, mark, ending = said.partition("'")
    if said.endswith("n't"):
        return [Token(said.removesuffix("n't") or "not", start, end), Token("not", start, end)]
    if mark and word in _SUBJECTS:
        return [Token(word, start, end)] + ([Token("is", start, end)] if ending == "s" else [])
    if said in ("driver's", "passenger's", "ego's", "robot's"):
        return [Token(said, start, end)]
    return [Token(said, start, end, is_strange=bool(mark))]


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
