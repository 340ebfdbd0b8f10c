"""The word of the grammar that is nearest to an unknown one: told, never taken for it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache

from lark import Lark

_SHORTEST = 4  # letters; shorter words are near to too many
_LETTERS_PER_ERROR = 8  # of so many letters one may be wrong, missing, too much or swapped with the next
_WITHOUT_MEANING = ("COMPOUND", "GLUE", "UNKNOWN")


def nearest_words(parts: Iterable[str], grammar: Lark) -> dict[str, str]:
    """For each word of some texts that a word of the grammar is near to: that one."""
    words = {word for part in parts for word in re.findall(r"[a-z]+", part) if _SHORTEST <= len(word) <= 30}
    near = {}
    for word in sorted(words - set(_vocabulary(grammar))):
        limit = 2 + (len(word) - 1) // _LETTERS_PER_ERROR
        alike = [known for known in _vocabulary(grammar) if abs(len(known) - len(word)) < limit]
        errors, nearest = min(((_errors(word, known), known) for known in alike), default=(limit, ""))
        if errors < limit:
            near[word] = nearest
    return near


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


def _errors(one: str, other: str) -> int:
    """How many letters must be changed, left out, added or swapped with the next (optimal string alignment)."""
    before: list[int] = []
    row = list(range(len(other) + 1))
    for i, a in enumerate(one, start=1):
        earlier, before, row = before, row, [i]
        for j, b in enumerate(other, start=1):
            least = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (a != b))
            if i > 1 and j > 1 and a == other[j - 2] and one[i - 2] == b:
                least = min(least, earlier[j - 2] + 1)
            row.append(least)
    return row[-1]
