"""A sentence of controlled English becomes a spec, and the spec a layout; offline, and no word of it is lost."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from lark import Lark

from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.scene_spec import SceneSpec, relations
from lidardraft.drafting.text.number_words import LONE_NUMBER, NUMBER, NUMBERED_COMPOUND, UNIT
from lidardraft.drafting.text.sentence_chunks import KIND_OF, chunks_of
from lidardraft.drafting.text.sentence_reader import SentenceReader
from lidardraft.drafting.text.setting import with_setting
from lidardraft.errors import TextError, check_type, nearest_name
from lidardraft.scene.layout import Layout

MAX_LENGTH = 10_000  # characters
_SHORTEST = 4  # letters; shorter words are near to too many
_WITHOUT_MEANING = ("COMPOUND", "GLUE", "UNKNOWN")
_WEATHER = re.compile(r"\b(?:rain|fog|snow|drizzl|mist|wet\b|hail|sleet|downpour|storm)")


def layout_from_text(sentence: str, seed: int = 0, *, strict: bool = False) -> Layout:
    """A checked layout of what the sentence says; the same for the same sentence and seed.

    `layout.provenance` holds the sentence, the seed and the spec, and
    - "understood": the relations that the sentence was read as, a line each;
    - "not_understood": the words that changed nothing, and "nearest_words": known words that some of them are near to;
    - "objects": for each object the number of its group in the spec, whose "words" asked for it;
    - "notes": where weather is asked for, what it is an option of.

    Raises `TextError` where nothing was understood or, with `strict`, anything was not; `LayoutError` where a relation
    cannot hold, naming it and what is in the way.
    """
    spec = spec_from_text(sentence, strict=strict)
    layout = layout_from_spec(spec, seed=seed)
    said = {
        "source": "text",
        "sentence": sentence,
        "understood": relations(spec),
        "not_understood": list(spec.not_understood),
        "nearest_words": nearest_words(spec.not_understood, grammar()),
    }
    if any(_WEATHER.search(part) for part in spec.not_understood):
        said["notes"] = ["weather is no part of a layout; `simulate` takes it, as in --weather rain:10mm"]
    return dataclasses.replace(layout, provenance=layout.provenance | said)


def spec_from_text(sentence: str, *, strict: bool = False) -> SceneSpec:
    """The spec that a sentence describes, with what was not understood of it.

    Raises `TextError` as above, and on a sentence that is empty or longer than `MAX_LENGTH`.
    """
    check_type("sentence", sentence, str)
    if len(sentence) > MAX_LENGTH:
        raise TextError(f"the sentence has {len(sentence)} characters; it may have {MAX_LENGTH}")
    text = _normalised(sentence)
    if not text:
        raise TextError("the sentence is empty")
    notes = SentenceReader(text, chunks_of(grammar().parse(_unhyphened(text)))).read()
    if notes.empty:
        parts = f" (unknown as a whole: {_listed(notes.not_understood)})" if notes.not_understood else ""
        raise TextError(f"nothing of {sentence!r} was understood{parts}; name a road, or objects and where they are")
    spec = with_setting(notes.spec(), text)
    if strict and spec.not_understood:
        raise TextError(f"not understood: {_listed(spec.not_understood)}")
    return spec


@cache
def grammar() -> Lark:
    """The parser of sentences: `english.lark` with the kinds of objects and the patterns of numbers."""
    rules = Path(__file__).with_name("english.lark").read_text(encoding="utf-8")
    rules += f"\n_object: {' | '.join(KIND_OF)}\nNUMBER: /{LONE_NUMBER}/\n_NUMBER: /{NUMBER}/\nUNIT: /{UNIT}/\n"
    return Lark(rules, parser="lalr", lexer="basic", maybe_placeholders=False)


def nearest_words(parts: Iterable[str], grammar: Lark) -> dict[str, str]:
    """For each word of some texts that a word of the grammar is near to: that one, which is never taken for it."""
    words = {word for part in parts for word in re.findall(r"[a-z]+", part) if _SHORTEST <= len(word) <= 30}
    known = _vocabulary(grammar)
    found = {word: nearest_name(known, word) for word in sorted(words - set(known))}
    return {word: near for word, near in found.items() if near}


@cache
def _vocabulary(grammar: Lark) -> tuple[str, ...]:
    """The words of the grammar that are spelled out in its terminals, in the singular and the plural."""
    words = set()
    for terminal in grammar.terminals:
        pieces = re.split(r"[|()/]", terminal.pattern.value) if terminal.name not in _WITHOUT_MEANING else ()
        for piece in pieces:
            found = re.fullmatch(r"([a-z]{3,})(s\?)?(?:\\b)?", piece.strip())
            if found and len(found[1]) + bool(found[2]) >= _SHORTEST:
                words |= {found[1], found[1] + "s"} if found[2] else {found[1]}
    return tuple(sorted(words))


def _listed(parts: Iterable[str]) -> str:
    """Words that were not understood, with what may have been meant."""
    near = nearest_words(parts, grammar())
    meant = f" (nearest words: {', '.join(f'{known!r} for {word!r}' for word, known in near.items())})" if near else ""
    return ", ".join(map(repr, parts)) + meant


def _normalised(sentence: str) -> str:
    """Lower case but for names such as "car A", single blanks, also for what cannot be printed; symbols as words."""
    text = "".join(
        part if index % 2 else part.lower() for index, part in enumerate(_NAME.split(_UNIT_STOP.sub(r"\1", sentence)))
    )
    text = _LIST_ITEM.sub("; ", text)
    if max(map(len, text.splitlines()), default=0) <= _LONGEST_ITEM:
        text = text.strip().replace("\n", "; ")
    text = "".join(character if character.isprintable() else " " for character in text)
    for symbol, plain in _PLAIN.items():
        text = text.replace(symbol, plain)
    for pattern, spelling in _SPELLINGS:
        text = pattern.sub(spelling, text)
    return " ".join(text.split())


def _each_length(found: re.Match[str]) -> str:
    """Each of some lengths with its unit, as in "at 10, 20 and 30 m"."""
    unit = found[4]
    return " and at ".join(f"{value} {unit}" for value in (found[1], *re.findall(r"\d+", found[2]), found[3]))


def _same_unit(found: re.Match[str]) -> str:
    """A length with the unit of the one before it, as in "the first is 10 m ahead, the second 20"."""
    units = re.findall(rf"\d ?({UNIT})", found.string[: found.start()])
    return f"{found[1]} {found[2]} {units[-1]}" if units else found[0]


def _unhyphened(text: str) -> str:
    """With blanks for hyphens, but for those in ranges and in words such as "ten-ton"."""
    return " ".join(
        word if NUMBERED_COMPOUND.search(word) else re.sub(r"(?<=[a-z0-9])-(?=[a-z])", " ", word)
        for word in text.split(" ")
    )


_PLAIN = {
    **{"\u2019": "'", "\u2013": "-", "\u2014": ", ", "\u2026": ". ", "\u00d7": "x", "&": " and ", " + ": " and "},
    **{"w/o ": "without ", "w/ ": "with "},
}
_NAME = re.compile(
    r"(?<=[a-z] )([A-HJKM-QSU-Z])(?=[,.;:!?)]|$|'s\b| (?![A-Z]))"
)  # as in "car A"; L and R are sides, T is a junction
_UNIT_STOP = re.compile(r"(\d ?(?:m|ft|yd|km))\.(?= [a-z])")  # "10 m. ahead", but not "10 m. A bus"
_ORDINALS = ("last", "first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")  # by number
_LONGEST_ITEM = 40  # characters of a line, in a text that has one for each object
_EXTENT, _LENGTH = r"\b(height|length|width)", rf"\d[\d.]* ?{UNIT}"
_LIST_ITEM = re.compile(r"(?:^|\n)\s*(?:[-*\u2022]|\d{1,2}[.)]) (?=\S)")  # of one that has a line for each
_SPELLINGS = (
    (re.compile(r"@ ?(?=\d)"), " at "),
    (re.compile(r"~ ?(?=\d)"), "about "),
    (re.compile(r"(?:>=|\u2265) ?(?=\d)"), "at least "),
    (re.compile(r"(?:<=|\u2264) ?(?=\d)"), "at most "),
    (re.compile(r"> ?(?=\d)"), "more than "),
    (re.compile(r"< ?(?=\d)"), "less than "),
    (
        re.compile(rf"(?:\b(?:with|has|having) )?(?:\b(?:an?|its) )?(?<!lane ){_EXTENT}(?:: ?| ?= ?| of )({_LENGTH})"),
        r"\2 in \1",
    ),
    (re.compile(rf"(?<=, ){_EXTENT} ({_LENGTH})"), r"\2 in \1"),  # "a wall, height 2 m"
    (re.compile(r"(?<=[a-z]) ?/ ?(?=(?:direction|dir|way|side|lane)\b)"), " per "),
    (re.compile(r"\bper dir\b\.?"), "per direction"),
    (
        re.compile(
            rf"(?<!between )(?<!from )\b(\d+)((?:, ?\d+)*),? and (\d+) ?({UNIT})(?! (?:apart|long|high|tall|wide))"
        ),
        _each_length,
    ),
    (
        re.compile(r"\b(the (?:second|third|fourth|fifth|last)(?: one)?(?: at| is)?) (\d+)(?=[,;]| and\b|\.(?!\d)|$)"),
        _same_unit,
    ),
    (re.compile(r"(?<=\d) - (?=\d)"), "-"),
    (re.compile(rf"(\d) ?({UNIT})(?: to | ?- ?)(?=\d[\d.,]* ?\2)"), r"\1 to "),  # "10 m to 20 m"
    (re.compile(rf"\b(between \d[\d.,]*) ?({UNIT}) and (?=\d[\d.,]* ?\2)"), r"\1 and "),
    (re.compile(r" - "), ", "),
    (re.compile(r"\band/or\b"), "or"),
    (re.compile(r"(?<=[a-z]) ?/ ?(?=[a-z\d])(?![hs]\b)"), ", "),  # "cars/trucks", but not "km/h"
    (re.compile(r"\b(there|it|that|here|who)'s\b"), r"\1 is"),
    (re.compile(r"\b(i|we|you|they)'(?:m|re|ve|d|ll)\b"), r"\1"),
    (re.compile(r"\bcan(?: ?not|'t) (?=see\b)"), "can "),
    (re.compile(r"(?<!in )(?<!the )\bfront: "), "in front "),
    (re.compile(r"(?<!the )\b(?:rear|back): "), "behind "),
    (re.compile(r"(?<!\bon the )\b(left|right|ahead|behind|front|sides?|back|rear|background|foreground): "), r"\1 "),
    (re.compile(r"\b(?:nobody|no one|no body)\b(?! way)"), "no people"),
    (
        re.compile(
            r"\bnothing (?=(?:is )?(?:ahead|behind|in|on|to|next|parked|coming)\b)(?![^.;,]*\b(?:but|except)\b)"
        ),
        "no vehicles ",
    ),
    (re.compile(r"\b(left|right)(?: side)?,? (?:there is )?nothing(?: at all)?(?=[.;,]|$)"), r"\1 no vehicles"),
    (re.compile(r"\b(?:on|to|at) (?:its|his|her|their) (left|right)(?: (?:hand )?side)?\b"), r"to the \1 of it"),
    (
        re.compile(r"\b(?:some|a little|a short) (?:way|distance) (?=(?:back |away )?from the (?:road|str))"),
        "5 to 15 m ",
    ),
    (
        re.compile(r"\b(the|before|behind|of|beside|next to|opposite|under) (\d)(?:st|nd|rd|th)\b"),
        lambda found: f"{found[1]} {_ORDINALS[int(found[2])]}",
    ),
    (re.compile(rf"\b(before|behind|of|beside|next to|opposite|under) (?={'|'.join(_ORDINALS)}\b)"), r"\1 the "),
    (re.compile(r'"([^"]{1,30})"(?= signs?\b)'), r"\1"),  # a "no entry" sign
    (re.compile(rf"\ba (?:family|party|team|gang) of ({NUMBER})\b(?: people)?"), r"\1 people"),
    (re.compile(r"\ba dozen or so\b"), "12 or so"),
    (re.compile(r"(?<=[a-z]{2}): ?(?=\d)"), ": "),
    (re.compile(r"(?<=[a-z]{2})(?: ?= ?| \(?x ?| ?\()(?=\d)"), ", "),  # "cars = 3", "cars x3", "cars (3)"
    (re.compile(r"(?<![\w.,-])(\d{1,9}) ?x (?=[a-z]{2})"), r"\1 "),  # "2x cars"
    (re.compile(r"(?<=\d) ?\("), " "),  # "3 (parked)"
    (re.compile(r" ?[()]"), ", "),
)
