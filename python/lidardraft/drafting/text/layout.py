"""A sentence of controlled English becomes a spec, and the spec a layout; offline, and each word is accounted for."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Iterable, Sequence
from functools import cache

from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.scene_spec import SceneSpec, relations
from lidardraft.drafting.text.accounts import gave, idle_parts, says_something
from lidardraft.drafting.text.chart import Node
from lidardraft.drafting.text.clauses import clauses_of
from lidardraft.drafting.text.defaults import spec_of
from lidardraft.drafting.text.doubts import STRANGE, with_doubts
from lidardraft.drafting.text.explanation import Explanation, Meaning
from lidardraft.drafting.text.grammar import UNSHOWN, grammar, parse
from lidardraft.drafting.text.left_over import LeftOver
from lidardraft.drafting.text.lexicon import lexicon, vocabulary
from lidardraft.drafting.text.meaning import mismatches
from lidardraft.drafting.text.parts import divided, part
from lidardraft.drafting.text.scenery import with_scenery
from lidardraft.drafting.text.statements import resolve
from lidardraft.drafting.text.tokens import Token, clean, slip_of, tokens_of
from lidardraft.drafting.text.tree import leaves
from lidardraft.errors import TextError, check_type, nearest_name
from lidardraft.scene.layout import Layout

MAX_LENGTH = 10_000  # characters
MAX_WORDS = 200  # and signs; the sentence is tried without each
_FREE_TEXT = "--llm-url takes free text"
_SHORTEST, _SHORT = 3, 4  # letters; many short words are near to each other
_SETTING = ("weather", "wetness", "road", "setting", "busy", "quiet", "time", "traffic")


def layout_from_text(sentence: str, *, seed: int = 0, strict: bool = False) -> Layout:
    """A checked layout of a sentence; the same for the same sentence and seed.

    Nothing is invented around it: `surround` adds the street that `simulate` puts around a sentence.

    `layout.provenance` holds the sentence, the seed and the spec; "understood" lists the relations found in the
    sentence, a line each. `layout.notes` list the parts that were not understood, have no shape or were corrected, and
    statements that the spec does not hold or the layout does not show.

    Raises `TextError` if nothing was understood or, with `strict`, if any part was not understood or does not hold.
    Raises `LayoutError` if a relation cannot hold, naming it and the obstacles.
    """
    explanation = explain(sentence)
    spec = _strictly(explanation) if strict else explanation.spec
    layout = layout_from_spec(spec, seed=seed)
    if strict and layout.notes:
        raise TextError(f"{'; '.join(layout.notes)}; rephrase it, or take another seed")
    said = {"source": "text", "sentence": sentence, "understood": relations(spec)}
    near = "".join(f"; did you mean {known!r}?" for known in nearest_words(spec.not_understood).values())
    notes = [f"not understood: {', '.join(spec.not_understood)}{near}"] * bool(spec.not_understood)
    notes += [f"not shown: {', '.join(explanation.not_shown)}"] * bool(explanation.not_shown)
    notes += [f"{word!r} is read as {slip!r}" for word, slip in slips(sentence).items()]
    intent = dataclasses.replace(layout.intent, sentence=sentence)
    layout = dataclasses.replace(layout, provenance=layout.provenance | said, intent=intent)
    return layout.noted(*notes, *explanation.mismatches)


def spec_from_text(sentence: str, *, strict: bool = False) -> SceneSpec:
    """The spec of a sentence, with the parts that were not understood.

    Raises `TextError` as above, and on a sentence that is empty or longer than `MAX_LENGTH`.
    """
    explanation = explain(sentence)
    return _strictly(explanation) if strict else explanation.spec


def _strictly(explanation: Explanation) -> SceneSpec:
    unknown = explanation.spec.not_understood
    if unknown:
        raise TextError(f"not understood: {_listed(unknown)}; {_FREE_TEXT}")
    if explanation.mismatches:
        raise TextError(f"{'; '.join(explanation.mismatches)}; rephrase it; {_FREE_TEXT}")
    return explanation.spec


def explain(sentence: str) -> Explanation:
    """The effect of each word of a sentence, with the spec; raises `TextError` as `spec_from_text` does."""
    check_type("sentence", sentence, str)
    if len(sentence) > MAX_LENGTH:
        raise TextError(f"the sentence has {len(sentence)} characters; it may have {MAX_LENGTH}")
    text = clean(sentence)
    if not text:
        raise TextError("the sentence is empty")
    tokens = tokens_of(text, vocabulary())
    if len(tokens) > MAX_WORDS:
        raise TextError(f"the text has {len(tokens)} words and signs; it may have {MAX_WORDS}, more with --llm-url")
    texts = [token.text for token in tokens]
    nodes, idle = _read(tokens, texts)
    found = resolve(clauses_of(list(nodes), texts))
    spec = _spec_of(nodes, texts)
    said = [mention.tokens for _, mention in divided(part(tuple(found.mentions)))]
    idle = [one for one in idle if one.symbol != "ellipsis" or not _names_group(one, said)]
    idle = [one for one in idle if one.symbol != "ordinal" or texts[one.start - 1] != "a"]  # "a third" is one more
    silent = {n for one in idle for n in range(one.start, one.end)}
    sidewalks = (word for node in nodes for word in leaves(node, "sidewalk"))
    silent |= {n for word in sidewalks for n in range(word.start, word.end) if n in found.unfit}
    silent |= found.dropped - found.taken
    given = []
    for index, node in enumerate(nodes):
        run = set(range(node.start, node.end))
        groups = tuple(number for number, its in enumerate(said) if its & run - silent)
        others: tuple[str, ...] = ()
        if not groups and says_something(node) and not silent.issuperset(run):
            groups, others = gave(nodes, index, lambda kept: _without_words(_spec_of(kept, texts)))
            silent |= set() if groups or others else run
        given.append((groups, others))
    left = LeftOver(text, tokens, nodes, silent)
    meanings = []
    for node, (groups, others) in zip(nodes, given, strict=True):
        words = left.said((node.start, node.end - 1))
        if words.strip(",.:();"):
            meanings.append(Meaning(words, groups, others, *left.parts(range(node.start, node.end))))
    unknown, not_shown = left.parts(range(len(tokens)))
    if spec == SceneSpec() and not any(_names_road(node) for node in nodes):
        if not_shown and not unknown:
            shapeless = f"nothing of {sentence!r} was understood that has a shape (not shown: {_listed(not_shown)})"
            raise TextError(f"{shapeless}; name a road, or objects and their places; {_FREE_TEXT}")
        parts = f" (unknown as a whole: {_listed(unknown)})" if unknown else ""
        raise TextError(
            f"nothing of {sentence!r} was understood{parts}; name a road, or objects and their places; {_FREE_TEXT}"
        )
    spec = dataclasses.replace(spec, not_understood=unknown)
    return Explanation(tuple(meanings), spec, not_shown, tuple(mismatches(nodes, texts, spec, silent)))


def _read(tokens: list[Token], texts: list[str]) -> tuple[list[Node], list[Node]]:
    """The constituents of a text, and those without effect."""
    nodes = with_doubts(with_scenery(parse(tokens)), texts)
    return nodes, idle_parts(nodes, grammar(), lambda said: _without_words(_spec_of(said, texts)))


def _names_group(node: Node, groups: Iterable[Collection[int]]) -> bool:
    """Whether a group comes from it; without "a third", its place would be one more of "a second"."""
    if any(leaves(node, "number")):
        return False
    return any(set(range(node.start, node.end)) <= set(tokens) for tokens in groups)


def _names_road(node: Node) -> bool:
    return node.symbol not in STRANGE and any(leaves(node, "road"))


def _spec_of(nodes: Sequence[Node], texts: list[str]) -> SceneSpec:
    found = resolve(clauses_of(list(nodes), texts))
    spec = spec_of(part(tuple(found.mentions)), found.road, texts)
    district, activity, weather = (_setting(nodes, name) for name in ("district", "activity", "weather"))
    return dataclasses.replace(spec, district=district, activity=activity, weather=weather)


def _setting(nodes: Sequence[Node], name: str) -> str | None:
    """The setting named by the words for roads and surroundings; "nothing else" overrides "a quiet street"."""
    seen = (node for node in nodes if node.symbol not in UNSHOWN)  # not "an empty parking space"
    found = [leaf.get(name) for node in seen for leaf in leaves(node, *_SETTING)]
    return "empty" if "empty" in found else next(filter(None, found), None)


def _without_words(spec: SceneSpec) -> SceneSpec:
    return dataclasses.replace(spec, groups=tuple(dataclasses.replace(one, words="") for one in spec.groups))


def slips(sentence: str) -> dict[str, str]:
    """The words of a sentence that are read as others: with letters transposed, one missing, or one too many."""
    words = re.findall(r"[a-z]+", clean(sentence))
    found = {word: slip_of(word, vocabulary()) for word in words}
    return {word: slip for word, slip in found.items() if slip}


def nearest_words(parts: Iterable[str]) -> dict[str, str]:
    """The nearest word of the lexicon for each unknown word of some texts; it never replaces the word."""
    words = {word for part in parts for word in re.findall(r"[^\W\d_]+", part) if _SHORTEST <= len(word) <= 30}
    nouns = _nouns()
    found = {word: _nearest(word, nouns) for word in sorted(words - vocabulary())}
    return {word: near for word, near in found.items() if near}


def _nearest(word: str, nouns: tuple[str, ...]) -> str | None:
    """The noun that a word is a slip of; for short words one with the same letters, transposed."""
    if len(word) > _SHORT:
        return nearest_name(nouns, word)
    slips = (noun for noun in nouns if noun[0] == word[0] and sorted(noun) == sorted(word))
    return next(slips, None)


@cache
def _nouns() -> tuple[str, ...]:
    """The words for objects and roads, the most common first."""
    words = ((first, entries) for first, entries in lexicon().items())
    return tuple(
        first
        for first, entries in words
        if any(parts == (first,) and word.category in ("kind", "road") for parts, word in entries)
    )


def _listed(parts: Iterable[str]) -> str:
    """Words that were not understood, with their likely meanings."""
    near = nearest_words(parts)
    meant = f" (nearest words: {', '.join(f'{known!r} for {word!r}' for word, known in near.items())})" if near else ""
    return ", ".join(map(repr, parts)) + meant
