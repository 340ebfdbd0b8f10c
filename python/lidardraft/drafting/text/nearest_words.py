"""The word of the grammar that is nearest to an unknown one: told, never taken for it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache

from lark import Lark

from lidardraft.errors import nearest_name

_SHORTEST = 4  # letters; shorter words are near to too many
_LIKENESS = 0.75  # of two words, by `nearest_name`: a letter in four may be wrong
_WITHOUT_MEANING = ("COMPOUND", "GLUE", "UNKNOWN")


def nearest_words(parts: Iterable[str], grammar: Lark) -> dict[str, str]:
    """For each word of some texts that a word of the grammar is near to: that one."""
    words = {word for part in parts for word in re.findall(r"[a-z]+", part) if _SHORTEST <= len(word) <= 30}
    known = _vocabulary(grammar)
    found = {word: nearest_name(known, word, _LIKENESS) for word in sorted(words - set(known))}
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
