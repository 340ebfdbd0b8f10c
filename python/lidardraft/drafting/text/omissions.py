"""What a text names and a reply to it does not hold: nouns with their numbers, by the words of the lexicon alone."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence

from lidardraft.drafting.text.chart import Node
from lidardraft.drafting.text.grammar import parse
from lidardraft.drafting.text.lexicon import vocabulary
from lidardraft.drafting.text.tokens import clean, tokens_of
from lidardraft.drafting.text.tree import NounPhrase, leaves, noun_phrase

_MOST = 200  # words that are read at once
# The groups that a phrase may name, each with its least and most objects; NaN and infinity for "some" and the like.
Held = Callable[[NounPhrase], Sequence[tuple[float, float]]]


def omissions(text: str, held: Held) -> list[str]:
    """A line for each noun phrase of an English text for which a reply, as `held` reads it, has no object, too few or
    another number; none for a text of which the lexicon knows no more than half of the words."""
    tokens, notes, needed = tokens_of(clean(text), vocabulary()), list[str](), Counter[str]()
    texts = [token.text for token in tokens]
    known = sum(word in vocabulary() or word.isdigit() for word in texts)
    counts = not {"each", "every", "per"}.intersection(texts)  # "two trees in front of each house"
    for first in range(0, len(tokens) if 2 * known > len(tokens) else 0, _MOST):
        for node, phrase in _named(parse(tokens[first : first + _MOST])):
            groups, kind = held(phrase), str(phrase.kind)
            least, most = (sum(group[end] for group in groups) for end in (0, 1))
            count = phrase.count if isinstance(phrase.count, int) and phrase.part is None else 0
            needed[kind] += 0 if phrase.definite or phrase.name else count
            same = any(low <= count <= high for low, high in [*groups, (least, most)])
            if not groups or most < needed[kind] or (counts and phrase.exact and not (same or phrase.part)):
                number = "some" if math.isnan(least) else f"{least if most == math.inf else most:g}"
                words = " ".join(texts[first + node.start : first + node.end])
                has = f"{kind}: {number}" if groups else f"no {kind}"
                notes.append(f"the sentence names {words!r}; the reply has {has}")
    return list(dict.fromkeys(notes))


def _named(nodes: Sequence[Node]) -> Iterator[tuple[Node, NounPhrase]]:
    """The noun phrases, without those that are denied ("no cars or buses"), are counted before ("the third car"), or
    may be the ego vehicle ("the car")."""
    denied = -2  # where the last denied one ends
    for one in (leaf for node in nodes for leaf in leaves(node, "object")):
        phrase = noun_phrase(one)
        if phrase.count == 0 or (one.start == denied + 1 and not phrase.determiners):
            denied = one.end
        elif phrase.kind and phrase.ordinal is None and (phrase.exact or not (phrase.plain and phrase.definite)):
            yield one, phrase
